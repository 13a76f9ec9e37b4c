/* Block elimination along a line of nodes of six unknowns, on one rank; see elimination.h. */
#ifndef TENDRIL_LINE_H
#define TENDRIL_LINE_H

#include <petscsys.h>
#include <petscblaslapack.h>

enum { LINE_FIELDS = 6, LINE_HALF = 3 };

typedef PetscReal LineSquare[LINE_HALF][LINE_HALF];
typedef PetscReal LineRows[LINE_HALF][LINE_FIELDS];          /* three equations of a node */
typedef const PetscReal LineBlock[LINE_FIELDS][LINE_FIELDS]; /* six of a cell by one of its nodes */

/* A node and the cell behind it. */
typedef struct {
  LineRows T;         /* (V, W), until the node is eliminated: then the factors of S, and W Q^-1 */
  int row[LINE_HALF]; /* of S, in the order of the pivots */
  LineSquare Q, P;    /* the inverse of Q */
  LineRows X, U;
} LineLink;

typedef struct {
  PetscInt n;                                /* cells so far */
  LineLink *link;                            /* n + 1 */
  LineRows own;                              /* the last node's own equations */
  PetscReal last[LINE_FIELDS * LINE_FIELDS]; /* factors of the last node, whose own equations are
                                                any */
  PetscBLASInt pivots[LINE_FIELDS];
  PetscBool regular;
} Line;

PetscErrorCode LineCreate(PetscInt nodes, Line *line);
PetscErrorCode LineDestroy(Line *line);
void LineBegin(Line *line, const LineRows T);
void LineCell(Line *line, LineBlock a, LineBlock b);
void LineEnd(Line *line, const LineRows own);
void LineForward(const Line *line, PetscInt nodes, const PetscReal (*b)[LINE_FIELDS],
                 const PetscReal behind[], PetscReal (*x)[LINE_FIELDS], PetscReal beyond[]);
void LineBackward(const Line *line, const PetscReal y[], PetscReal (*x)[LINE_FIELDS]);
void LineSolve(const Line *line, const PetscReal (*b)[LINE_FIELDS], PetscReal (*x)[LINE_FIELDS]);
/* What an index is, or less, of a line in which something is no number: of a wild state. */
static const PetscInt line_unknown = -10000;

PetscInt LineIndex(const Line *line, PetscReal sign, const int pair[LINE_HALF]);
PetscInt LineIndexOfArrival(const Line *line, const LineRows T, PetscReal sign,
                            const int pair[LINE_HALF]);
PetscInt LineIndexOfNode(const Line *line, PetscInt i, const LineRows T, const int pair[LINE_HALF]);
PetscInt LineIndexOfEnd(const Line *line, const int pair[LINE_HALF]);
void LineDivide(const LineLink *link, const LineRows M, LineRows X);
void LineSubtractProduct(const LineRows M, const LineRows U, LineRows C);

#endif

/* A table from a file: of options, a column an option, a row a run; or of anything else. */
#ifndef TENDRIL_TABLE_H
#define TENDRIL_TABLE_H

#include "base/options.h"

typedef struct _Table *Table;

PetscErrorCode TableRead(const char *option, const char *path, Table *table);
PetscErrorCode TableReadPlain(const char *option, const char *path, Table *table);
PetscErrorCode TableDestroy(Table *table);
PetscInt TableRows(Table table);
PetscInt TableColumns(Table table);
const char *TableName(Table table, PetscInt column);
const char *TableCell(Table table, PetscInt row, PetscInt column);
PetscErrorCode TableQuantity(const char *what, Table table, PetscInt row, PetscInt column,
                             Dimension dimension, PetscReal *value);
PetscErrorCode TableQuantities(const char *option, const char *path, Table table, PetscInt column,
                               Dimension dimension, PetscReal value[]);
PetscBool TableNumber(const char *cell, PetscReal *value);
void TableMark(Table table, char mark[17]);
void TableRowName(Table table, PetscInt row, char *name, size_t length);

#endif

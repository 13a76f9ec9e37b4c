/* A table of options: what is read of a file, and what is refused.
   test: a table of options is read and what is wrong in it refused | ranks 1 2 */
#include "harness.h"
#include "base/table.h"
#include <math.h>

/* The bytes as a file, the same name on all ranks. */
static void Write(char path[64], const char *bytes, size_t n) {
  PetscMPIInt rank;
  OpenScratch(path);
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (!rank) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
  }
  MPI_Barrier(PETSC_COMM_WORLD);
}

/* Reads a text; the caller destroys the table. Returns the line of a refusal, or NULL. */
static const char *Read(const char *path, Table *table) {
  static ErrorState errors;
  PetscErrorCode error;

  CHECK(ErrorsBegin(PETSC_COMM_WORLD, PETSC_TRUE, &errors));
  *table = NULL;
  error = TableRead("-sweep_file", path, table);
  CHECK(ErrorsEnd());
  MPI_Bcast(errors.message, (int)sizeof(errors.message), MPI_CHAR, 0, PETSC_COMM_WORLD);
  EXPECT(!error == !errors.message[0], "error %d, line: %s", (int)error, errors.message);
  return error ? errors.message : NULL;
}

static void ExpectRefusal(const char *text, const char *words) {
  char path[64];
  const char *line;
  Table table;

  Write(path, text, strlen(text));
  line = Read(path, &table);
  EXPECT(line && strstr(line, words) && strstr(line, path), "of %s: %s, no %s in it", text,
         line ? line : "nothing", words);
  CHECK(TableDestroy(&table));
  RemoveFile(path);
}

static void ExpectCell(Table table, PetscInt row, PetscInt column, const char *text) {
  EXPECT(!strcmp(TableCell(table, row, column), text), "row %d, column %d: %s, not %s", (int)row,
         (int)column, TableCell(table, row, column), text);
}

static Table Sound(const char *text) {
  char path[64];
  const char *line;
  Table table;

  Write(path, text, strlen(text));
  line = Read(path, &table);
  EXPECT(!line, "of %s: %s", text, line);
  RemoveFile(path);
  return table;
}

static void TestPlain(void **state) {
  Table table = Sound("friction_mu,-rod_cells\n0.5,20\n1,30");

  EXPECT(TableRows(table) == 2 && TableColumns(table) == 2, "%d rows, %d columns",
         (int)TableRows(table), (int)TableColumns(table));
  EXPECT(!strcmp(TableName(table, 0), "friction_mu") && !strcmp(TableName(table, 1), "rod_cells"),
         "%s, %s", TableName(table, 0), TableName(table, 1));
  ExpectCell(table, 0, 0, "0.5");
  ExpectCell(table, 0, 1, "20");
  ExpectCell(table, 1, 0, "1");
  ExpectCell(table, 1, 1, "30");
  CHECK(TableDestroy(&table));
}

/* A mark of the order of bytes, ends of lines as elsewhere, comments, blanks, quotes, empty cells.
 */
static void TestOddButSound(void **state) {
  Table table =
      Sound("\xef\xbb\xbf# by hand\r\n\r\n friction_mu , friction_layers,tip_force\r\n"
            "0.5,\"0:1,3:2\", 1 \r\n  # between\r\n,\"say \"\"so\"\"\" ,\r\n\"\",, 3\r\n");
  char name[64];

  EXPECT(TableRows(table) == 3 && TableColumns(table) == 3, "%d rows", (int)TableRows(table));
  ExpectCell(table, 0, 1, "0:1,3:2");
  ExpectCell(table, 0, 2, "1");
  ExpectCell(table, 1, 0, "");
  ExpectCell(table, 1, 1, "say \"so\"");
  ExpectCell(table, 1, 2, "");
  ExpectCell(table, 2, 0, "");
  ExpectCell(table, 2, 2, "3");
  TableRowName(table, 0, name, sizeof(name));
  EXPECT(!strcmp(name, "friction_mu=0.5__friction_layers=0:1,3:2__tip_force=1"), "%s", name);
  TableRowName(table, 2, name, sizeof(name));
  EXPECT(!strcmp(name, "tip_force=3"), "%s", name);
  TableRowName(table, 0, name, 12);
  EXPECT(strlen(name) == 11, "%s", name);
  CHECK(TableDestroy(&table));
}

/* An empty cell at the very end of the file. */
static void TestEndsInNothing(void **state) {
  Table table = Sound("friction_mu,tip_force\n1,");

  EXPECT(TableRows(table) == 1, "%d rows", (int)TableRows(table));
  ExpectCell(table, 0, 1, "");
  CHECK(TableDestroy(&table));
}

/* A unit behind a name goes behind the numbers below it. */
static void TestUnitsOfHeadings(void **state) {
  Table table = Sound("growth_initial_length (mm),-rod_weight [N/m],friction_mu\n"
                      "20,\"0,0.1,-2e3\",0.5\n2cm,\"0,1mN/m\",\n,,1\n"),
        same = Sound("growth_initial_length,rod_weight,friction_mu\n"
                     "20mm,\"0N/m,0.1N/m,-2e3N/m\",0.5\n2cm,\"0N/m,1mN/m\",\n,,1\n");
  char mark[2][17];

  EXPECT(!strcmp(TableName(table, 0), "growth_initial_length"), "%s", TableName(table, 0));
  EXPECT(!strcmp(TableName(table, 1), "rod_weight"), "%s", TableName(table, 1));
  ExpectCell(table, 0, 0, "20mm");
  ExpectCell(table, 0, 1, "0N/m,0.1N/m,-2e3N/m");
  ExpectCell(table, 0, 2, "0.5");
  ExpectCell(table, 1, 0, "2cm");
  ExpectCell(table, 1, 1, "0N/m,1mN/m");
  ExpectCell(table, 2, 0, "");
  TableMark(table, mark[0]);
  TableMark(same, mark[1]);
  EXPECT(!strcmp(mark[0], mark[1]), "%s, %s", mark[0], mark[1]);
  CHECK(TableDestroy(&table));
  CHECK(TableDestroy(&same));
  ExpectRefusal("friction_mu (mm)\n1\n", "-friction_mu has no unit; take (mm) out of its heading");
  ExpectRefusal("rod_cells [1/m]\n9\n", "-rod_cells has no unit; take (1/m) out of its heading");
  ExpectRefusal("growth_inital_length (mm)\n1\n", "did you mean -growth_initial_length?");
}

static void TestRefused(void **state) {
  char path[64];
  Table table;
  const char *line;

  ExpectRefusal("", "is empty");
  ExpectRefusal("\n \n# nothing\n", "is empty");
  ExpectRefusal("friction_mu\n", "has no row");
  ExpectRefusal("friction_mu,rod_cells\n1,2\n\n1\n", "line 4 has 1 cells, its header has 2");
  ExpectRefusal("friction_mu;rod_cells\n0,1;2\n",
                "line 2 has 2 cells, its header has 1; cells are separated by commas");
  ExpectRefusal("friction_mu\n\"1\n2\n", "a quote is not closed (line 2)");
  ExpectRefusal("friction_mu\n\"1\"2\n", "behind a quote (line 2)");
  ExpectRefusal("friction_mu,\n1,2\n", "column 2 has no name");
  ExpectRefusal("friction_mu,-friction_mu\n1,2\n", "has -friction_mu twice");
  ExpectRefusal("frictoin_mu\n1\n", "did you mean -friction_mu?");
  ExpectRefusal("0.5\n1\n", "-0.5: unknown option; -help lists them");
  ExpectRefusal("output\na.h5\n", "-output is of the sweep as a whole");
  ExpectRefusal("restart\na.h5\n", "-restart is of the sweep as a whole");
  ExpectRefusal("sweep_file\na.csv\n", "-sweep_file is of the sweep as a whole");
  ExpectRefusal("task\ngrow\n", "-task is of the sweep as a whole");
  ExpectRefusal("stability_optimal_shape\na.h5\n", "is of the sweep as a whole");
  Write(path, "friction_mu\n0.5\0\n", 17);
  line = Read(path, &table);
  EXPECT(line && strstr(line, "neither text nor HDF5"), "%s", line ? line : "nothing");
  CHECK(TableDestroy(&table));
  RemoveFile(path);
  line = Read("/tmp", &table);
  EXPECT(line && strstr(line, "is a directory"), "%s", line ? line : "nothing");
  CHECK(TableDestroy(&table));
  line = Read(path, &table);
  EXPECT(line && strstr(line, "No such file"), "%s", line ? line : "nothing");
  CHECK(TableDestroy(&table));
}

/* Every change of a cell, and of where it ends, shows. */
static void TestMark(void **state) {
  const char *const text[] = {"friction_mu,tip_force\n1,22\n", "-friction_mu, tip_force\n1,22\n",
                              "friction_mu,tip_force\n12,2\n", "friction_mu,tip_force\n1,23\n",
                              "tip_force,friction_mu\n1,22\n", "friction_mu,tip_force\n1,22\n,\n"};
  char mark[6][17];

  for (int i = 0; i < 6; i++) {
    Table table = Sound(text[i]);
    TableMark(table, mark[i]);
    CHECK(TableDestroy(&table));
    EXPECT(i < 2 ? !strcmp(mark[i], mark[0]) : strcmp(mark[i], mark[0]) != 0, "%s: %s", text[i],
           mark[i]);
  }
}

static void TestNumber(void **state) {
  PetscReal value;

  EXPECT(TableNumber("-1.5e3", &value) && value == -1500, "%g", (double)value);
  EXPECT(TableNumber("", &value) && isnan(value), "%g", (double)value);
  EXPECT(!TableNumber("28cm", &value) && !TableNumber("sag", &value), "%g", (double)value);
}

/* Datasets, by name; numbers keep every digit, NaN says nothing. */
static void TestHdf5(void **state) {
  const PetscInt rows = 3;
  const PetscInt *const dims[] = {&rows, &rows};
  const PetscReal mu[] = {0.1, 1. / 3, NAN}, cells[] = {20, 30, 40};
  const PetscReal *const values[] = {cells, mu};
  const char *const name[] = {"/rod_cells", "/friction_mu"};
  const int rank_of[] = {1, 1};
  char path[64], mark[2][17];
  const char *line;
  PetscReal third;
  Table table, same;

  OpenScratch(path);
  WriteScratch(path, 2, name, rank_of, dims, values);
  line = Read(path, &table);
  EXPECT(!line, "%s", line);
  EXPECT(TableRows(table) == 3 && TableColumns(table) == 2, "%d rows", (int)TableRows(table));
  ExpectCell(table, 0, 0, "0.1");
  ExpectCell(table, 2, 0, "");
  ExpectCell(table, 1, 1, "30");
  EXPECT(TableNumber(TableCell(table, 1, 0), &third) && third == 1. / 3, "%.17g", (double)third);
  TableMark(table, mark[0]);
  same = Sound("friction_mu,rod_cells\n0.1,20\n0.3333333333333333,30\n,40\n");
  TableMark(same, mark[1]);
  EXPECT(!strcmp(mark[0], mark[1]), "%s, %s", mark[0], mark[1]);
  CHECK(TableDestroy(&same));
  CHECK(TableDestroy(&table));
  RemoveFile(path);
}

static void TestHdf5Refused(void **state) {
  const PetscInt two = 2, three = 3, square[] = {2, 2};
  const PetscInt *const ragged[] = {&two, &three}, *const flat[] = {square};
  const PetscReal a[4] = {0.5, 1, 1, 1};
  const PetscReal *const values[] = {a, a};
  const char *const name[] = {"/friction_mu", "/rod_cells"};
  const int ones[] = {1, 1}, twos[] = {2};
  char path[64];
  const char *line;
  Table table;

  OpenScratch(path);
  WriteScratch(path, 2, name, ones, ragged, values);
  line = Read(path, &table);
  EXPECT(line && strstr(line, "rod_cells has 3 rows, the first has 2"), "%s", line ? line : "-");
  CHECK(TableDestroy(&table));
  WriteScratch(path, 1, name, twos, flat, values);
  line = Read(path, &table);
  EXPECT(line && strstr(line, "friction_mu must have one dimension"), "%s", line ? line : "-");
  CHECK(TableDestroy(&table));
  WriteScratch(path, 0, name, ones, ragged, values);
  line = Read(path, &table);
  EXPECT(line && strstr(line, "is empty"), "%s", line ? line : "-");
  CHECK(TableDestroy(&table));
  RemoveFile(path);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(TestPlain),           cmocka_unit_test(TestOddButSound),
    cmocka_unit_test(TestEndsInNothing),   cmocka_unit_test(TestRefused),
    cmocka_unit_test(TestUnitsOfHeadings), cmocka_unit_test(TestMark),
    cmocka_unit_test(TestNumber),          cmocka_unit_test(TestHdf5),
    cmocka_unit_test(TestHdf5Refused)};

MAIN(tests)

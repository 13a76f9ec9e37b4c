/* A file of HDF5 is read as a table whose columns are numbers, texts or switches. */
#include "base/hdf_library.h"
#include <stdlib.h>

/* A text that grows. */
typedef struct {
  char *text;
  size_t n, room;
} Words;

/* Adds a word, of at most `most` characters, and its end; blanks behind it are left out. */
static PetscErrorCode AddWord(Words *self, const char *word, size_t most) {
  size_t n = 0;

  PetscFunctionBegin;
  while (n < most && word[n]) n++;
  while (n > 0 && word[n - 1] == ' ') n--;
  if (self->n + n + 1 > self->room) {
    self->room = 2 * self->room + n + 1024;
    PetscCall(PetscRealloc(self->room, &self->text));
  }
  PetscCall(PetscMemcpy(self->text + self->n, word, n));
  self->n += n;
  self->text[self->n++] = 0;
  PetscFunctionReturn(0);
}

/* The shortest text that is read as this number again; nothing for NaN. */
static void NumberText(double value, const char *unit, char text[64]) {
  text[0] = 0;
  if (value != value) return;
  for (int digits = 15; digits <= 17; digits++) {
    (void)snprintf(text, 64, "%.*g", digits, value);
    if (strtod(text, NULL) == value) break;
  }
  (void)snprintf(text + strlen(text), 64 - strlen(text), "%s", unit);
}

static PetscErrorCode AddNumbers(hid_t d, hsize_t n, Words *words, char fault[HDF_FAULT]) {
  double *value;
  char text[64], unit[32];

  PetscFunctionBegin;
  HdfReadAttribute(d, "units", unit, sizeof(unit));
  if (!strcmp(unit, "1")) unit[0] = 0;
  PetscCall(PetscMalloc1(n, &value));
  if (H5Dread(d, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, value) < 0)
    (void)snprintf(fault, HDF_FAULT, "cannot be read as numbers; is the file whole?");
  for (hsize_t i = 0; i < n && !fault[0]; i++) {
    NumberText(value[i], unit, text);
    PetscCall(AddWord(words, text, sizeof(text)));
  }
  PetscCall(PetscFree(value));
  PetscFunctionReturn(0);
}

/* Texts of one length, or of any. */
static PetscErrorCode AddTexts(hid_t d, hid_t type, hsize_t n, Words *words,
                               char fault[HDF_FAULT]) {
  PetscBool any = (PetscBool)(H5Tis_variable_str(type) > 0);
  size_t size = H5Tget_size(type);
  char *all;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n * size, &all));
  if (H5Dread(d, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all) < 0)
    (void)snprintf(fault, HDF_FAULT, "cannot be read as text; is the file whole?");
  for (hsize_t i = 0; i < n && !fault[0]; i++) {
    const char *word = any ? ((char **)(void *)all)[i] : all + i * size;
    PetscCall(AddWord(words, word ? word : "", any ? PETSC_MAX_PATH_LEN : size));
    if (any) (void)H5free_memory(((char **)(void *)all)[i]);
  }
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* True and false, as h5py writes them. */
static PetscErrorCode AddSwitches(hid_t d, hid_t type, hsize_t n, Words *words,
                                  char fault[HDF_FAULT]) {
  signed char *all;

  PetscFunctionBegin;
  PetscCall(PetscCalloc1(n, &all));
  if (H5Tget_size(type) != 1 || H5Dread(d, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all) < 0)
    (void)snprintf(fault, HDF_FAULT, "holds neither numbers nor text");
  for (hsize_t i = 0; i < n && !fault[0]; i++)
    PetscCall(AddWord(words, all[i] ? "true" : "false", 5));
  PetscCall(PetscFree(all));
  PetscFunctionReturn(0);
}

/* One dataset of a table; rows -1: the first. */
static PetscErrorCode AddColumn(hid_t d, PetscInt *rows, Words *words, char fault[HDF_FAULT]) {
  hid_t space = H5Dget_space(d), type = H5Dget_type(d);
  H5T_class_t class = H5Tget_class(type);
  hsize_t n = 0;

  PetscFunctionBegin;
  if (H5Sget_simple_extent_ndims(space) != 1)
    (void)snprintf(fault, HDF_FAULT, "must have one dimension, that of the rows");
  else
    (void)H5Sget_simple_extent_dims(space, &n, NULL);
  if (!fault[0] && *rows >= 0 && n != (hsize_t)*rows)
    (void)snprintf(fault, HDF_FAULT, "has %d rows, the first has %d", (int)n, (int)*rows);
  *rows = (PetscInt)n;
  if (!fault[0] && (class == H5T_INTEGER || class == H5T_FLOAT))
    PetscCall(AddNumbers(d, n, words, fault));
  else if (!fault[0] && class == H5T_STRING)
    PetscCall(AddTexts(d, type, n, words, fault));
  else if (!fault[0] && class == H5T_ENUM)
    PetscCall(AddSwitches(d, type, n, words, fault));
  else if (!fault[0])
    (void)snprintf(fault, HDF_FAULT, "holds neither numbers nor text");
  H5Tclose(type);
  H5Sclose(space);
  PetscFunctionReturn(0);
}

/*
  HdfReadTable - reads all datasets of a file as the columns of a table, numbers as text. Not
  collective.

  text   column by column its name and its rows, a 0 behind each; the caller frees it (PetscFree)
  size   of the text
  fault  empty, or what is wrong with the file
*/
PetscErrorCode HdfReadTable(const char *path, PetscInt *columns, PetscInt *rows, char **text,
                            size_t *size, char fault[HDF_FAULT]) {
  Words words = {0};
  H5G_info_t info = {0};
  hid_t f = HdfOpenToRead(path, fault), d;

  PetscFunctionBegin;
  *columns = 0;
  *rows = -1;
  if (f >= 0) (void)H5Gget_info(f, &info);
  for (hsize_t i = 0; i < info.nlinks && !fault[0]; i++) {
    char name[64], why[HDF_FAULT] = "";
    (void)H5Lget_name_by_idx(f, ".", H5_INDEX_NAME, H5_ITER_INC, i, name, sizeof(name),
                             H5P_DEFAULT);
    PetscCall(AddWord(&words, name, sizeof(name)));
    d = H5Dopen2(f, name, H5P_DEFAULT);
    if (d < 0)
      (void)snprintf(why, sizeof(why), "is no dataset");
    else {
      PetscCall(AddColumn(d, rows, &words, why));
      H5Dclose(d);
    }
    if (why[0]) (void)snprintf(fault, HDF_FAULT, "%s %.120s", name, why);
    ++*columns;
  }
  if (f >= 0) H5Fclose(f);
  if (fault[0]) PetscCall(PetscFree(words.text));
  *text = words.text;
  *size = words.n;
  PetscFunctionReturn(0);
}

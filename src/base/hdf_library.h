/* What the files that know the HDF5 library share. */
#ifndef TENDRIL_HDF_LIBRARY_H
#define TENDRIL_HDF_LIBRARY_H

#include "base/hdf.h"
#include <hdf5.h>

/* hdf.c */
void HdfBeQuiet(void);

/* hdf_read.c */
hid_t HdfOpenToRead(const char *path, char fault[HDF_FAULT]);
void HdfReadAttribute(hid_t object, const char *name, char *text, size_t length);

#endif

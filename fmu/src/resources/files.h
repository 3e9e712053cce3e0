/* Resource files: their folder, and a strict reader of the .npy files that the exporter writes:
 * version 1.0, little-endian, C order. */
#ifndef FMU_FILES_H
#define FMU_FILES_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Returns the folder of a file: URI (FMI 2.0) or a path (FMI 3.0) as a native path in UTF-8 that
 * ends in a separator, from malloc; NULL: `reason` says why there is none. */
char *location_folder(const char *location, const char **reason);

/* Opens a file in the folder for reading in binary; NULL if that is not possible. */
FILE *location_open(const char *folder, const char *name);

#define NPY_DIMENSIONS 4

typedef enum { NPY_INT32, NPY_FLOAT64 } npy_type;

typedef struct {
    npy_type type;
    int dimensions; /* 1 to NPY_DIMENSIONS */
    size_t shape[NPY_DIMENSIONS];
} npy_layout;

/* Returns the elements of a file that must have exactly this layout, from malloc, and the CRC-32
 * of all its bytes. NULL: `reason` says what is wrong with the file. */
void *npy_read(FILE *file, const npy_layout *layout, uint32_t *crc, const char **reason);

/* Returns the CRC-32 (ISO 3309, as in zlib) of `crc` continued by these bytes; 0 at first. */
uint32_t npy_crc(uint32_t crc, const void *bytes, size_t count);

#endif

/* Strict reader of the .npy files that the exporter writes: version 1.0, little-endian, C order. */
#ifndef FMU_NPY_H
#define FMU_NPY_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define NPY_DIMENSIONS 4

typedef enum { NPY_INT32, NPY_FLOAT64 } npy_type;

typedef struct {
    npy_type type;
    int dimensions; /* 1 to NPY_DIMENSIONS */
    size_t shape[NPY_DIMENSIONS];
} npy_layout;

size_t npy_count(const npy_layout *layout); /* elements */

/* The elements of a file that must have exactly this layout, in memory from malloc, and the
 * CRC-32 of all its bytes. NULL: `reason` says what is wrong with the file. */
void *npy_read(FILE *file, const npy_layout *layout, uint32_t *crc, const char **reason);

/* CRC-32 (ISO 3309, as zlib's) of more bytes after those that gave `crc`; 0 to begin with. */
uint32_t npy_crc(uint32_t crc, const void *bytes, size_t count);

#endif

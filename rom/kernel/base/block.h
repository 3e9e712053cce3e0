/* Arrays one after the other in a block of memory. */
#ifndef SLIPMODE_BLOCK_H
#define SLIPMODE_BLOCK_H

#include <stddef.h>
#include <string.h>

#include "base/lanes.h"

/* Takes `count` doubles from *memory. */
static inline double *sm_take(double **memory, size_t count) {
    double *place = *memory;
    *memory += count;
    return place;
}

/* Copies `count` doubles there; NULL for none. */
static inline const double *sm_keep(double **memory, const double *source, size_t count) {
    return count > 0 ? memcpy(sm_take(memory, count), source, count * sizeof(double)) : NULL;
}

/* So many doubles, filled up to whole cache lines and vectors. */
static inline size_t sm_whole_lines(size_t doubles) {
    return (doubles + SM_VECTOR - 1) & ~(size_t)(SM_VECTOR - 1);
}

/* Doubles that hold so many bytes. */
static inline size_t sm_doubles(size_t bytes) {
    return (bytes + sizeof(double) - 1) / sizeof(double);
}

/* Copies bytes there; NULL for none. */
static inline const unsigned char *sm_keep_bytes(double **memory, const unsigned char *source,
                                                 size_t bytes) {
    return bytes > 0 ? memcpy(sm_take(memory, sm_doubles(bytes)), source, bytes) : NULL;
}

#endif

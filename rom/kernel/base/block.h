/* Arrays one after the other in a block of memory: what takes them is also what counts them. */
#ifndef SLIPMODE_BLOCK_H
#define SLIPMODE_BLOCK_H

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/lanes.h"

/* Without memory it counts what is taken: what takes arrays is called twice, and sm_allocate in
 * between. */
typedef struct {
    double *memory;
    size_t taken; /* doubles */
} sm_block;

/* Takes the memory that was counted, zeros; returns whether there is so much. It is the caller's. */
static inline int sm_allocate(sm_block *block) {
    block->memory = calloc(block->taken, sizeof(double));
    block->taken = 0;
    return block->memory != NULL;
}

/* Takes `count` doubles; NULL where they are only counted. */
static inline double *sm_take(sm_block *block, size_t count) {
    double *place = block->memory ? block->memory + block->taken : NULL;
    block->taken += count;
    return place;
}

/* So many doubles, filled up to whole cache lines and vectors. */
static inline size_t sm_whole_lines(size_t doubles) {
    return (doubles + SM_VECTOR - 1) & ~(size_t)(SM_VECTOR - 1);
}

/* Doubles that hold so many bytes. */
static inline size_t sm_doubles(size_t bytes) {
    return (bytes + sizeof(double) - 1) / sizeof(double);
}

#endif

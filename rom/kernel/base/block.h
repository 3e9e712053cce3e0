/* One block of memory for all work arrays of a computation, allocated once. A function that
 * places arrays is called twice: the first call counts the doubles, the second one, after
 * sm_allocate, sets the pointers. Contact steps, the torus, full order, components and tones
 * place arrays so. */
#ifndef SLIPMODE_BLOCK_H
#define SLIPMODE_BLOCK_H

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/lanes.h"

typedef struct {
    double *memory; /* NULL while the doubles are counted */
    size_t taken;   /* doubles counted or placed so far */
} sm_block;

/* Allocates the counted doubles, set to zero, which the caller frees; returns 0 if memory is
 * exhausted. */
static inline int sm_allocate(sm_block *block) {
    block->memory = calloc(block->taken, sizeof(double));
    block->taken = 0;
    return block->memory != NULL;
}

/* Returns the place of the next `count` doubles; NULL while they are counted. */
static inline double *sm_take(sm_block *block, size_t count) {
    double *place = block->memory ? block->memory + block->taken : NULL;
    block->taken += count;
    return place;
}

/* Places several arrays of `count` doubles; the arguments are the addresses of their pointers. */
#define SM_TAKE_EACH(block, count, ...)                                  \
    do {                                                                 \
        double **const arrays_[] = {__VA_ARGS__};                        \
        for (size_t k_ = 0; k_ < sizeof arrays_ / sizeof *arrays_; k_++) \
            *arrays_[k_] = sm_take((block), (count));                    \
    } while (0)

/* Returns the number of doubles of a structure that has nothing else. */
#define SM_DOUBLES_IN(type) (sizeof(type) / sizeof(double))

/* Returns a number rounded up to a multiple. */
static inline size_t sm_whole(size_t number, size_t of) { return (number + of - 1) / of * of; }

/* Returns a number of doubles rounded up to whole cache lines and vectors. */
static inline size_t sm_whole_lines(size_t doubles) { return sm_whole(doubles, SM_VECTOR); }

/* Returns the number of doubles that have room for a number of bytes. */
static inline size_t sm_doubles(size_t bytes) {
    return (bytes + sizeof(double) - 1) / sizeof(double);
}

#endif

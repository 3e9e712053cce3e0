/* Phases t_B of phase lines at the start of a period of mode A, and exp(i m t_B) there. */
#ifndef SLIPMODE_PHASES_H
#define SLIPMODE_PHASES_H

#include <stdint.h>

#include "base/block.h"

#define SM_TOGETHER 4 /* steps whose sums over the harmonics are formed together */
#define SM_POWERS 4   /* m come in groups of so many */

typedef struct {
    size_t lines;   /* of a point: t_B = 2 pi p / lines at first */
    size_t wide;    /* lines of all points, and lanes that fill vectors up */
    size_t powers;  /* m = 0, 1, ... up to the highest of the orders, and some more */
    double *across; /* (powers, 2, wide): cos and sin of m t_B */
} sm_phases;

/* cos of m t_B of all lines, and `wide` doubles behind the sin; for m < 0 that of -m. */
static inline const double *sm_phases_power(const sm_phases *phases, int m) {
    return phases->across + 2 * (size_t)(m < 0 ? -m : m) * phases->wide;
}

/* `lines` and `wide` are set; order (orders, 2): n, m. */
void sm_phases_place(sm_phases *phases, size_t orders, const int32_t *order, sm_block *block);
void sm_phases_start(sm_phases *phases);
/* t_B += 2 pi turns. */
void sm_phases_turn(sm_phases *phases, double turns);

#endif

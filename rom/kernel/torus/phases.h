/* Phases t_B of the phase lines, eq. (13), at the start of a period of mode A, and exp(i m t_B) for
 * the harmonics (n, m) of eq. (14). Marches of rigid (rigid/) and elastic contacts (elastic/) call
 * it once per period. */
#ifndef SLIPMODE_PHASES_H
#define SLIPMODE_PHASES_H

#include <stdint.h>

#include "base/block.h"

/* Steps with one pass over the harmonics, and powers with one pass over the lines: their sums fit
 * in registers. */
#define SM_TOGETHER 4

typedef struct {
    size_t lines;   /* phase lines of a point: at the start t_B = 2 pi p / lines, p < lines */
    size_t wide;    /* lines of all points, with unused lanes that complete a vector */
    size_t powers;  /* number of m = 0, 1, ... up to the highest |m| or more, a multiple of SM_TOGETHER */
    double turns;   /* of all lines since the start, a fraction of one */
    double *across; /* (powers, 2, wide): cos and sin of m t_B */
} sm_phases;

/* Returns cos(|m| t_B) of all lines; sin(|m| t_B) begins `wide` doubles later. */
static inline const double *sm_phases_power(const sm_phases *phases, int m) {
    return phases->across + 2 * (size_t)(m < 0 ? -m : m) * phases->wide;
}

/* Sets `powers` for harmonics order (orders, 2): n, m; and places the arrays. The caller has set
 * `lines` and `wide`. */
void sm_phases_place(sm_phases *phases, size_t orders, const int32_t *order, sm_block *block);
/* Spaces the phases of each point evenly over [0, 2 pi). */
void sm_phases_start(sm_phases *phases);
/* Adds 2 pi turns to the phases of all lines. */
void sm_phases_turn(sm_phases *phases, double turns);

#endif

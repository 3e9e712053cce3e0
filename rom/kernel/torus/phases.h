/* Phases t_B of phase lines at the start of a period of mode A, and exp(i m t_B) there. */
#ifndef SLIPMODE_PHASES_H
#define SLIPMODE_PHASES_H

#include "base/block.h"

typedef struct {
    size_t lines;   /* of a point: t_B = 2 pi p / lines at first */
    size_t wide;    /* lines of all points, and lanes that fill vectors up */
    size_t powers;  /* m = 0, 1, ..., 2 or more */
    double *across; /* (powers, 2, wide): cos and sin of m t_B */
} sm_phases;

/* cos of m t_B of all lines, and `wide` doubles behind the sin; for m < 0 that of -m. */
static inline const double *sm_phases_power(const sm_phases *phases, int m) {
    return phases->across + 2 * (size_t)(m < 0 ? -m : m) * phases->wide;
}

void sm_phases_place(sm_phases *phases, sm_block *block);
void sm_phases_start(sm_phases *phases);
/* t_B += 2 pi turns. */
void sm_phases_turn(sm_phases *phases, double turns);

#endif

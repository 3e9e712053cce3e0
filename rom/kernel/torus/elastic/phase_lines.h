/* Harmonics along phase lines t_B = t_B0 + ratio t_A, side by side in lanes: the forcing at the
 * steps of a period from its harmonics, and the harmonics of the result.
 *
 * exp(i (n t_A + m t_B)) = exp(i (n + m ratio) t_A) exp(i m t_B0): sums over harmonics of one |m|
 * are formed once a step, for all lines.
 */
#ifndef SLIPMODE_PHASE_LINES_H
#define SLIPMODE_PHASE_LINES_H

#include "torus/phases.h"

typedef struct {
    size_t contacts, orders, lines;
    size_t steps;         /* of a period of mode A */
    size_t stride;        /* lines, and lanes that only fill vectors up: sm_whole_lines */
    size_t row;           /* the same of contacts */
    const int32_t *order; /* (orders, 2): n, m */
    double ratio;         /* omega_B / omega_A */
    double *phasor;       /* (steps, orders, 2): exp(i (n + m ratio) t_A) */
    sm_phases phases;     /* t_B0, `stride` wide */
    double *harmonics;    /* (orders, 2, row) h_nm of u = Re sum_nm h_nm exp(i (n t_A + m t_B)) */
    double *sums;         /* (orders, 2, row): of y exp(-i (n t_A + m t_B)) over steps and lines */
    double *by_power;     /* (SM_TOGETHER, powers, 2, row): sums over harmonics, or lines */
    double *u, *y;        /* (SM_TOGETHER, N_c, stride), at some steps */
    double *y_mean;       /* (SM_TOGETHER, lines, row): y for the sums */
} sm_phase_lines;

/* Takes the memory; sizes, orders and ratio are set. */
void sm_phase_lines_place(sm_phase_lines *lines, sm_block *block);
/* u at the ends of up to SM_TOGETHER steps from `first` on. */
void sm_phase_lines_displace(sm_phase_lines *lines, size_t first, size_t count);
/* Sums begin at nothing; y_mean at the ends of steps adds to them, times `weight`. */
void sm_phase_lines_clear(sm_phase_lines *lines);
void sm_phase_lines_add(sm_phase_lines *lines, size_t first, size_t count, double weight);
/* Y (orders, N_c, 2): the sums as means over so many steps and the lines. The mean itself is (0,
 * 0): of two conjugates one half. */
void sm_phase_lines_collect(const sm_phase_lines *lines, size_t steps, double *Y);

#endif

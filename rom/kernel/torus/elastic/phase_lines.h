/* Displacements along phase lines t_B = t_B0 + ratio t_A from their harmonics, and the harmonics of
 * the force deficit; lines lie side by side in lanes.
 *
 * exp(i (n t_A + m t_B)) = exp(i (n + m ratio) t_A) exp(i m t_B0): sums over the harmonics of one
 * |m| are formed once in a step for all lines. elastic_lines.c and torus/growth.c call these
 * functions.
 */
#ifndef SLIPMODE_PHASE_LINES_H
#define SLIPMODE_PHASE_LINES_H

#include "torus/phases.h"

typedef struct {
    size_t contacts, orders, lines;
    size_t steps;         /* of a period of mode A */
    size_t stride;        /* lines, rounded up to whole vectors: sm_whole_lines */
    size_t row;           /* contacts, rounded up to whole vectors */
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

/* Takes the arrays from a block, or counts them; sizes, orders and ratio are set. */
void sm_phase_lines_place(sm_phase_lines *lines, sm_block *block);
/* Sets u at the ends of up to SM_TOGETHER steps from `first` on. */
void sm_phase_lines_displace(sm_phase_lines *lines, size_t first, size_t count);
/* Sets the sums to 0. */
void sm_phase_lines_clear(sm_phase_lines *lines);
/* Adds y_mean at the ends of these steps, times `weight`, to the sums. */
void sm_phase_lines_add(sm_phase_lines *lines, size_t first, size_t count, double weight);
/* Sets Y (orders, N_c, 2), the means of the sums over `steps` and the lines. Harmonic (0, 0) is the
 * mean value, which counts half in the real part of a sum. */
void sm_phase_lines_collect(const sm_phase_lines *lines, size_t steps, double *Y);

#endif

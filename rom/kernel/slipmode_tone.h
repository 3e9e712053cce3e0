/* Slow flow of one tone: amplitudes of many modes under one force, with friction by contact. */
#ifndef SLIPMODE_TONE_H
#define SLIPMODE_TONE_H

#include "slipmode.h"

/* a_m' = (s_m - i Omega) a_m + b_m F + sum_j l_mj y_j
 * c_j  = sum_m psi_jm a_m + x_j F + sum_i G_ji y_i,   y_j = k_j(|c_j|) c_j
 *
 * The force deficits y of the contacts follow their drives c at once. Vectors are real parts, then
 * imaginary parts; matrices are columns of these. */
typedef struct {
    int32_t modes;            /* M */
    int32_t contacts;         /* n, a multiple of `kinds` */
    int32_t kinds;            /* of contacts: contact j has table j % kinds */
    int32_t nodes;            /* of the tables, 2 or more */
    const double *pole;       /* (2, M) s_m [1/s] */
    const double *excitation; /* (2, M) b_m */
    const double *motion;     /* (M, 2, n) psi */
    const double *projection; /* (n, 2, M) l */
    const double *others;     /* (n + 1, 2, n) G, without what the tables contain; then x */
    double onset;             /* k = 0 up to |c| = onset (1 + past of the first node) */
    double first, spacing;    /* log(|c| / onset - 1) at the first node, and between nodes */
    const double *secant;     /* (nodes, kinds, 2, 2) k and its slope per node, real, imaginary */
    double contraction;       /* |k| |G|: how strongly contacts act on each other */
    double tolerance;         /* of a step, relative to the amplitudes */
} sm_tone;

/* Inputs that change linearly during a march. */
typedef struct {
    double duration;     /* [s] */
    double frequency[2]; /* Omega at the start and at the end [rad/s] */
    double force[2];     /* F */
} sm_tone_inputs;

/* Advances the amplitudes (2, M). The deficits (2, n) are a guess, and those at the end. `step` is
 * the first step to try [s], 0 if unknown; at the end the next one. All three are unchanged on
 * any status but SM_OK: SM_NOT_CONVERGED if no deficits were found. */
SM_API sm_status sm_tone_march(const sm_tone *tone, const sm_tone_inputs *inputs,
                               double *amplitude, double *deficit, double *step);

#endif

/* The modes' response as a force on the contacts, at the stages of time steps.
 *
 * Every harmonic advances by a factor of its own from one step to the next, as the carriers do
 * (sm_forcing), and the coefficients move on straight lines.
 */
#ifndef SLIPMODE_REACTION_H
#define SLIPMODE_REACTION_H

#include "base/lanes.h"
#include "slow/motion/segment.h"

#define SM_REACTION_BLOCK 8 /* harmonics side by side: rows are filled up with zeros */
#define SM_STAGES 2         /* of a time step */
#define SM_LEVELS 7         /* lengths that a time step may have: each half the one before */

typedef struct {
    double *re, *im; /* (row) */
} sm_phasors;

typedef struct {
    int orders;              /* of the harmonics that there is room for */
    size_t row;              /* that many, filled up to whole blocks */
    sm_phasors now, stage;   /* at the start of the next step, and at a stage of it */
    sm_phasors by[SM_LEVELS][SM_STAGES]; /* factors from the one to the other */
    double *start, *slope;   /* (N_c, 2, row): real parts, imaginary parts */
} sm_reaction;

static inline size_t sm_reaction_row(int orders) {
    return ((size_t)orders + SM_REACTION_BLOCK - 1) / SM_REACTION_BLOCK * SM_REACTION_BLOCK;
}

static inline size_t sm_reaction_size(int contacts, int orders) { /* doubles */
    return sm_reaction_row(orders) * (4 + 2 * SM_LEVELS * SM_STAGES + 4 * (size_t)contacts);
}

/* In memory that is zero. */
void sm_reaction_place(sm_reaction *reaction, int contacts, int orders, double *memory);
/* The coefficients of a segment. */
void sm_reaction_start(sm_reaction *reaction, int contacts, const sm_segment *segment);
/* The harmonics of the carriers. */
void sm_reaction_set(const sm_reaction *reaction, sm_phasors *phasors, const int32_t *orders,
                     const sm_complex carrier[SM_MODES]);

/* product = a b; it may be a. */
SM_INLINE void sm_phasors_multiply(size_t row, const sm_phasors *a, const sm_phasors *b,
                                   const sm_phasors *product) {
    const double *a_re = a->re, *a_im = a->im, *b_re = b->re, *b_im = b->im;
    double *re = product->re, *im = product->im;
    for (size_t block = 0; block < row; block += SM_REACTION_BLOCK) {
        SM_SIMD
        for (size_t q = block; q < block + SM_REACTION_BLOCK; q++) {
            const double rotated = a_re[q] * b_re[q] - a_im[q] * b_im[q];
            im[q] = a_re[q] * b_im[q] + a_im[q] * b_re[q];
            re[q] = rotated;
        }
    }
}

/* u += Re sum G_nm exp(i (n theta_A + m theta_B)) of the stage, at the fraction r of the
 * segment. */
SM_INLINE void sm_reaction_add(const sm_reaction *reaction, int contacts, double r,
                               double *restrict u) {
    const size_t row = reaction->row;
    const double *restrict re = reaction->stage.re, *restrict im = reaction->stage.im;
    for (size_t i = 0; i < (size_t)contacts; i++) {
        const double *restrict start_re = reaction->start + 2 * i * row, *start_im = start_re + row;
        const double *restrict slope_re = reaction->slope + 2 * i * row, *slope_im = slope_re + row;
        double sum[SM_REACTION_BLOCK] = {0.0};
        for (size_t block = 0; block < row; block += SM_REACTION_BLOCK) {
            SM_SIMD
            for (size_t l = 0; l < SM_REACTION_BLOCK; l++) {
                const size_t q = block + l;
                sum[l] += (start_re[q] + r * slope_re[q]) * re[q]
                          - (start_im[q] + r * slope_im[q]) * im[q];
            }
        }
        for (size_t half = SM_REACTION_BLOCK / 2; half > 0; half /= 2)
            for (size_t l = 0; l < half; l++) sum[l] += sum[l + half];
        u[i] += sum[0];
    }
}

#endif

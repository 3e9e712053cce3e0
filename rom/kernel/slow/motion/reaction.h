/* The modes' response as a force on the contacts, at the stages of equal time steps.
 *
 * Every harmonic advances by a factor of its own from one step to the next, as the carriers do
 * (sm_rotor), and the coefficients move on straight lines.
 */
#ifndef SLIPMODE_REACTION_H
#define SLIPMODE_REACTION_H

#include "base/lanes.h"
#include "slow/motion/segment.h"

#define SM_REACTION_BLOCK 8 /* harmonics side by side: rows are filled up with zeros */

typedef struct {
    int orders;            /* of the harmonics that there is room for */
    size_t row;            /* that many, filled up to whole blocks */
    double *re[2], *im[2]; /* (row) of each stage */
    double *by_re, *by_im; /* (row) factor of a step */
    double *start, *slope; /* (N_c, 2, row): real parts, imaginary parts */
} sm_reaction;

static inline size_t sm_reaction_row(int orders) {
    return ((size_t)orders + SM_REACTION_BLOCK - 1) / SM_REACTION_BLOCK * SM_REACTION_BLOCK;
}

static inline size_t sm_reaction_size(int contacts, int orders) { /* doubles */
    return sm_reaction_row(orders) * (6 + 4 * (size_t)contacts);
}

/* In memory that is zero. */
void sm_reaction_place(sm_reaction *reaction, int contacts, int orders, double *memory);
/* The coefficients of a segment. */
void sm_reaction_start(sm_reaction *reaction, int contacts, const sm_segment *segment);
/* The harmonics of a stage, and their factors from a step to the next, from the carriers'. */
void sm_reaction_set(sm_reaction *reaction, int stage, const int32_t *orders,
                 const sm_complex carrier[SM_MODES]);
void sm_reaction_set_factors(sm_reaction *reaction, const int32_t *orders,
                             const sm_complex by[SM_MODES]);

/* To the next step, unless the carriers are swept. */
SM_INLINE void sm_reaction_advance(sm_reaction *reaction, int stage) {
    double *restrict re = reaction->re[stage], *restrict im = reaction->im[stage];
    const double *restrict by_re = reaction->by_re, *restrict by_im = reaction->by_im;
    for (size_t block = 0; block < reaction->row; block += SM_REACTION_BLOCK) {
        SM_SIMD
        for (size_t q = block; q < block + SM_REACTION_BLOCK; q++) {
            const double rotated = re[q] * by_re[q] - im[q] * by_im[q];
            im[q] = re[q] * by_im[q] + im[q] * by_re[q];
            re[q] = rotated;
        }
    }
}

/* u += Re sum G_nm exp(i (n theta_A + m theta_B)) at the fraction r of the segment. */
SM_INLINE void sm_reaction_add(const sm_reaction *reaction, int contacts, int stage, double r,
                           double *restrict u) {
    const size_t row = reaction->row;
    const double *restrict re = reaction->re[stage], *restrict im = reaction->im[stage];
    for (size_t i = 0; i < (size_t)contacts; i++) {
        const double *start_re = reaction->start + 2 * i * row, *start_im = start_re + row;
        const double *slope_re = reaction->slope + 2 * i * row, *slope_im = slope_re + row;
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

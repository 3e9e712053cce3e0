/* The modes' response as a force on the contacts, at the instants of a march.
 *
 * Every harmonic advances by a factor of its own from one instant to the next, as the carriers do
 * (sm_forcing), and the coefficients move on straight lines.
 */
#ifndef SLIPMODE_REACTION_H
#define SLIPMODE_REACTION_H

#include "base/block.h"
#include "slow/motion/segment.h"

#define SM_REACTION_BLOCK 4 /* harmonics side by side: rows are filled up with zeros */

typedef struct {
    double *re, *im; /* (row) */
} sm_phasors;

typedef struct {
    int orders;              /* of the harmonics that there is room for */
    size_t row;              /* that many, filled up to whole blocks */
    sm_phasors now, by;      /* at an instant; factors to the next */
    double *turn;            /* (row) angles of those factors */
    double *start, *slope;   /* (N_c, 2, row): real parts, imaginary parts */
} sm_reaction;

static inline size_t sm_reaction_row(int orders) {
    return ((size_t)orders + SM_REACTION_BLOCK - 1) / SM_REACTION_BLOCK * SM_REACTION_BLOCK;
}

/* In memory that is zero. */
void sm_reaction_place(sm_reaction *reaction, int contacts, int orders, sm_block *block);
/* The coefficients of a segment. */
void sm_reaction_start(sm_reaction *reaction, int contacts, const sm_segment *segment);
/* The harmonics of the carriers, */
void sm_reaction_set(const sm_reaction *reaction, sm_phasors *phasors, const int32_t *orders,
                     const sm_complex carrier[SM_MODES]);
/* and how far they turn where the carriers do by so much. */
void sm_reaction_turn(const sm_reaction *reaction, const int32_t *orders,
                      const double turn[SM_MODES]);

/* product = a b; it may be a. */
SM_INLINE void sm_phasors_multiply(size_t row, const sm_phasors *a, const sm_phasors *b,
                                   const sm_phasors *product) {
    const double *a_re = a->re, *a_im = a->im, *b_re = b->re, *b_im = b->im;
    double *re = product->re, *im = product->im;
    SM_SIMD
    for (size_t q = 0; q < row; q++) {
        const double rotated = a_re[q] * b_re[q] - a_im[q] * b_im[q];
        im[q] = a_re[q] * b_im[q] + a_im[q] * b_re[q];
        re[q] = rotated;
    }
}

/* The sum of a block. */
SM_INLINE double sm_reaction_sum(const double block[SM_REACTION_BLOCK]) {
    return (block[0] + block[1]) + (block[2] + block[3]);
}

/* value += Re sum G_nm exp(i (n theta_A + m theta_B)) (N_c) at the fraction r of the segment, of
 * which a step is h_r; rate += its change in a step, if that is wanted. `contacts` and `rates` may be
 * literals. */
SM_INLINE void sm_reaction_add(const int contacts, const int rates, const sm_reaction *reaction,
                               double r, double h_r, double *restrict value,
                               double *restrict rate) {
    const size_t row = reaction->row;
    for (size_t i = 0; i < (size_t)contacts; i++) {
        const double *start_re = reaction->start + 2 * i * row, *start_im = start_re + row;
        const double *slope_re = reaction->slope + 2 * i * row, *slope_im = slope_re + row;
        double sum[SM_REACTION_BLOCK] = {0.0}, change[SM_REACTION_BLOCK] = {0.0};
        for (size_t first = 0; first < row; first += SM_REACTION_BLOCK)
            SM_SIMD
            for (size_t k = 0; k < SM_REACTION_BLOCK; k++) {
                const size_t q = first + k;
                const double re = start_re[q] + r * slope_re[q];
                const double im = start_im[q] + r * slope_im[q];
                const double now_re = reaction->now.re[q], now_im = reaction->now.im[q];
                const double turn = reaction->turn[q];
                sum[k] += re * now_re - im * now_im;
                if (rates)
                    change[k] += (h_r * slope_re[q] - turn * im) * now_re
                                 - (h_r * slope_im[q] + turn * re) * now_im;
            }
        value[i] += sm_reaction_sum(sum);
        if (rates) rate[i] += sm_reaction_sum(change);
    }
}

#endif

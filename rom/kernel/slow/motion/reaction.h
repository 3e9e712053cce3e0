/* The modes' response as a force on the contacts, at the stages of time steps.
 *
 * Every harmonic advances by a factor of its own from one step to the next, as the carriers do
 * (sm_forcing), and the coefficients move on straight lines.
 */
#ifndef SLIPMODE_REACTION_H
#define SLIPMODE_REACTION_H

#include "base/lanes.h"
#include "slow/motion/segment.h"

#define SM_REACTION_BLOCK 4 /* harmonics side by side: rows are filled up with zeros */
#define SM_STAGES 2         /* of a time step */
#define SM_LEVELS 4         /* lengths that a time step may have */

typedef struct {
    double *re, *im; /* (row) */
} sm_phasors;

typedef struct {
    int orders;              /* of the harmonics that there is room for */
    size_t row;              /* that many, filled up to whole blocks */
    sm_phasors now;          /* at the start of the next step, or at a stage of it */
    sm_phasors by[SM_LEVELS][SM_STAGES]; /* factors from the one to the other */
    sm_phasors none;         /* the factor 1 */
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
    SM_SIMD
    for (size_t q = 0; q < row; q++) {
        const double rotated = a_re[q] * b_re[q] - a_im[q] * b_im[q];
        im[q] = a_re[q] * b_im[q] + a_im[q] * b_re[q];
        re[q] = rotated;
    }
}

/* sm_reaction_add for contact i alone, or for two from there on. */
SM_INLINE void sm_reaction_add_to(const int contacts, const sm_reaction *reaction, size_t i,
                                  const sm_phasors *by, double r, double *u) {
    const size_t row = reaction->row, next = contacts == 2 ? 2 * row : 0;
    const double *now_re = reaction->now.re, *now_im = reaction->now.im;
    const double *by_re = by->re, *by_im = by->im;
    const double *start_re = reaction->start + 2 * i * row, *start_im = start_re + row;
    const double *slope_re = reaction->slope + 2 * i * row, *slope_im = slope_re + row;
    double first = 0.0, second = 0.0;
    SM_SIMD_SUM(first, second)
    for (size_t q = 0; q < row; q++) {
        const double re = now_re[q] * by_re[q] - now_im[q] * by_im[q];
        const double im = now_re[q] * by_im[q] + now_im[q] * by_re[q];
        first += (start_re[q] + r * slope_re[q]) * re - (start_im[q] + r * slope_im[q]) * im;
        second += (start_re[q + next] + r * slope_re[q + next]) * re
                  - (start_im[q + next] + r * slope_im[q + next]) * im;
    }
    u[i] += first;
    if (contacts == 2) u[i + 1] += second;
}

/* u += Re sum G_nm exp(i (n theta_A + m theta_B)), the harmonics being `now` turned by `by`, at the
 * fraction r of the segment. `contacts` may be a literal. */
SM_INLINE void sm_reaction_add(const int contacts, const sm_reaction *reaction,
                               const sm_phasors *by, double r, double *u) {
    size_t i = 0;
    for (; i + 2 <= (size_t)contacts; i += 2) sm_reaction_add_to(2, reaction, i, by, r, u);
    if (i < (size_t)contacts) sm_reaction_add_to(1, reaction, i, by, r, u);
}

#endif

/* The modes' answer as a force on the contacts, at the stages of equal time steps.
 *
 * Every harmonic turns by a factor of its own from one step to the next, as the carriers do
 * (sm_rotor), and the coefficients move on straight lines.
 */
#ifndef SLIPMODE_PULL_H
#define SLIPMODE_PULL_H

#include "lanes.h"
#include "segment.h"

typedef struct {
    int orders;                           /* most that there is room for */
    double *re[2], *im[2];                /* (orders) of each stage */
    double *by_re, *by_im;                /* (orders) turn of a step */
    double *start, *slope;                /* (N_c, 2, orders): real parts, imaginary parts */
} sm_pull;

static inline size_t sm_pull_size(int contacts, int orders) { /* doubles */
    return (size_t)orders * (6 + 4 * (size_t)contacts);
}

void sm_pull_place(sm_pull *pull, int contacts, int orders, double *memory);
/* The coefficients of a segment. */
void sm_pull_start(sm_pull *pull, int contacts, const sm_segment *segment);
/* The harmonics of a stage, and their turn from a step to the next, where the carriers are given. */
void sm_pull_set(sm_pull *pull, int stage, const int32_t *orders,
                 const sm_complex carrier[SM_MODES]);
void sm_pull_set_turn(sm_pull *pull, const int32_t *orders, const sm_complex by[SM_MODES]);

/* To the next step, unless the carriers are swept. */
SM_INLINE void sm_pull_turn(sm_pull *pull, int stage) {
    double *restrict re = pull->re[stage], *restrict im = pull->im[stage];
    const double *restrict by_re = pull->by_re, *restrict by_im = pull->by_im;
    SM_SIMD
    for (int q = 0; q < pull->orders; q++) {
        const double turned = re[q] * by_re[q] - im[q] * by_im[q];
        im[q] = re[q] * by_im[q] + im[q] * by_re[q];
        re[q] = turned;
    }
}

/* u += Re sum G_nm exp(i (n theta_A + m theta_B)) at the fraction r of the segment. */
SM_INLINE void sm_pull_add(const sm_pull *pull, int contacts, int stage, double r,
                           double *restrict u) {
    const size_t orders = (size_t)pull->orders;
    const double *restrict re = pull->re[stage], *restrict im = pull->im[stage];
    for (size_t i = 0; i < (size_t)contacts; i++) {
        const double *restrict start = pull->start + 2 * i * orders;
        const double *restrict slope = pull->slope + 2 * i * orders;
        double sum = 0.0;
        SM_SIMD_SUM(sum)
        for (size_t q = 0; q < orders; q++)
            sum += (start[q] + r * slope[q]) * re[q]
                   - (start[orders + q] + r * slope[orders + q]) * im[q];
        u[i] += sum;
    }
}

#endif

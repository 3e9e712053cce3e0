/* Extrapolation of the contact displacements to periodic motion (Aitken), called by group.c.
 *
 * A stuck contact keeps an offset from its initial state that decays only by creep. As a function
 * of t_B at fixed t_A the offset shifts by 2 pi omega_B / omega_A per period. Its coefficients over
 * t_B are geometric sequences X_m + c r_m^k: two successive changes give r_m and the limit X_m. */
#include <string.h>

#include "base/cnumber.h"
#include "torus/rigid/group.h"

/* Smallest |1 - r|, and largest |r| - 1: nearer to 1 the change is multiplied by more than 50, and
 * the limit is ill-conditioned. */
#define SMALLEST_GAP 0.02

/* Returns the number of Fourier coefficients m = 0, 1, ... over the lines of a point. */
static size_t coefficients(const sm_torus_grid *grid) {
    return sm_acceleration_size(1, (size_t)grid->lines) / 2;
}

/* Computes the coefficients `fresh`: means of x exp(-i m t_B) over the lines of a point. The
 * inverse adds the Fourier series of `fresh` to the displacements x. */
static void transform(const sm_torus_grid *grid, const sm_torus_group *g, size_t p, int inverse) {
    const size_t n = (size_t)grid->contact->contacts, lanes = (size_t)grid->lanes;
    const size_t lines = (size_t)grid->lines, count = coefficients(grid);
    const double *cosine = sm_phases_power(&g->phases, 1), *sine = cosine + g->phases.wide;
    double *fresh = g->acceleration[p].fresh;
    if (!inverse) memset(fresh, 0, 2 * count * n * sizeof(double));
    for (size_t lane = p * lines; lane < (p + 1) * lines; lane++) {
        double *x = g->lanes[lane / lanes].x + lane % lanes;
        sm_complex z = sm_cx(1.0, 0.0); /* exp(i m t_B) */
        for (size_t m = 0; m < count; m++) {
            for (size_t i = 0; i < n; i++) {
                double *c = fresh + 2 * (m * n + i), *value = x + i * lanes;
                if (inverse) {
                    *value += (m == 0 ? 1.0 : 2.0) * (c[0] * z.re - c[1] * z.im);
                } else {
                    c[0] += *value * z.re / (double)lines;
                    c[1] -= *value * z.im / (double)lines;
                }
            }
            z = sm_cmul(z, sm_cx(cosine[lane], sine[lane]));
        }
    }
}

/* Replaces `fresh` by its distance from the limit, change * r / (1 - r), in each coefficient that
 * converges slowly. Returns 0 if there is none. */
static int extrapolate(const sm_torus_grid *grid, const sm_acceleration *a) {
    const size_t n = (size_t)grid->contact->contacts;
    int any_slow = 0;
    for (size_t at = 0; at < 2 * coefficients(grid) * n; at += 2 * n) {
        double *now = a->fresh + at, *last = a->spectrum + at, *before = a->change + at;
        double re = 0.0, im = 0.0, norm = 0.0;
        for (size_t k = 0; k < 2 * n; k += 2) {
            const double d_re = now[k] - last[k], d_im = now[k + 1] - last[k + 1];
            re += d_re * before[k] + d_im * before[k + 1];
            im += d_im * before[k] - d_re * before[k + 1];
            norm += before[k] * before[k] + before[k + 1] * before[k + 1];
        }
        re = norm > 0.0 ? re / norm : 0.0;
        im = norm > 0.0 ? im / norm : 0.0;
        const double size2 = re * re + im * im, gap2 = (1.0 - re) * (1.0 - re) + im * im;
        const int slow = size2 > SM_SLOW_RATIO * SM_SLOW_RATIO
                         && size2 < (1.0 + SMALLEST_GAP) * (1.0 + SMALLEST_GAP)
                         && gap2 > SMALLEST_GAP * SMALLEST_GAP;
        const double f_re = slow ? (re * (1.0 - re) - im * im) / gap2 : 0.0;
        const double f_im = slow ? im / gap2 : 0.0;
        for (size_t k = 0; k < 2 * n; k += 2) {
            const double d_re = now[k] - last[k], d_im = now[k + 1] - last[k + 1];
            now[k] = d_re * f_re - d_im * f_im;
            now[k + 1] = d_re * f_im + d_im * f_re;
        }
        any_slow |= slow;
    }
    return any_slow;
}

int sm_accelerate(const sm_torus_grid *grid, sm_torus_group *g, size_t p, int wanted) {
    sm_acceleration *a = &g->acceleration[p];
    const size_t size = 2 * coefficients(grid) * (size_t)grid->contact->contacts;
    transform(grid, g, p, 0);
    if (a->recorded == 2 && wanted) {
        if (extrapolate(grid, a)) {
            transform(grid, g, p, 1);
            a->recorded = 0;
            return 1;
        }
        transform(grid, g, p, 0);
    }
    if (a->recorded >= 1)
        for (size_t k = 0; k < size; k++) a->change[k] = a->fresh[k] - a->spectrum[k];
    memcpy(a->spectrum, a->fresh, size * sizeof(double));
    a->recorded = a->recorded < 2 ? a->recorded + 1 : 2;
    return 0;
}

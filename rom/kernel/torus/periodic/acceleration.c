#include "torus/periodic/acceleration.h"

#include <string.h>

/* Closer to 1 than these the limit is ill-determined. */
#define LARGEST_RATIO 1.02
#define SMALLEST_GAP 0.02

static int coefficients(int lines) { return lines < 2 ? 1 : lines / 2; }

static size_t spectrum_size(int contacts, int lines) {
    return (size_t)coefficients(lines) * (size_t)contacts * 2;
}

void sm_acceleration_place(sm_acceleration *a, int contacts, int lines, sm_block *block) {
    a->contacts = contacts;
    a->lines = lines;
    a->spectrum = sm_take(block, spectrum_size(contacts, lines));
    a->change = sm_take(block, spectrum_size(contacts, lines));
    a->fresh = sm_take(block, spectrum_size(contacts, lines));
}

void sm_acceleration_start(sm_acceleration *a) { a->recorded = 0; }

/* fresh_m = mean over lines of x exp(-i m t_B); the inverse: x += increments. */
static void transform(sm_acceleration *a, const double *cosine, const double *sine, double *x,
                      int inverse) {
    const int n = a->contacts, lines = a->lines;
    if (!inverse) memset(a->fresh, 0, spectrum_size(n, lines) * sizeof(double));
    for (int p = 0; p < lines; p++) {
        double re = 1.0, im = 0.0; /* exp(i m t_B) */
        for (int m = 0; m < coefficients(lines); m++) {
            for (int i = 0; i < n; i++) {
                double *c = a->fresh + 2 * ((size_t)m * (size_t)n + (size_t)i);
                double *value = x + (size_t)i * (size_t)lines + p;
                if (inverse) {
                    *value += (m == 0 ? 1.0 : 2.0) * (c[0] * re - c[1] * im);
                } else {
                    c[0] += *value * re / lines;
                    c[1] -= *value * im / lines;
                }
            }
            const double t = re * cosine[p] - im * sine[p];
            im = re * sine[p] + im * cosine[p];
            re = t;
        }
    }
}

/* Turns `fresh` into the increments to the limit; 0 if no coefficient is slow. */
static int extrapolate(sm_acceleration *a) {
    const int n = a->contacts;
    int due = 0;
    for (int m = 0; m < coefficients(a->lines); m++) {
        const size_t at = 2 * (size_t)m * (size_t)n;
        double *now = a->fresh + at, *last = a->spectrum + at, *before = a->change + at;
        double re = 0.0, im = 0.0, norm = 0.0;
        for (int k = 0; k < 2 * n; k += 2) {
            const double d_re = now[k] - last[k], d_im = now[k + 1] - last[k + 1];
            re += d_re * before[k] + d_im * before[k + 1];
            im += d_im * before[k] - d_re * before[k + 1];
            norm += before[k] * before[k] + before[k + 1] * before[k + 1];
        }
        re = norm > 0.0 ? re / norm : 0.0;
        im = norm > 0.0 ? im / norm : 0.0;
        const double size2 = re * re + im * im, gap2 = (1.0 - re) * (1.0 - re) + im * im;
        const int slow = size2 > SM_SLOW_RATIO * SM_SLOW_RATIO && size2 < LARGEST_RATIO * LARGEST_RATIO
                         && gap2 > SMALLEST_GAP * SMALLEST_GAP;
        /* change r / (1 - r) */
        const double f_re = slow ? (re * (1.0 - re) - im * im) / gap2 : 0.0;
        const double f_im = slow ? im / gap2 : 0.0;
        for (int k = 0; k < 2 * n; k += 2) {
            const double d_re = now[k] - last[k], d_im = now[k + 1] - last[k + 1];
            now[k] = d_re * f_re - d_im * f_im;
            now[k + 1] = d_re * f_im + d_im * f_re;
        }
        due |= slow;
    }
    return due;
}

int sm_accelerate(sm_acceleration *a, int wanted, const double *cosine, const double *sine,
                  double *x) {
    const size_t size = spectrum_size(a->contacts, a->lines);
    transform(a, cosine, sine, x, 0);
    if (a->recorded == 2 && wanted) {
        const int due = extrapolate(a);
        if (due) {
            transform(a, cosine, sine, x, 1);
            a->recorded = 0;
            return 1;
        }
        transform(a, cosine, sine, x, 0);
    }
    if (a->recorded >= 1)
        for (size_t k = 0; k < size; k++) a->change[k] = a->fresh[k] - a->spectrum[k];
    memcpy(a->spectrum, a->fresh, size * sizeof(double));
    a->recorded = a->recorded < 2 ? a->recorded + 1 : 2;
    return 0;
}

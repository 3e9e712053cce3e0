/* The contacts that slip under Coulomb friction, and the Cholesky factor of S over them.
 *
 * Newton's matrix for exact Coulomb friction is that of the slipping contacts, S_AA. From one
 * stage to the next few contacts begin or cease to slip: one that begins is a row at the end of
 * the factor, one that ceases is taken out by rotations, each at a cost of N_c^2.
 */
#ifndef SLIPMODE_SLIPPING_H
#define SLIPMODE_SLIPPING_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    int32_t *count;  /* of the slipping contacts */
    int32_t *order;  /* (N_c) their numbers, in the order of the factor's rows */
    int32_t *place;  /* (N_c) row of each contact, counted from 1; 0: it sticks */
    double *factor;  /* (N_c, N_c), lower triangle */
} sm_slipping;

/* int32_t of one lane, as doubles */
static inline size_t sm_slipping_counts(size_t contacts) { return contacts + 1; }

static inline sm_slipping sm_slipping_of(int contacts, int lane, double *counts, double *factor) {
    const size_t n = (size_t)contacts, l = (size_t)lane;
    int32_t *own = (int32_t *)(void *)(counts + l * sm_slipping_counts(n));
    return (sm_slipping){own, own + 2, own + 2 + n, factor + l * n * n};
}

static inline void sm_slipping_forget(const sm_slipping *a, int contacts) {
    *a->count = 0;
    for (int i = 0; i < contacts; i++) a->place[i] = 0;
}

/* Of S_ii, at least: where S is singular rounding may leave nothing of a pivot, or less. */
#define SM_LEAST_PIVOT 1e-14

static inline void sm_slipping_add(const sm_slipping *a, int n, const double *matrix, int i) {
    const int row = (*a->count)++;
    double *fresh = a->factor + (size_t)row * (size_t)n;
    for (int j = 0; j <= row; j++) {
        const double *earlier = a->factor + (size_t)j * (size_t)n;
        double sum = matrix[(size_t)i * (size_t)n + (size_t)(j < row ? a->order[j] : i)];
        for (int k = 0; k < j; k++) sum -= fresh[k] * earlier[k];
        fresh[j] = j < row ? sum / earlier[j] : sum;
    }
    const double least = SM_LEAST_PIVOT * matrix[(size_t)i * (size_t)n + (size_t)i];
    fresh[row] = sqrt(fresh[row] > least ? fresh[row] : least);
    a->order[row] = i;
    a->place[i] = row + 1;
}

static inline void sm_slipping_remove(const sm_slipping *a, int n, int i) {
    const int gone = a->place[i] - 1, last = --*a->count;
    a->place[i] = 0;
    for (int row = gone; row < last; row++) {
        double *f = a->factor + (size_t)row * (size_t)n;
        for (int k = 0; k <= row + 1; k++) f[k] = f[(size_t)n + (size_t)k];
        a->order[row] = a->order[row + 1];
        a->place[a->order[row]] = row + 1;
    }
    for (int k = gone; k < last; k++) { /* the row moved up has an entry right of the diagonal */
        double *f = a->factor + (size_t)k * (size_t)n;
        const double length = sqrt(f[k] * f[k] + f[k + 1] * f[k + 1]);
        const double c = f[k] / length, s = f[k + 1] / length;
        for (int row = k; row < last; row++, f += n) {
            const double along = c * f[k] + s * f[k + 1];
            f[k + 1] = c * f[k + 1] - s * f[k];
            f[k] = along;
        }
    }
}

/* z = S_AA^-1 z over the slipping contacts, in the order of the rows. */
static inline void sm_slipping_divide(const sm_slipping *a, int n, double *restrict z) {
    const int count = *a->count;
    for (int i = 0; i < count; i++) {
        const double *f = a->factor + (size_t)i * (size_t)n;
        double sum = z[i];
        for (int k = 0; k < i; k++) sum -= f[k] * z[k];
        z[i] = sum / f[i];
    }
    for (int i = count - 1; i >= 0; i--) {
        const double *f = a->factor + (size_t)i * (size_t)n;
        z[i] /= f[i];
        for (int k = 0; k < i; k++) z[k] -= f[k] * z[i];
    }
}

#endif

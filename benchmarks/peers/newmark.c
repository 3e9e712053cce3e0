/* Newmark's method written by hand for Jenkins contacts on a reduced basis: average acceleration,
 * modes of the structure with free contacts, so that the linear part is diagonal, and a system of
 * equations for the slipping contacts alone. rom.full is compared with it.
 *
 *   q'' + c q' + omega^2 q + W f(x) = p cos(Omega t),   x = W^T q
 *
 * With q_0 the result of a step without the contacts, D = W^T A^-1 W and y = k x - f it is
 * x - R y = (I - R k) W^T q_0, R = D (I + k D)^-1, where y is k s of a sticking contact with
 * its slider at s, and k x -+ limit of a slipping contact.
 */
#include <math.h>
#include <string.h>

#include "base/lanes.h"
#include "slipmode.h"

#define BLOCK 4 /* modes go in blocks of this many, the last one filled with zeros */
#define EACH(k, width)                                     \
    for (size_t block = 0; block < (width); block += BLOCK) \
        SM_SIMD for (size_t k = block; k < block + BLOCK; k++)
#define MOST_PASSES 50

typedef struct {
    int64_t contacts, width;
    double step, frequency;
    const double *gather, *response;      /* (N_c, width) (I - R k) W^T and A^-1 W */
    const double *flexibility;            /* (N_c, N_c) R */
    const double *limit, *stiffness;      /* (N_c) */
    const double *of_q, *of_v, *of_a, *of_force; /* (width) A^-1 times the start of the step */
    double *q, *v, *a, *moved;            /* (width) */
    double *x, *u, *y, *slider, *slips;   /* (N_c); slips: -1, 0 or 1 */
    double *matrix, *right;               /* (N_c, N_c), (N_c) of the slipping contacts */
    int64_t *active;                      /* (N_c) */
} peer_newmark_record;

SM_INLINE double dot(const double *restrict a, const double *restrict b, size_t width) {
    double part[BLOCK] = {0.0};
    EACH(k, width) part[k % BLOCK] += a[k] * b[k];
    return (part[0] + part[1]) + (part[2] + part[3]);
}

/* x of the slipping contacts, from (I - F k) x = u + F y, F their flexibility; no pivots: the
 * matrix is similar to a positive definite one. */
static void solve_slipping(peer_newmark_record *m, size_t count) {
    const size_t n = (size_t)m->contacts;
    for (size_t a = 0; a < count; a++) {
        const size_t i = (size_t)m->active[a];
        const double *row = m->flexibility + i * n;
        double sum = m->u[i];
        for (size_t j = 0; j < n; j++)
            sum += row[j] * (m->slips[j] != 0.0 ? -m->slips[j] * m->limit[j]
                                                : m->stiffness[j] * m->slider[j]);
        m->right[a] = sum;
        for (size_t b = 0; b < count; b++)
            m->matrix[a * n + b] =
                (double)(a == b) - row[m->active[b]] * m->stiffness[m->active[b]];
    }
    for (size_t c = 0; c < count; c++)
        for (size_t r = c + 1; r < count; r++) {
            const double factor = m->matrix[r * n + c] / m->matrix[c * n + c];
            for (size_t k = c + 1; k < count; k++)
                m->matrix[r * n + k] -= factor * m->matrix[c * n + k];
            m->right[r] -= factor * m->right[c];
        }
    for (size_t c = count; c-- > 0;) {
        for (size_t k = c + 1; k < count; k++) m->right[c] -= m->matrix[c * n + k] * m->right[k];
        m->right[c] /= m->matrix[c * n + c];
    }
}

/* x and y of all contacts, from u, and their sliders. 0 if the passes do not converge. */
SM_INLINE int solve_contacts(peer_newmark_record *m) {
    const size_t n = (size_t)m->contacts;
    for (int pass = 0; pass < MOST_PASSES; pass++) {
        size_t count = 0;
        for (size_t i = 0; i < n; i++)
            if (m->slips[i] != 0.0) m->active[count++] = (int64_t)i;
        solve_slipping(m, count);
        for (size_t i = 0; i < n; i++) m->y[i] = m->stiffness[i] * m->slider[i];
        for (size_t a = 0; a < count; a++) {
            const size_t i = (size_t)m->active[a];
            m->y[i] = m->stiffness[i] * m->right[a] - m->slips[i] * m->limit[i];
        }
        int converged = 1;
        for (size_t i = 0; i < n; i++) {
            const double *row = m->flexibility + i * n;
            double x = m->u[i];
            for (size_t j = 0; j < n; j++) x += row[j] * m->y[j];
            m->x[i] = x;
            const double trial = m->stiffness[i] * (x - m->slider[i]);
            const double slips = trial > m->limit[i] ? 1.0 : trial < -m->limit[i] ? -1.0 : 0.0;
            if (slips != m->slips[i]) converged = 0;
            m->slips[i] = slips;
        }
        if (!converged) continue;
        for (size_t i = 0; i < n; i++) {
            if (m->slips[i] != 0.0) m->slider[i] = m->y[i] / m->stiffness[i];
            m->slips[i] = 0.0;
        }
        return 1;
    }
    return 0;
}

SM_INLINE int step(peer_newmark_record *m, double wave) {
    const size_t width = (size_t)m->width, contacts = (size_t)m->contacts;
    const double h = m->step, first = 4.0 / (h * h), second = 4.0 / h, half = 0.5 * h;
    double *restrict q = m->q, *restrict v = m->v, *restrict a = m->a, *restrict moved = m->moved;
    const double *restrict of_q = m->of_q, *restrict of_v = m->of_v, *restrict of_a = m->of_a;
    const double *restrict of_force = m->of_force;
    EACH(k, width)
        moved[k] = of_q[k] * q[k] + of_v[k] * v[k] + of_a[k] * a[k] + of_force[k] * wave;
    for (size_t i = 0; i < contacts; i++) m->u[i] = dot(m->gather + i * width, moved, width);
    if (!solve_contacts(m)) return 0;
    for (size_t i = 0; i < contacts; i++) {
        const double *restrict response = m->response + i * width;
        const double force = m->stiffness[i] * m->x[i] - m->y[i];
        EACH(k, width) moved[k] -= response[k] * force;
    }
    EACH(k, width) {
        const double now = first * (moved[k] - q[k]) - second * v[k] - a[k];
        v[k] += half * (a[k] + now);
        a[k] = now;
        q[k] = moved[k];
    }
    return 1;
}

/* `samples` times `every` steps; displacements of the contacts (samples, N_c). */
SM_API SM_HOT sm_status peer_newmark(peer_newmark_record *m, size_t samples, size_t every,
                                     double *contact) {
    const size_t contacts = (size_t)m->contacts;
    for (size_t s = 0; s < samples; s++) {
        for (size_t k = s * every + 1; k <= (s + 1) * every; k++)
            if (!step(m, cos(m->frequency * m->step * (double)k))) return SM_NOT_CONVERGED;
        memcpy(contact + s * contacts, m->x, contacts * sizeof(double));
    }
    return SM_OK;
}

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
#include <stdlib.h>
#include <string.h>

#include "base/block.h"
#include "base/lanes.h"
#include "slipmode.h"

#define BLOCK 4 /* coordinates go in blocks of this many, the last one filled with zeros */
#define EACH(k, width)                                     \
    for (size_t block = 0; block < (width); block += BLOCK) \
        SM_SIMD for (size_t k = block; k < block + BLOCK; k++)
#define MOST_PASSES 50

typedef struct {
    size_t contacts, width;
    double *gather, *response;            /* (N_c, width) (I - R k) W^T and A^-1 W */
    const double *flexibility;            /* (N_c, N_c) R */
    double *of_q, *of_v, *of_a, *of_force;  /* (width) A^-1 times the start of the step */
    double *q, *v, *a;                    /* (width) */
    double *x, *u, *y, *slider, *slips;   /* (N_c); slips: -1, 0 or 1 */
    double *matrix, *right;               /* of the slipping contacts */
    size_t *active;
    const double *limit, *stiffness;      /* (N_c) */
} newmark;

SM_INLINE double dot(const double *restrict a, const double *restrict b, size_t width) {
    double part[BLOCK] = {0.0};
    EACH(k, width) part[k % BLOCK] += a[k] * b[k];
    return (part[0] + part[1]) + (part[2] + part[3]);
}

/* x of the slipping contacts, from (I - F k) x = u + F y, F their flexibility; no pivots: the
 * matrix is similar to a positive definite one. */
static void solve_slipping(newmark *m, size_t count) {
    const size_t n = m->contacts;
    for (size_t a = 0; a < count; a++) {
        const size_t i = m->active[a];
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
SM_INLINE int solve_contacts(newmark *m) {
    const size_t n = m->contacts;
    for (int pass = 0; pass < MOST_PASSES; pass++) {
        size_t count = 0;
        for (size_t i = 0; i < n; i++)
            if (m->slips[i] != 0.0) m->active[count++] = i;
        solve_slipping(m, count);
        for (size_t i = 0; i < n; i++) m->y[i] = m->stiffness[i] * m->slider[i];
        for (size_t a = 0; a < count; a++) {
            const size_t i = m->active[a];
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

SM_INLINE int step(newmark *m, double h, double wave) {
    const size_t width = m->width;
    double *restrict q = m->q, *restrict v = m->v, *restrict a = m->a;
    const double *restrict of_q = m->of_q, *restrict of_v = m->of_v, *restrict of_a = m->of_a;
    const double *restrict of_force = m->of_force;
    const double first = 4.0 / (h * h), second = 4.0 / h, half = 0.5 * h;
    double *restrict moved = m->response + m->contacts * width;
    EACH(k, width) moved[k] = of_q[k] * q[k] + of_v[k] * v[k] + of_a[k] * a[k] + of_force[k] * wave;
    for (size_t i = 0; i < m->contacts; i++) m->u[i] = dot(m->gather + i * width, moved, width);
    if (!solve_contacts(m)) return 0;
    for (size_t i = 0; i < m->contacts; i++) {
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

static size_t size_of(size_t contacts, size_t width) {
    return width * (2 * contacts + 8) + contacts * (7 + contacts);
}

static void place(newmark *m, double *memory) {
    const size_t n = m->contacts, width = m->width;
    double **rows[] = {&m->of_q, &m->of_v, &m->of_a, &m->of_force, &m->q, &m->v, &m->a};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) *rows[k] = sm_take(&memory, width);
    m->gather = sm_take(&memory, n * width);
    m->response = sm_take(&memory, (n + 1) * width);
    m->matrix = sm_take(&memory, n * n);
    double **values[] = {&m->x, &m->u, &m->y, &m->slider, &m->slips, &m->right};
    for (size_t k = 0; k < sizeof values / sizeof *values; k++)
        *values[k] = sm_take(&memory, n);
    m->active = (void *)memory;
}

/* Coefficients of the steps, and the state at rest under the initial force. */
static void prepare(newmark *m, size_t n, double h, const double *squares, const double *damping,
                    const double *directions, const double *pattern) {
    for (size_t k = 0; k < n; k++) {
        const double c = damping[k];
        const double inverse = 1.0 / (squares[k] + 2.0 * c / h + 4.0 / (h * h));
        m->of_q[k] = inverse * (4.0 / (h * h) + 2.0 * c / h);
        m->of_v[k] = inverse * (4.0 / h + c);
        m->of_a[k] = inverse;
        m->of_force[k] = inverse * pattern[k];
        m->a[k] = pattern[k];
        for (size_t i = 0; i < m->contacts; i++)
            m->response[i * m->width + k] = inverse * directions[i * n + k];
    }
    for (size_t i = 0; i < m->contacts; i++)
        for (size_t j = 0; j < m->contacts; j++) {
            const double part =
                (double)(i == j) - m->flexibility[i * m->contacts + j] * m->stiffness[j];
            for (size_t k = 0; k < n; k++)
                m->gather[i * m->width + k] += part * directions[j * n + k];
        }
}

SM_HOT static int march(newmark *m, double h, double frequency, size_t first, size_t steps) {
    for (size_t k = first + 1; k <= first + steps; k++)
        if (!step(m, h, cos(frequency * h * (double)k))) return 0;
    return 1;
}

/* From rest under p cos(Omega t): `samples` times `every` steps h on n modes.
 *   squares, damping, pattern (n), directions (N_c, n), limit, stiffness (N_c),
 *   flexibility (N_c, N_c), output (outputs, n);
 *   displacement (samples, outputs), contact (samples, N_c). */
SM_API sm_status peer_newmark(int32_t modes, int32_t contacts, const double *squares,
                              const double *damping, const double *directions,
                              const double *pattern, double frequency, const double *limit,
                              const double *stiffness, const double *flexibility, double h,
                              size_t samples, size_t every, int32_t outputs,
                              const double *output, double *displacement, double *contact) {
    const size_t n = (size_t)modes, rows = (size_t)outputs;
    newmark m = {.contacts = (size_t)contacts, .width = (n + BLOCK - 1) / BLOCK * BLOCK,
                 .limit = limit, .stiffness = stiffness, .flexibility = flexibility};
    double *memory = calloc(size_of(m.contacts, m.width), sizeof(double));
    if (!memory) return SM_NO_MEMORY;
    place(&m, memory);
    prepare(&m, n, h, squares, damping, directions, pattern);
    sm_status status = SM_OK;
    for (size_t s = 0; s < samples && status == SM_OK; s++) {
        if (!march(&m, h, frequency, s * every, every)) status = SM_NOT_CONVERGED;
        for (size_t i = 0; i < rows; i++) {
            double sum = 0.0;
            for (size_t k = 0; k < n; k++) sum += output[i * n + k] * m.q[k];
            displacement[s * rows + i] = sum;
        }
        memcpy(contact + s * m.contacts, m.x, m.contacts * sizeof(double));
    }
    free(memory);
    return status;
}

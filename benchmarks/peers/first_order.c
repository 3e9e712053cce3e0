/* y' = f(t, y), y = (x, x'), of a structure with tanh friction, and df/dy, for general-purpose
 * integrators.
 *
 *   x'' = S (x, x') - G tanh(W^T x' / alpha) + sum_j p_j cos(Omega_j t)
 */
#include <math.h>
#include <string.h>

#include "base/lanes.h"
#include "slipmode.h"

typedef struct {
    int32_t dofs, contacts, modes;
    const double *linear;    /* S (n, 2 n), -M^-1 K and -M^-1 C side by side */
    const double *slip;      /* (N_c, n) W^T / alpha */
    const double *friction;  /* G (n, N_c), M^-1 W mu N */
    const double *pattern;   /* (modes, n) M^-1 f_j */
    const double *frequency; /* (modes) [rad/s] */
} peer_first_order;

SM_INLINE double dot(const double *restrict a, const double *restrict b, size_t n) {
    double sum = 0.0;
    SM_SIMD_SUM(sum)
    for (size_t k = 0; k < n; k++) sum += a[k] * b[k];
    return sum;
}

SM_API SM_HOT void peer_first_order_rate(const peer_first_order *p, double t, const double *y,
                                         double *f) {
    const size_t n = (size_t)p->dofs, contacts = (size_t)p->contacts;
    memcpy(f, y + n, n * sizeof(double));
    for (size_t i = 0; i < n; i++) f[n + i] = dot(p->linear + i * 2 * n, y, 2 * n);
    for (size_t c = 0; c < contacts; c++) {
        const double g = tanh(dot(p->slip + c * n, y + n, n));
        for (size_t i = 0; i < n; i++) f[n + i] -= p->friction[i * contacts + c] * g;
    }
    for (size_t j = 0; j < (size_t)p->modes; j++) {
        const double wave = cos(p->frequency[j] * t);
        for (size_t i = 0; i < n; i++) f[n + i] += p->pattern[j * n + i] * wave;
    }
}

/* J (2 n, 2 n), rows of f. */
SM_API SM_HOT void peer_first_order_jacobian(const peer_first_order *p, const double *y,
                                             double *J) {
    const size_t n = (size_t)p->dofs, contacts = (size_t)p->contacts;
    memset(J, 0, 2 * n * n * sizeof(double));
    for (size_t i = 0; i < n; i++) J[i * 2 * n + n + i] = 1.0;
    memcpy(J + 2 * n * n, p->linear, 2 * n * n * sizeof(double));
    for (size_t c = 0; c < contacts; c++) {
        const double *slip = p->slip + c * n;
        const double g = tanh(dot(slip, y + n, n)), slope = 1.0 - g * g;
        for (size_t i = 0; i < n; i++) {
            const double by = p->friction[i * contacts + c] * slope;
            double *row = J + (n + i) * 2 * n + n;
            if (by == 0.0) continue;
            for (size_t k = 0; k < n; k++) row[k] -= by * slip[k];
        }
    }
}

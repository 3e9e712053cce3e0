#include "torus/fixed_point/marched.h"

#include <string.h>

#include "base/lanes.h"

#define ENTRIES 8 /* of advance: (p, v, g_0, g_1) to p, and to v */
#define WIDTH SM_VECTOR /* the stride is a multiple */

void sm_marched_place(sm_marched *m, const sm_modal_response *response, size_t contacts,
                      size_t stride, double *memory) {
    *m = (sm_marched){response, sm_marched_modes(response), contacts, stride, memory};
}

void sm_marched_start(sm_marched *m) {
    memset(m->state, 0, sm_marched_size(m->response, m->stride) * sizeof(double));
}

SM_HOT void sm_marched_displace(const sm_marched *m, double *u) {
    for (size_t k = 0; k < m->modes; k++)
        for (size_t first = 0; first < m->stride; first += WIDTH) {
            const double *restrict by = m->response->advance + ENTRIES * k;
            const double *restrict drawn = m->response->drawn + k * m->contacts;
            const double *restrict s = m->state + 3 * k * m->stride + first;
            double now[WIDTH]; /* stays in registers */
            SM_SIMD
            for (size_t p = 0; p < WIDTH; p++)
                now[p] = by[0] * s[p] + by[1] * s[m->stride + p] + by[2] * s[2 * m->stride + p];
            for (size_t i = 0; i < m->contacts; i++) {
                double *restrict to = u + i * m->stride + first;
                SM_SIMD
                for (size_t p = 0; p < WIDTH; p++) to[p] += drawn[i] * now[p];
            }
        }
}

SM_HOT void sm_marched_advance(sm_marched *m, const double *y) {
    for (size_t k = 0; k < m->modes; k++)
        for (size_t first = 0; first < m->stride; first += WIDTH) {
            const double *restrict by = m->response->advance + ENTRIES * k;
            const double *restrict drawn = m->response->drawn + k * m->contacts;
            double *restrict s = m->state + 3 * k * m->stride + first;
            double *restrict v = s + m->stride, *restrict g = v + m->stride;
            double force[WIDTH] = {0.0}; /* stays in registers */
            for (size_t i = 0; i < m->contacts; i++) {
                const double *restrict from = y + i * m->stride + first;
                SM_SIMD
                for (size_t p = 0; p < WIDTH; p++) force[p] += drawn[i] * from[p];
            }
            SM_SIMD
            for (size_t p = 0; p < WIDTH; p++) {
                const double at = by[0] * s[p] + by[1] * v[p] + by[2] * g[p] + by[3] * force[p];
                v[p] = by[4] * s[p] + by[5] * v[p] + by[6] * g[p] + by[7] * force[p];
                s[p] = at;
                g[p] = force[p];
            }
        }
}

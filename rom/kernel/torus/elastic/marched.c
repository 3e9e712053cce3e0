#include "torus/elastic/marched.h"

#include <string.h>

#include "base/lanes.h"

#define ENTRIES 8 /* of `advance` for a mode: factors of p, v, g_0, g_1 in p, and in v */
#define WIDTH SM_VECTOR /* the stride is a multiple of it */

void sm_marched_place(sm_marched *m, const sm_modal_response *response, size_t contacts,
                      size_t stride, sm_block *block) {
    *m = (sm_marched){response, sm_marched_modes(response), contacts, stride,
                      sm_take(block, sm_marched_size(response, stride))};
}

void sm_marched_start(sm_marched *m) {
    memset(m->state, 0, sm_marched_size(m->response, m->stride) * sizeof(double));
}

/* Adds 2 Re(G r exp(i m t_B0)) to s (lines), for complex G and r. */
static void add_turned(const sm_phase_lines *l, int m, const double G[2], const double r[2],
                       double *s) {
    const double re = 2.0 * (G[0] * r[0] - G[1] * r[1]), im = 2.0 * (G[0] * r[1] + G[1] * r[0]);
    const double *c = sm_phases_power(&l->phases, m), *d = c + l->phases.wide;
    for (size_t p = 0; p < l->lines; p++) s[p] += re * c[p] - (m < 0 ? -im : im) * d[p];
}

void sm_marched_begin(sm_marched *m, const sm_phase_lines *lines, const double *Y) {
    static const double unit[2] = {1.0, 0.0};
    sm_marched_start(m);
    for (size_t q = 0; q < lines->orders; q++, Y += 2 * m->contacts)
        for (size_t k = 0; k < m->modes; k++) {
            const double *projection = m->response->projection + k * m->contacts;
            const double *per = m->response->periodic + 4 * (q * m->modes + k);
            double G[2] = {0.0, 0.0}, *s = m->state + 3 * k * m->stride;
            for (size_t i = 0; i < m->contacts; i++) {
                G[0] += projection[i] * Y[2 * i];
                G[1] += projection[i] * Y[2 * i + 1];
            }
            const int turns = lines->order[2 * q + 1];
            add_turned(lines, turns, G, per, s);
            add_turned(lines, turns, G, per + 2, s + m->stride);
            add_turned(lines, turns, G, unit, s + 2 * m->stride);
        }
}

/* Returns the displacement of a mode per constant force. */
static double static_displacement(const double *advance) {
    return (advance[2] + advance[3]) / (1.0 - advance[0]);
}

double sm_marched_flexibility(const sm_marched *m, size_t i, size_t j) {
    double sum = 0.0;
    for (size_t k = 0; k < m->modes; k++) {
        const double *advance = m->response->advance + ENTRIES * k;
        const double *projection = m->response->projection + k * m->contacts;
        sum += projection[i] * projection[j] * (static_displacement(advance) - advance[3]);
    }
    return sum;
}

void sm_marched_shift(sm_marched *m, size_t p, size_t i, double y) {
    for (size_t k = 0; k < m->modes; k++) {
        const double g = m->response->projection[k * m->contacts + i] * y;
        double *s = m->state + 3 * k * m->stride + p;
        s[0] += static_displacement(m->response->advance + ENTRIES * k) * g;
        s[2 * m->stride] += g;
    }
}

SM_HOT void sm_marched_displace(const sm_marched *m, double *u) {
    for (size_t k = 0; k < m->modes; k++)
        for (size_t first = 0; first < m->stride; first += WIDTH) {
            const double *restrict by = m->response->advance + ENTRIES * k;
            const double *restrict projection = m->response->projection + k * m->contacts;
            const double *restrict s = m->state + 3 * k * m->stride + first;
            double now[WIDTH]; /* kept in registers */
            SM_SIMD
            for (size_t p = 0; p < WIDTH; p++)
                now[p] = by[0] * s[p] + by[1] * s[m->stride + p] + by[2] * s[2 * m->stride + p];
            for (size_t i = 0; i < m->contacts; i++) {
                double *restrict to = u + i * m->stride + first;
                SM_SIMD
                for (size_t p = 0; p < WIDTH; p++) to[p] += projection[i] * now[p];
            }
        }
}

SM_HOT void sm_marched_advance(sm_marched *m, const double *y) {
    for (size_t k = 0; k < m->modes; k++)
        for (size_t first = 0; first < m->stride; first += WIDTH) {
            const double *restrict by = m->response->advance + ENTRIES * k;
            const double *restrict projection = m->response->projection + k * m->contacts;
            double *restrict s = m->state + 3 * k * m->stride + first;
            double *restrict v = s + m->stride, *restrict g = v + m->stride;
            double force[WIDTH] = {0.0}; /* kept in registers */
            for (size_t i = 0; i < m->contacts; i++) {
                const double *restrict from = y + i * m->stride + first;
                SM_SIMD
                for (size_t p = 0; p < WIDTH; p++) force[p] += projection[i] * from[p];
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

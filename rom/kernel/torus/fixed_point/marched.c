#include "torus/fixed_point/marched.h"

#include <string.h>

#define ENTRIES 8 /* of advance: (p, v, g_0, g_1) to p, and to v */

void sm_marched_place(sm_marched *m, const sm_modal_response *response, size_t contacts,
                      size_t lines, double *memory) {
    *m = (sm_marched){response, sm_marched_modes(response), contacts, lines, memory};
}

void sm_marched_start(sm_marched *m) {
    memset(m->state, 0, sm_marched_size(m->response, m->lines) * sizeof(double));
}

void sm_marched_displace(const sm_marched *m, size_t line, double *u) {
    const double *s = m->state + 3 * m->modes * line;
    for (size_t k = 0; k < m->modes; k++, s += 3) {
        const double *by = m->response->advance + ENTRIES * k;
        const double *drawn = m->response->drawn + k * m->contacts;
        const double p = by[0] * s[0] + by[1] * s[1] + by[2] * s[2];
        for (size_t i = 0; i < m->contacts; i++) u[i] += drawn[i] * p;
    }
}

void sm_marched_advance(sm_marched *m, size_t line, const double *y) {
    double *s = m->state + 3 * m->modes * line;
    for (size_t k = 0; k < m->modes; k++, s += 3) {
        const double *by = m->response->advance + ENTRIES * k;
        const double *drawn = m->response->drawn + k * m->contacts;
        double g = 0.0;
        for (size_t i = 0; i < m->contacts; i++) g += drawn[i] * y[i];
        const double p = by[0] * s[0] + by[1] * s[1] + by[2] * s[2] + by[3] * g;
        const double v = by[4] * s[0] + by[5] * s[1] + by[6] * s[2] + by[7] * g;
        s[0] = p;
        s[1] = v;
        s[2] = g;
    }
}

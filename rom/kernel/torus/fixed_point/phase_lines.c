#include "torus/fixed_point/phase_lines.h"

#include <math.h>
#include <string.h>

#include "base/block.h"
#include "base/exact_sum.h"
#include "base/lanes.h"
#include "torus/grid.h"

#define WIDTH SM_VECTOR
#define TOGETHER SM_STEPS_TOGETHER

size_t sm_phase_lines_size(size_t contacts, size_t orders, size_t lines, size_t steps) {
    const size_t row = contacts * sm_whole_lines(lines);
    return 2 * steps * orders + 2 * lines + 4 * orders * row + 2 * TOGETHER * row;
}

void sm_phase_lines_place(sm_phase_lines *l, double *memory) {
    l->stride = sm_whole_lines(l->lines);
    const size_t row = l->contacts * l->stride;
    l->turn = sm_take(&memory, 2 * l->steps * l->orders);
    l->phase = sm_take(&memory, 2 * l->lines);
    l->drawn = sm_take(&memory, 2 * l->orders * row);
    l->sums = sm_take(&memory, 2 * l->orders * row);
    l->u = sm_take(&memory, TOGETHER * row);
    l->y = sm_take(&memory, TOGETHER * row);
    memset(l->y, 0, TOGETHER * row * sizeof(double)); /* of lanes without a line */
    memset(l->drawn, 0, 2 * l->orders * row * sizeof(double));
    for (size_t k = 0; k < l->steps; k++)
        for (size_t q = 0; q < l->orders; q++) {
            const double angle = SM_TWO_PI * (double)(k + 1) / (double)l->steps
                                 * (l->order[2 * q] + l->order[2 * q + 1] * l->ratio);
            l->turn[2 * (k * l->orders + q)] = cos(angle);
            l->turn[2 * (k * l->orders + q) + 1] = sin(angle);
        }
}

void sm_phase_lines_start(sm_phase_lines *l) {
    for (size_t p = 0; p < l->lines; p++) {
        l->phase[p] = cos(SM_TWO_PI * (double)p / (double)l->lines);
        l->phase[l->lines + p] = sin(SM_TWO_PI * (double)p / (double)l->lines);
    }
}

void sm_phase_lines_turn(sm_phase_lines *l, int half) {
    const double angle = half ? 0.5 * SM_TWO_PI * (l->ratio - 1.0) : SM_TWO_PI * l->ratio;
    const double c = cos(angle), s = sin(angle);
    for (size_t p = 0; p < l->lines; p++) {
        const double re = l->phase[p], im = l->phase[l->lines + p];
        l->phase[p] = re * c - im * s;
        l->phase[l->lines + p] = re * s + im * c;
    }
}

void sm_phase_lines_draw(sm_phase_lines *l, const double *harmonics) {
    for (size_t q = 0; q < l->orders; q++)
        for (size_t p = 0; p < l->lines; p++) {
            double c, s;
            sm_torus_power(l->phase[p], l->phase[l->lines + p], l->order[2 * q + 1], &c, &s);
            for (size_t i = 0; i < l->contacts; i++) {
                const double *h = harmonics + 2 * (q * l->contacts + i);
                double *to = l->drawn + 2 * (i * l->orders + q) * l->stride + p;
                to[0] = h[0] * c - h[1] * s;
                to[l->stride] = h[0] * s + h[1] * c;
            }
        }
}

/* u of WIDTH lines of a contact at `count` steps, a literal; u[k] is a row after u[k - 1]. */
SM_INLINE void displace(const size_t count, const sm_phase_lines *l, const double *turn,
                        const double *drawn, double *u) {
    const size_t row = l->contacts * l->stride, column = 2 * l->orders;
    double sum[TOGETHER][WIDTH] = {{0.0}}; /* stays in registers */
    for (size_t q = 0; q < l->orders; q++, turn += 2) {
        const double *restrict re = drawn + 2 * q * l->stride, *restrict im = re + l->stride;
        for (size_t k = 0; k < count; k++) {
            const double c = turn[k * column], s = turn[k * column + 1];
            SM_SIMD
            for (int p = 0; p < WIDTH; p++) sum[k][p] = (sum[k][p] + re[p] * c) - im[p] * s;
        }
    }
    for (size_t k = 0; k < count; k++) memcpy(u + k * row, sum[k], sizeof sum[k]);
}

SM_HOT void sm_phase_lines_displace(sm_phase_lines *l, size_t first, size_t count) {
    const double *turn = l->turn + 2 * first * l->orders;
    const size_t row = l->contacts * l->stride, column = 2 * l->orders;
    for (size_t i = 0; i < l->contacts; i++)
        for (size_t p = 0; p < l->stride; p += WIDTH) {
            const double *drawn = l->drawn + 2 * i * l->orders * l->stride + p;
            double *u = l->u + i * l->stride + p;
            if (count == TOGETHER)
                displace(TOGETHER, l, turn, drawn, u);
            else
                for (size_t k = 0; k < count; k++)
                    displace(1, l, turn + k * column, drawn, u + k * row);
        }
}

void sm_phase_lines_clear(sm_phase_lines *l) {
    memset(l->sums, 0, 2 * l->orders * l->contacts * l->stride * sizeof(double));
}

/* Adds y of WIDTH lines of a contact at `count` steps, a literal, to sums. */
SM_INLINE void add(const size_t count, const sm_phase_lines *l, const double *turn,
                   const double *weights, const double *y, double *sums) {
    const size_t row = l->contacts * l->stride, column = 2 * l->orders;
    double now[TOGETHER][WIDTH]; /* stays in registers */
    for (size_t k = 0; k < count; k++)
        for (int p = 0; p < WIDTH; p++) now[k][p] = weights[k] * y[k * row + (size_t)p];
    for (size_t q = 0; q < l->orders; q++, turn += 2) {
        double *restrict re = sums + 2 * q * l->stride, *restrict im = re + l->stride;
        SM_SIMD
        for (int p = 0; p < WIDTH; p++) {
            double a = re[p], b = im[p];
            for (size_t k = 0; k < count; k++) {
                a += now[k][p] * turn[k * column];
                b -= now[k][p] * turn[k * column + 1];
            }
            re[p] = a;
            im[p] = b;
        }
    }
}

SM_HOT void sm_phase_lines_add(sm_phase_lines *l, size_t first, size_t count,
                               const double *weights) {
    const double *turn = l->turn + 2 * first * l->orders;
    const size_t row = l->contacts * l->stride, column = 2 * l->orders;
    for (size_t i = 0; i < l->contacts; i++)
        for (size_t p = 0; p < l->stride; p += WIDTH) {
            const double *y = l->y + i * l->stride + p;
            double *sums = l->sums + 2 * i * l->orders * l->stride + p;
            if (count == TOGETHER)
                add(TOGETHER, l, turn, weights, y, sums);
            else
                for (size_t k = 0; k < count; k++)
                    add(1, l, turn + k * column, weights + k, y + k * row, sums);
        }
}

void sm_phase_lines_collect(const sm_phase_lines *l, size_t steps, double *Y) {
    for (size_t q = 0; q < l->orders; q++) {
        const int32_t *order = l->order + 2 * q;
        const double weight = (order[0] == 0 && order[1] == 0 ? 0.5 : 1.0)
                              / ((double)steps * (double)l->lines);
        double *own = Y + 2 * q * l->contacts;
        memset(own, 0, 2 * l->contacts * sizeof(double));
        for (size_t p = 0; p < l->lines; p++) {
            double c, s;
            sm_torus_power(l->phase[p], l->phase[l->lines + p], -order[1], &c, &s);
            for (size_t i = 0; i < l->contacts; i++) {
                const double *sums = l->sums + 2 * (i * l->orders + q) * l->stride + p;
                const double re = sums[0], im = sums[l->stride];
                own[2 * i] += weight * (re * c - im * s);
                own[2 * i + 1] += weight * (re * s + im * c);
            }
        }
    }
}

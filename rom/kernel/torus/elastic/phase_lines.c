#include "torus/elastic/phase_lines.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/exact_sum.h"
#include "base/lanes.h"

#define WIDTH SM_VECTOR
#define TOGETHER SM_TOGETHER

void sm_phase_lines_place(sm_phase_lines *l, sm_block *block) {
    l->stride = sm_whole_lines(l->lines);
    l->row = sm_whole_lines(l->contacts);
    const size_t all = l->contacts * l->stride;
    l->phasor = sm_take(block, 2 * l->steps * l->orders);
    l->phases = (sm_phases){.lines = l->lines, .wide = l->stride};
    sm_phases_place(&l->phases, l->orders, l->order, block);
    SM_TAKE_EACH(block, 2 * l->orders * l->row, &l->harmonics, &l->sums);
    l->by_power = sm_take(block, TOGETHER * 2 * l->phases.powers * l->row);
    SM_TAKE_EACH(block, TOGETHER * all, &l->u, &l->y);
    l->y_mean = sm_take(block, TOGETHER * l->lines * l->row);
    if (!block->memory) return;
    for (size_t k = 0; k < l->steps; k++)
        for (size_t q = 0; q < l->orders; q++) {
            const double angle = SM_TWO_PI * (double)(k + 1) / (double)l->steps
                                 * (l->order[2 * q] + l->order[2 * q + 1] * l->ratio);
            l->phasor[2 * (k * l->orders + q)] = cos(angle);
            l->phasor[2 * (k * l->orders + q) + 1] = sin(angle);
        }
}

/* Sums the harmonics of each |m| at a step: u = Re sum_m by_power_m exp(i m t_B0). */
SM_INLINE void add_harmonics(const sm_phase_lines *l, const double *phasor, double *by_power) {
    memset(by_power, 0, 2 * l->phases.powers * l->row * sizeof(double));
    for (size_t q = 0; q < l->orders; q++, phasor += 2) {
        const int m = l->order[2 * q + 1];
        const double c = phasor[0], s = phasor[1], back = m < 0 ? -1.0 : 1.0; /* conjugate of |m| */
        const double *restrict re = l->harmonics + 2 * q * l->row, *restrict im = re + l->row;
        double *restrict to = by_power + 2 * (size_t)abs(m) * l->row, *restrict im_to = to + l->row;
        for (size_t first = 0; first < l->row; first += WIDTH) {
            SM_SIMD
            for (size_t i = first; i < first + WIDTH; i++) {
                to[i] += re[i] * c - im[i] * s;
                im_to[i] += back * (re[i] * s + im[i] * c);
            }
        }
    }
}

/* Sets u of WIDTH lines of a contact at `count` (a literal) steps. */
SM_INLINE void displace(const size_t count, const sm_phase_lines *l, const double *by_power,
                        const double *across, double *u) {
    const size_t all = l->contacts * l->stride, step = 2 * l->phases.powers * l->row;
    double sum[TOGETHER][WIDTH] = {{0.0}}; /* kept in registers */
    for (size_t m = 0; m < l->phases.powers; m++, across += 2 * l->stride, by_power += 2 * l->row) {
        for (size_t k = 0; k < count; k++) {
            const double re = by_power[k * step], im = by_power[k * step + l->row];
            SM_SIMD
            for (size_t p = 0; p < WIDTH; p++)
                sum[k][p] = (sum[k][p] + re * across[p]) - im * across[l->stride + p];
        }
    }
    for (size_t k = 0; k < count; k++) memcpy(u + k * all, sum[k], sizeof sum[k]);
}

SM_HOT void sm_phase_lines_displace(sm_phase_lines *l, size_t first, size_t count) {
    const size_t all = l->contacts * l->stride, step = 2 * l->phases.powers * l->row;
    for (size_t k = 0; k < count; k++)
        add_harmonics(l, l->phasor + 2 * (first + k) * l->orders, l->by_power + k * step);
    for (size_t i = 0; i < l->contacts; i++)
        for (size_t p = 0; p < l->stride; p += WIDTH) {
            const double *by_power = l->by_power + i, *across = l->phases.across + p;
            double *u = l->u + i * l->stride + p;
            if (count == TOGETHER)
                displace(TOGETHER, l, by_power, across, u);
            else
                for (size_t k = 0; k < count; k++)
                    displace(1, l, by_power + k * step, across, u + k * all);
        }
}

void sm_phase_lines_clear(sm_phase_lines *l) {
    memset(l->sums, 0, 2 * l->orders * l->row * sizeof(double));
}

/* Sums y exp(-i m t_B0) of WIDTH contacts at a step over the lines, for TOGETHER values of m. */
SM_INLINE void add_lines(const sm_phase_lines *l, size_t m, const double *y, double *by_power) {
    double re[TOGETHER][WIDTH] = {{0.0}}, im[TOGETHER][WIDTH] = {{0.0}}; /* kept in registers */
    for (size_t p = 0; p < l->lines; p++, y += l->row)
        for (size_t j = 0; j < TOGETHER; j++) {
            const double *from = l->phases.across + 2 * (m + j) * l->stride + p;
            const double c = from[0], s = from[l->stride];
            SM_SIMD
            for (size_t i = 0; i < WIDTH; i++) {
                re[j][i] += y[i] * c;
                im[j][i] -= y[i] * s;
            }
        }
    for (size_t j = 0; j < TOGETHER; j++) {
        memcpy(by_power + 2 * (m + j) * l->row, re[j], sizeof re[j]);
        memcpy(by_power + (2 * (m + j) + 1) * l->row, im[j], sizeof im[j]);
    }
}

/* Adds the sums over lines of WIDTH contacts at `count` (a literal) steps to their harmonics. */
SM_INLINE void add_steps(const size_t count, const sm_phase_lines *l, const double *phasor,
                         double weight, const double *by_power, double *sums) {
    const size_t step = 2 * l->phases.powers * l->row;
    for (size_t q = 0; q < l->orders; q++, phasor += 2, sums += 2 * l->row) {
        const int m = l->order[2 * q + 1];
        const double *from = by_power + 2 * (size_t)abs(m) * l->row;
        const double back = m < 0 ? -1.0 : 1.0; /* conjugate of |m| */
        double re[WIDTH], im[WIDTH]; /* kept in registers */
        memcpy(re, sums, sizeof re);
        memcpy(im, sums + l->row, sizeof im);
        for (size_t k = 0; k < count; k++) {
            const double c = weight * phasor[2 * k * l->orders];
            const double s = weight * phasor[2 * k * l->orders + 1];
            const double *restrict y = from + k * step;
            SM_SIMD
            for (size_t i = 0; i < WIDTH; i++) {
                re[i] += y[i] * c + back * y[l->row + i] * s;
                im[i] += back * y[l->row + i] * c - y[i] * s;
            }
        }
        memcpy(sums, re, sizeof re);
        memcpy(sums + l->row, im, sizeof im);
    }
}

SM_HOT void sm_phase_lines_add(sm_phase_lines *l, size_t first, size_t count, double weight) {
    const double *phasor = l->phasor + 2 * first * l->orders;
    const size_t step = 2 * l->phases.powers * l->row;
    for (size_t i = 0; i < l->row; i += WIDTH) {
        double *by_power = l->by_power + i, *sums = l->sums + i;
        for (size_t k = 0; k < count; k++)
            for (size_t m = 0; m < l->phases.powers; m += TOGETHER)
                add_lines(l, m, l->y_mean + k * l->lines * l->row + i, by_power + k * step);
        if (count == TOGETHER)
            add_steps(TOGETHER, l, phasor, weight, by_power, sums);
        else
            for (size_t k = 0; k < count; k++)
                add_steps(1, l, phasor + 2 * k * l->orders, weight, by_power + k * step, sums);
    }
}

void sm_phase_lines_collect(const sm_phase_lines *l, size_t steps, double *Y) {
    for (size_t q = 0; q < l->orders; q++, Y += 2 * l->contacts) {
        const int32_t *order = l->order + 2 * q;
        const double weight = (order[0] == 0 && order[1] == 0 ? 0.5 : 1.0)
                              / ((double)steps * (double)l->lines);
        for (size_t i = 0; i < l->contacts; i++) {
            Y[2 * i] = weight * l->sums[2 * q * l->row + i];
            Y[2 * i + 1] = weight * l->sums[(2 * q + 1) * l->row + i];
        }
    }
}

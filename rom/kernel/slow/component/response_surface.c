/* The response of the modes to the harmonics of the contacts, tabulated over the amplitude
 * plane. Coefficients are linear between the nodes of the friction table, which suffices for a
 * few per cent of the motion. A harmonic (n, m) has the phase of u_A^n u_B^m of the effective
 * amplitudes, and is proportional to the scale of the friction limits. contact_output.c calls
 * it. */
#include "slow/component/response_surface.h"

#include <math.h>

#include "base/lanes.h"
#include "table/table.h"

/* Returns the position of x in its cell, from 0 to 1; beyond the last node 1. */
static double place_in_cell(const double *node, int32_t count, double x, size_t *cell) {
    const double inside = fmin(x, node[count - 1]);
    const int32_t found = sm_find_cell(node, count, inside, -1);
    *cell = (size_t)found;
    return (inside - node[found]) / (node[found + 1] - node[found]);
}

sm_response_point sm_response_point_at(const sm_slow_flow *flow, const double *frequency,
                                       double limit_scale, const double *amplitude) {
    const sm_table *table = &flow->table;
    const double *node[SM_MODES] = {table->node_a, table->node_b};
    const int32_t count[SM_MODES] = {table->count_a, table->count_b};
    size_t cell[SM_MODES] = {0, 0};
    double place[SM_MODES] = {0.0, 0.0};
    sm_response_point point;
    for (int j = 0; j < SM_MODES; j++) {
        point.unit[j] = sm_cx(0.0, 0.0);
        if (j >= table->modes) continue;
        const sm_complex coupling = sm_coupling_at(flow, j, frequency[j]);
        const sm_complex e = sm_cmul(coupling, sm_pair(amplitude + 2 * j));
        const double modulus = sqrt(sm_cabs2(e));
        if (modulus > 0.0) point.unit[j] = sm_cscale(e, 1.0 / modulus);
        place[j] = place_in_cell(node[j], count[j], modulus / limit_scale, &cell[j]);
    }
    for (int k = 0; k < 4; k++) {
        const size_t next_a = k & 1, next_b = table->modes == SM_MODES ? k >> 1 : 0;
        point.node[k] = (cell[0] + next_a) * (size_t)table->count_b + cell[1] + next_b;
        point.weight[k] = limit_scale * (k & 1 ? place[0] : 1.0 - place[0])
                          * (k & 2 ? place[1] : 1.0 - place[1]);
    }
    return point;
}

/* Returns coefficient k of a table with `per_node` doubles at each node. */
SM_INLINE sm_complex coefficient_at(const sm_response_point *point, const double *values,
                                    size_t per_node, size_t k) {
    sm_complex sum = sm_cx(0.0, 0.0);
    for (int c = 0; c < 4; c++)
        sum = sm_cadd(sum, sm_cscale(sm_pair(values + point->node[c] * per_node + 2 * k),
                                     point->weight[c]));
    return sum;
}

SM_HOT void sm_response_coefficients(const sm_response_point *point, int count,
                                     const int32_t *orders, size_t width, const double *values,
                                     double *coefficient) {
    const size_t all = (size_t)count * width;
    double re[SM_MOST_ORDERS], im[SM_MOST_ORDERS];
    sm_harmonic_phasors(count, orders, point->unit, re, im);
    for (size_t k = 0; k < all; k++) {
        const sm_complex c = sm_cmul(coefficient_at(point, values, 2 * all, k),
                                     sm_cx(re[k / width], im[k / width]));
        coefficient[2 * k] = c.re;
        coefficient[2 * k + 1] = c.im;
    }
}

SM_HOT void sm_response_add_sums(const sm_response_point *point, int count, const int32_t *orders,
                                 size_t width, const double *values,
                                 const sm_complex carrier[SM_MODES], double *signal) {
    const size_t all = (size_t)count * width;
    const sm_complex wave[SM_MODES] = {sm_cmul(point->unit[0], carrier[0]),
                                       sm_cmul(point->unit[1], carrier[1])};
    double re[SM_MOST_ORDERS], im[SM_MOST_ORDERS];
    sm_harmonic_phasors(count, orders, wave, re, im);
    for (size_t k = 0; k < all; k++) {
        const sm_complex c = coefficient_at(point, values, 2 * all, k);
        signal[k % width] += re[k / width] * c.re - im[k / width] * c.im;
    }
}

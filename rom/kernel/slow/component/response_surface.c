#include "slow/component/contact_output.h"

#include <math.h>

#include "base/cnumber.h"
#include "base/lanes.h"
#include "slow/first_order.h"
#include "table/table.h"

/* The cell that holds x, and how far into it x is, from 0 to 1; beyond the last node: 1. */
static double place_in_cell(const double *node, int32_t count, double x, int32_t guess,
                            size_t *cell) {
    const double inside = fmin(x, node[count - 1]);
    const int32_t found = sm_find_cell(node, count, inside, guess);
    *cell = (size_t)found;
    return (inside - node[found]) / (node[found + 1] - node[found]);
}

sm_response_point sm_response_point_at(const sm_slow_flow *flow, sm_instant *instant,
                                       const sm_inputs *inputs, const double *y) {
    const sm_table *table = &flow->table;
    const size_t count_b = (size_t)table->count_b;
    sm_effective effective;
    sm_instant_set(instant, flow, inputs);
    sm_effective_at(flow, instant, y, &effective);
    sm_response_point point;
    for (int j = 0; j < SM_MODES; j++) /* there are no harmonics of a mode at rest */
        point.unit[j] = effective.modulus[j] > 0.0 ? sm_of(&effective.unit, j) : sm_cx(0.0, 0.0);
    size_t a, b = 0;
    const double in_a = place_in_cell(table->node_a, table->count_a, effective.modulus[0],
                                      instant->cell[0], &a);
    double in_b = 0.0;
    if (table->modes == SM_MODES)
        in_b = place_in_cell(table->node_b, table->count_b, effective.modulus[1], instant->cell[1],
                             &b);
    const size_t next_b = table->modes == SM_MODES ? b + 1 : b;
    const double scale = inputs->limit_scale;
    for (int k = 0; k < 4; k++) {
        const double along_a = k & 1 ? in_a : 1.0 - in_a, along_b = k & 2 ? in_b : 1.0 - in_b;
        point.node[k] = (k & 1 ? a + 1 : a) * count_b + (k & 2 ? next_b : b);
        point.weight[k] = scale * along_a * along_b;
    }
    return point;
}

/* Values at the point, as they are at the nodes. */
SM_INLINE double interpolated(const sm_response_point *point, const double *values,
                              size_t per_node, size_t k) {
    double sum = 0.0;
    for (int c = 0; c < 4; c++) sum += point->weight[c] * values[point->node[c] * per_node + k];
    return sum;
}

SM_HOT void sm_response_coefficients(const sm_response_point *point, int count,
                                     const int32_t *orders, size_t width, const double *values,
                                     double *restrict coefficient) {
    const size_t per_node = (size_t)count * width * 2;
    double re[SM_MOST_ORDERS], im[SM_MOST_ORDERS];
    sm_harmonic_phasors(count, orders, point->unit, re, im);
    SM_SIMD
    for (size_t k = 0; k < per_node; k++)
        coefficient[k] = interpolated(point, values, per_node, k);
    for (size_t q = 0; q < (size_t)count; q++)
        for (double *c = coefficient + 2 * q * width, *end = c + 2 * width; c < end; c += 2) {
            const double rotated = c[0] * re[q] - c[1] * im[q];
            c[1] = c[0] * im[q] + c[1] * re[q];
            c[0] = rotated;
        }
}

#define BLOCK 32 /* values side by side: even, they come in pairs */

SM_HOT void sm_response_add_sums(const sm_response_point *point, int count, const int32_t *orders,
                          size_t width, const double *values, const sm_complex carrier[SM_MODES],
                          double *signal) {
    const size_t per_node = (size_t)count * width * 2;
    double re[SM_MOST_ORDERS], im[SM_MOST_ORDERS];
    const sm_complex rotated[SM_MODES] = {sm_cmul(point->unit[0], carrier[0]),
                                         sm_cmul(point->unit[1], carrier[1])};
    sm_harmonic_phasors(count, orders, rotated, re, im);
    size_t q = 0, s = 0;
    for (size_t first = 0; first < per_node; first += BLOCK) {
        double value[BLOCK];
        const size_t size = per_node - first < BLOCK ? per_node - first : BLOCK;
        SM_SIMD
        for (size_t k = 0; k < size; k++)
            value[k] = interpolated(point, values, per_node, first + k);
        for (size_t k = 0; k < size; k += 2) {
            signal[s] += re[q] * value[k] - im[q] * value[k + 1];
            if (++s == width) s = 0, q++;
        }
    }
}

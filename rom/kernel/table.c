/* Friction tables: bicubic Hermite surfaces of S_j = Q_j |a_j| over the amplitude plane. */
#include "check.h"
#include "lanes.h"

#define MAX_COUNT 100000 /* nodes */

static sm_status check_nodes(const double *node, int32_t count) {
    if (!sm_all_finite(node, (size_t)count)) return SM_NOT_FINITE;
    if (node[0] != 0.0) return SM_BAD_ARGUMENT;
    for (int32_t i = 1; i < count; i++)
        if (!(node[i] > node[i - 1])) return SM_BAD_ARGUMENT;
    return SM_OK;
}

static size_t field_count(const sm_table *table) { 
    return 2 * (size_t)(table->modes + table->near + table->power);
}

/* What keeps a look-up inside the arrays. */
static int shape_is_valid(const sm_table *table) {
    if (!table || !table->node_a || !table->values) return 0;
    if (table->count_a < 2 || table->count_a > MAX_COUNT) return 0;
    if (table->near < 0 || table->near > SM_NEAR || (table->power & ~1)) return 0;
    if (table->modes == 1) return table->count_b == 1;
    return table->modes == SM_MODES && table->node_b && table->count_b >= 2 &&
           table->count_b <= MAX_COUNT;
}

sm_status sm_table_check(const sm_table *table) {
    if (!shape_is_valid(table)) return SM_BAD_ARGUMENT;
    sm_status status = check_nodes(table->node_a, table->count_a);
    if (status == SM_OK && table->modes == SM_MODES)
        status = check_nodes(table->node_b, table->count_b);
    if (status != SM_OK) return status;
    const size_t count = (size_t)table->count_a * (size_t)table->count_b * 4 * field_count(table);
    return sm_all_finite(table->values, count) ? SM_OK : SM_NOT_FINITE;
}

/* Index of the cell that holds x in [node[0], node[count - 1]]. */
static int32_t find_cell(const double *node, int32_t count, double x) {
    int32_t low = 0, high = count - 1;
    while (high - low > 1) {
        const int32_t middle = (low + high) / 2;
        if (x < node[middle])
            high = middle;
        else
            low = middle;
    }
    return low;
}

/* Cubic Hermite weights of (value, slope) at the left and right node of a cell of width h. */
static void hermite(double u, double h, double weight[4]) {
    const double u2 = u * u, u3 = u2 * u;
    weight[2] = 3.0 * u2 - 2.0 * u3;
    weight[0] = 1.0 - weight[2];
    weight[1] = h * (u - 2.0 * u2 + u3);
    weight[3] = h * (u3 - u2);
}

static void lookup_one_mode(const sm_table *table, double a, double *s) {
    const size_t fields = field_count(table);
    const int32_t i = find_cell(table->node_a, table->count_a, a);
    const double h = table->node_a[i + 1] - table->node_a[i];
    double w[4];
    hermite((a - table->node_a[i]) / h, h, w);
    const double *left = table->values + (size_t)i * 4 * fields, *right = left + 4 * fields;
    for (size_t f = 0; f < fields; f++)
        s[f] = w[0] * left[f] + w[1] * left[fields + f] + w[2] * right[f]
               + w[3] * right[fields + f];
}

SM_HOT static void lookup_two_modes(const sm_table *table, double a, double b,
                                    double *restrict s) {
    const size_t fields = field_count(table);
    const int32_t i = find_cell(table->node_a, table->count_a, a);
    const int32_t j = find_cell(table->node_b, table->count_b, b);
    const double h_a = table->node_a[i + 1] - table->node_a[i];
    const double h_b = table->node_b[j + 1] - table->node_b[j];
    double wa[4], wb[4], sum[SM_MOST_FIELDS] = {0.0};
    hermite((a - table->node_a[i]) / h_a, h_a, wa);
    hermite((b - table->node_b[j]) / h_b, h_b, wb);
    for (int p = 0; p < 2; p++)
        for (int q = 0; q < 2; q++) {
            const size_t node = (size_t)(i + p) * (size_t)table->count_b + (size_t)(j + q);
            const double *restrict v = table->values + node * 4 * fields;
            const double w = wa[2 * p] * wb[2 * q], w_a = wa[2 * p + 1] * wb[2 * q];
            const double w_b = wa[2 * p] * wb[2 * q + 1], w_ab = wa[2 * p + 1] * wb[2 * q + 1];
            SM_SIMD
            for (size_t f = 0; f < fields; f++)
                sum[f] += w * v[f] + w_a * v[fields + f] + w_b * v[2 * fields + f]
                          + w_ab * v[3 * fields + f];
        }
    for (size_t f = 0; f < fields; f++) s[f] = sum[f];
}

static sm_status check_amplitude(double amplitude, double largest) {
    if (!isfinite(amplitude)) return SM_NOT_FINITE;
    return amplitude >= 0.0 && amplitude <= largest ? SM_OK : SM_OUTSIDE_TABLE;
}

/* Called at every stage of the slow flow, so the nodes and values are not checked one by one. */
sm_status sm_table_lookup(const sm_table *table, const double *amplitudes, double *s) {
    if (!shape_is_valid(table) || !amplitudes || !s) return SM_BAD_ARGUMENT;
    sm_status status = check_amplitude(amplitudes[0], table->node_a[table->count_a - 1]);
    if (status == SM_OK && table->modes == SM_MODES)
        status = check_amplitude(amplitudes[1], table->node_b[table->count_b - 1]);
    if (status != SM_OK) return status;
    if (table->modes == 1)
        lookup_one_mode(table, amplitudes[0], s);
    else
        lookup_two_modes(table, amplitudes[0], amplitudes[1], s);
    return sm_all_finite(s, field_count(table)) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_table_lookup_many(const sm_table *table, size_t points, const double *amplitudes,
                               double *s) {
    sm_status status = sm_table_check(table);
    if (status == SM_OK && points > 0 && (!amplitudes || !s)) return SM_BAD_ARGUMENT;
    const size_t modes = status == SM_OK ? (size_t)table->modes : 0;
    for (size_t k = 0; k < points && status == SM_OK; k++)
        status = sm_table_lookup(table, amplitudes + k * modes, s + k * field_count(table));
    return status;
}

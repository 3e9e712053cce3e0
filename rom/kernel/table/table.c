/* Friction tables: bicubic Hermite surfaces of S_j = Q_j |a_j| over the amplitude plane. */
#include "table/table.h"

#include "base/check.h"
#include "base/lanes.h"

#define MAX_COUNT 100000 /* nodes */

static sm_status check_nodes(const double *node, int32_t count) {
    if (!sm_all_finite(node, (size_t)count)) return SM_NOT_FINITE;
    if (node[0] != 0.0) return SM_BAD_ARGUMENT;
    for (int32_t i = 1; i < count; i++)
        if (!(node[i] > node[i - 1])) return SM_BAD_ARGUMENT;
    return SM_OK;
}

static size_t field_count(const sm_table *table) {
    return 2 * (size_t)(table->modes + table->combinations + table->power);
}

static size_t correction_count(const sm_table *table) {
    return 2 * (size_t)(table->modes * table->modes);
}

/* What keeps a look-up inside the arrays. */
static int shape_is_valid(const sm_table *table) {
    if (!table || !table->node_a || !table->values) return 0;
    if (table->count_a < 2 || table->count_a > MAX_COUNT) return 0;
    if (table->combinations < 0 || table->combinations > SM_COMBINATIONS || (table->power & ~1))
        return 0;
    if (table->modes == 1) return table->count_b == 1;
    return table->modes == SM_MODES && table->node_b && table->count_b >= 2 &&
           table->count_b <= MAX_COUNT;
}

sm_status sm_table_check_shape(const sm_table *table) {
    return shape_is_valid(table) ? SM_OK : SM_BAD_ARGUMENT;
}

sm_status sm_table_check(const sm_table *table) {
    if (!shape_is_valid(table)) return SM_BAD_ARGUMENT;
    sm_status status = check_nodes(table->node_a, table->count_a);
    if (status == SM_OK && table->modes == SM_MODES)
        status = check_nodes(table->node_b, table->count_b);
    if (status != SM_OK) return status;
    const size_t rows = (size_t)table->count_a * (size_t)table->count_b * 4;
    if (!sm_all_finite(table->values, rows * field_count(table))) return SM_NOT_FINITE;
    const double *corrections[] = {table->rate_correction, table->detuning};
    for (size_t k = 0; k < sizeof corrections / sizeof *corrections; k++)
        if (corrections[k] && !sm_all_finite(corrections[k], rows * correction_count(table)))
            return SM_NOT_FINITE;
    return SM_OK;
}

int32_t sm_find_cell(const double *node, int32_t count, double x, int32_t guess) {
    if (guess >= 0 && guess < count - 1 && x >= node[guess] && x < node[guess + 1]) return guess;
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

/* Cubic Hermite weights in a cell, u of the way from its left node to its right one:
 *   value = f_0 + rise (f_1 - f_0) + bend_0 f_0' + bend_1 f_1'; the slope alike, without f_0. */
typedef struct {
    double rise, bend[2];
} hermite;

typedef struct {
    hermite value, slope;
} hermite_pair;

SM_INLINE hermite_pair hermite_at(const double *node, double x) {
    const double h = node[1] - node[0], per_h = 1.0 / h;
    const double u = (x - node[0]) * per_h, v = 1.0 - u, uv = u * v;
    return (hermite_pair){{u * u * (3.0 - 2.0 * u), {h * v * uv, -h * u * uv}},
                          {6.0 * per_h * uv, {v * (1.0 - 3.0 * u), u * (3.0 * u - 2.0)}}};
}

#define PARTS 3 /* value, d/da and d/db of the surface */
#define WIDTH 4 /* fields side by side */

/* A cell of the table and where in it a point lies. */
typedef struct {
    size_t fields;
    const double *low, *high; /* rows of the nodes at its two ends in a, those in b one by one */
    hermite_pair a, b;
    size_t node;              /* the first of its corners */
} patch;

/* Which of the arrays over the nodes is summed up. */
SM_INLINE void look_at(patch *cell, const sm_table *table, const double *values, size_t fields) {
    cell->fields = fields;
    cell->low = values + cell->node * 4 * fields;
    cell->high = cell->low + (size_t)table->count_b * 4 * fields;
}

SM_INLINE void patch_at(const sm_table *table, const double *amplitudes, const int32_t *cell,
                        patch *found) {
    found->a = hermite_at(table->node_a + cell[0], amplitudes[0]);
    found->node = (size_t)cell[0] * (size_t)table->count_b;
    if (table->modes == SM_MODES) {
        found->b = hermite_at(table->node_b + cell[1], amplitudes[1]);
        found->node += (size_t)cell[1];
    }
    look_at(found, table, table->values, field_count(table));
}

SM_INLINE double cubic(const hermite *w, double left, double left_slope, double right,
                       double right_slope) {
    const double bent = left + w->bend[0] * left_slope + w->bend[1] * right_slope;
    return bent + w->rise * (right - left);
}

SM_INLINE double cubic_slope(const hermite *w, double left, double left_slope, double right,
                             double right_slope) {
    const double bent = w->bend[0] * left_slope + w->bend[1] * right_slope;
    return bent + w->rise * (right - left);
}

/* The surface at `width` fields from the first one on: along a, for the value and d/db at each
 * node in b, and then along b. `width`, `modes` and `parts` are literals. */
SM_INLINE void sum_fields(const patch *cell, size_t first, size_t width, int modes, int parts,
                          double *restrict s) {
    const hermite_pair *a = &cell->a, *b = &cell->b;
    const size_t fields = cell->fields;
    const int rows = modes == SM_MODES ? 4 : 1;
    SM_SIMD
    for (size_t f = first; f < first + width; f++) {
        double value[4] = {0.0}, in_a[4] = {0.0};
        for (int k = 0; k < rows; k++) {
            const double *low = cell->low + 2 * (size_t)k * fields + f;
            const double *high = cell->high + 2 * (size_t)k * fields + f;
            value[k] = cubic(&a->value, low[0], low[fields], high[0], high[fields]);
            if (parts == PARTS)
                in_a[k] = cubic_slope(&a->slope, low[0], low[fields], high[0], high[fields]);
        }
        s[f] = rows == 1 ? value[0] : cubic(&b->value, value[0], value[1], value[2], value[3]);
        if (parts == 1) continue;
        s[fields + f] = rows == 1 ? in_a[0] : cubic(&b->value, in_a[0], in_a[1], in_a[2], in_a[3]);
        s[2 * fields + f] =
            rows == 1 ? 0.0 : cubic_slope(&b->slope, value[0], value[1], value[2], value[3]);
    }
}

/* Fields from `first` to before `end`, an even number of them. */
SM_INLINE void sum_range(const patch *cell, size_t first, size_t end, int modes, int parts,
                         double *s) {
    size_t f = first;
    for (; f + WIDTH <= end; f += WIDTH) sum_fields(cell, f, WIDTH, modes, parts, s);
    if (f < end) sum_fields(cell, f, 2, modes, parts, s);
}

SM_HOT static void sum_patch(const patch *cell, int modes, size_t sloped, double *s) {
    if (modes == 1) {
        sum_range(cell, 0, sloped, 1, PARTS, s);
        sum_range(cell, sloped, cell->fields, 1, 1, s);
    } else {
        sum_range(cell, 0, sloped, SM_MODES, PARTS, s);
        sum_range(cell, sloped, cell->fields, SM_MODES, 1, s);
    }
}

/* Leaves the cell of one amplitude. */
SM_INLINE sm_status find_cell_along(const double *node, int32_t count, double amplitude,
                                    int32_t *cell) {
    const int32_t guess = *cell;
    if (guess >= 0 && guess < count - 1 && amplitude >= node[guess] && amplitude < node[guess + 1])
        return SM_OK;
    if (!isfinite(amplitude)) return SM_NOT_FINITE;
    if (amplitude < 0.0 || amplitude > node[count - 1]) return SM_OUTSIDE_TABLE;
    *cell = sm_find_cell(node, count, amplitude, guess);
    return SM_OK;
}

/* Leaves the cell of the amplitudes, looked for first where `cell` says. */
SM_INLINE sm_status find_cell(const sm_table *table, const double *amplitudes, int32_t *cell) {
    sm_status status = find_cell_along(table->node_a, table->count_a, amplitudes[0], &cell[0]);
    if (status != SM_OK || table->modes != SM_MODES) return status;
    return find_cell_along(table->node_b, table->count_b, amplitudes[1], &cell[1]);
}

SM_HOT_ONE sm_status sm_table_slopes_from(const sm_table *table, const double *amplitudes,
                                          size_t sloped, int32_t *cell, double *slopes,
                                          double *rate_correction) {
    const sm_status status = find_cell(table, amplitudes, cell);
    if (status != SM_OK) return status;
    patch found;
    patch_at(table, amplitudes, cell, &found);
    sum_patch(&found, table->modes, sloped, slopes);
    if (!rate_correction || !table->rate_correction) return SM_OK;
    look_at(&found, table, table->rate_correction, correction_count(table));
    sum_patch(&found, table->modes, 0, rate_correction);
    return SM_OK;
}

void sm_table_detuning(const sm_table *table, const double *amplitudes, int sloped,
                       const int32_t *cell, double *slopes) {
    patch found;
    patch_at(table, amplitudes, cell, &found);
    look_at(&found, table, table->detuning, correction_count(table));
    sum_patch(&found, table->modes, sloped ? found.fields : 0, slopes);
}

/* The nodes and values are not checked one by one: a NaN among them shows in the result. */
sm_status sm_table_lookup(const sm_table *table, size_t points, const double *amplitudes,
                          double *s) {
    if (!shape_is_valid(table) || (points > 0 && (!amplitudes || !s))) return SM_BAD_ARGUMENT;
    const size_t fields = field_count(table);
    for (size_t k = 0; k < points; k++, s += fields, amplitudes += table->modes) {
        int32_t cell[SM_MODES] = {0};
        const sm_status status = sm_table_slopes_from(table, amplitudes, 0, cell, s, NULL);
        if (status != SM_OK) return status;
        if (!sm_all_finite(s, fields)) return SM_NOT_FINITE;
    }
    return SM_OK;
}

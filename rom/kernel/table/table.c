/* Friction tables: bicubic Hermite surfaces of S_j = Q_j |a_j|, eq. (20), over |a_A| and |a_B|.
 *
 * In a cell a surface is cubic in each amplitude. Values and slopes at the four corners determine
 * it: f, df/da, df/db and d2f/dadb. It is interpolated along a first, then along b. */
#include "table/table.h"

#include "base/check.h"
#include "base/hermite.h"

/* Checks that nodes are finite, increase, and begin at 0. */
static sm_status check_nodes(const double *node, int32_t count) {
    if (!sm_all_finite(node, (size_t)count)) return SM_NOT_FINITE;
    if (node[0] != 0.0) return SM_BAD_ARGUMENT;
    for (int32_t i = 1; i < count; i++)
        if (!(node[i] > node[i - 1])) return SM_BAD_ARGUMENT;
    return SM_OK;
}

/* Returns the number of columns of the table: real and imaginary parts of its complex fields. */
static size_t field_count(const sm_table *table) {
    return 2 * (size_t)(table->modes + table->combinations + table->power);
}

/* Returns the number of columns of the rate correction, and of the detuning. */
static size_t correction_count(const sm_table *table) {
    return 2 * (size_t)(table->modes * table->modes);
}

sm_status sm_table_check_shape(const sm_table *table) {
    if (!table || !table->node_a || !table->values) return SM_BAD_ARGUMENT;
    if (table->count_a < 2 || table->count_a > SM_MOST) return SM_BAD_ARGUMENT;
    if (table->combinations < 0 || table->combinations > SM_COMBINATIONS || (table->power & ~1))
        return SM_BAD_ARGUMENT;
    const int one = table->modes == 1 && table->count_b == 1;
    const int two = table->modes == SM_MODES && table->node_b && table->count_b >= 2
                    && table->count_b <= SM_MOST;
    return one || two ? SM_OK : SM_BAD_ARGUMENT;
}

sm_status sm_table_check(const sm_table *table) {
    SM_TRY(sm_table_check_shape(table));
    SM_TRY(check_nodes(table->node_a, table->count_a));
    if (table->modes == SM_MODES) SM_TRY(check_nodes(table->node_b, table->count_b));
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

/* Returns the weights at x between node[0] and node[1]. */
SM_INLINE sm_hermite hermite_at(const double *node, double x) {
    const double h = node[1] - node[0];
    return sm_hermite_at(h, (x - node[0]) * (1.0 / h));
}

#define PARTS 3 /* value, d/da and d/db of the surface */

/* A point in a cell of the table, and the array over the nodes that is interpolated there. */
typedef struct {
    size_t fields;            /* columns of the array */
    const double *low, *high; /* (2, 4, fields): corners at the lower and the higher a, by b */
    sm_hermite a, b;        /* weights along both amplitudes */
    size_t node;              /* index of the corner with the smallest amplitudes */
} table_point;

/* Selects the array that is interpolated: the table, its rate correction or its detuning. */
SM_INLINE void select_array(table_point *point, const sm_table *table, const double *values,
                            size_t fields) {
    point->fields = fields;
    point->low = values + point->node * 4 * fields;
    point->high = point->low + (size_t)table->count_b * 4 * fields;
}

/* Computes the weights of the amplitudes in their cell, and selects the table itself. */
SM_INLINE void locate(const sm_table *table, const double *amplitudes, const int32_t *cell,
                      table_point *point) {
    point->a = hermite_at(table->node_a + cell[0], amplitudes[0]);
    point->node = (size_t)cell[0] * (size_t)table->count_b;
    if (table->modes == SM_MODES) {
        point->b = hermite_at(table->node_b + cell[1], amplitudes[1]);
        point->node += (size_t)cell[1];
    }
    select_array(point, table, table->values, field_count(table));
}

/* Interpolates `width` columns from the first one on: along a, the values and d/db at both nodes
 * of b; then along b. `width`, `modes` and `parts` are literals. */
SM_INLINE void interpolate_columns(const table_point *point, size_t first, size_t width, int modes,
                                   int parts, double *restrict s) {
    const sm_hermite *a = &point->a, *b = &point->b;
    const size_t fields = point->fields;
    const int rows = modes == SM_MODES ? 4 : 1;
    SM_SIMD
    for (size_t f = first; f < first + width; f++) {
        double value[4] = {0.0}, in_a[4] = {0.0};
        for (int k = 0; k < rows; k++) {
            const double *low = point->low + 2 * (size_t)k * fields + f;
            const double *high = point->high + 2 * (size_t)k * fields + f;
            value[k] = sm_hermite_value(&a->value, low[0], low[fields], high[0], high[fields]);
            if (parts == PARTS)
                in_a[k] = sm_hermite_slope(&a->slope, low[0], low[fields], high[0], high[fields]);
        }
        s[f] = rows == 1 ? value[0] : sm_hermite_value(&b->value, value[0], value[1], value[2], value[3]);
        if (parts == 1) continue;
        s[fields + f] = rows == 1 ? in_a[0] : sm_hermite_value(&b->value, in_a[0], in_a[1], in_a[2], in_a[3]);
        s[2 * fields + f] =
            rows == 1 ? 0.0 : sm_hermite_slope(&b->slope, value[0], value[1], value[2], value[3]);
    }
}

/* Interpolates the columns first ... end - 1, an even number. */
SM_INLINE void interpolate_range(const table_point *point, size_t first, size_t end, int modes,
                                 int parts, double *s) {
    size_t f = first;
    for (; f + SM_SHORT_VECTOR <= end; f += SM_SHORT_VECTOR)
        interpolate_columns(point, f, SM_SHORT_VECTOR, modes, parts, s);
    if (f < end) interpolate_columns(point, f, 2, modes, parts, s);
}

/* Interpolates all columns, and the slopes of the first `sloped` ones. */
SM_HOT static void interpolate(const table_point *point, int modes, size_t sloped, double *s) {
    if (modes == 1) {
        interpolate_range(point, 0, sloped, 1, PARTS, s);
        interpolate_range(point, sloped, point->fields, 1, 1, s);
    } else {
        interpolate_range(point, 0, sloped, SM_MODES, PARTS, s);
        interpolate_range(point, sloped, point->fields, SM_MODES, 1, s);
    }
}

/* Finds the cell of one amplitude; SM_OUTSIDE_TABLE beyond the last node. */
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

/* Finds the cell of the amplitudes; the search begins at `cell`. */
SM_INLINE sm_status find_cell(const sm_table *table, const double *amplitudes, int32_t *cell) {
    SM_TRY(find_cell_along(table->node_a, table->count_a, amplitudes[0], &cell[0]));
    if (table->modes == 1) return SM_OK;
    return find_cell_along(table->node_b, table->count_b, amplitudes[1], &cell[1]);
}

SM_HOT_ONE sm_status sm_table_slopes_from(const sm_table *table, const double *amplitudes,
                                          size_t sloped, int32_t *cell, double *slopes,
                                          double *rate_correction) {
    SM_TRY(find_cell(table, amplitudes, cell));
    table_point point;
    locate(table, amplitudes, cell, &point);
    interpolate(&point, table->modes, sloped, slopes);
    if (!rate_correction || !table->rate_correction) return SM_OK;
    select_array(&point, table, table->rate_correction, correction_count(table));
    interpolate(&point, table->modes, 0, rate_correction);
    return SM_OK;
}

void sm_table_detuning(const sm_table *table, const double *amplitudes, int sloped,
                       const int32_t *cell, double *slopes) {
    table_point point;
    locate(table, amplitudes, cell, &point);
    select_array(&point, table, table->detuning, correction_count(table));
    interpolate(&point, table->modes, sloped ? point.fields : 0, slopes);
}

/* Nodes and values are not checked here: with a NaN among them the result is NaN and refused. */
sm_status sm_table_lookup(const sm_table *table, size_t points, const double *amplitudes,
                          double *s) {
    SM_TRY(sm_table_check_shape(table));
    if (points > 0 && (!amplitudes || !s)) return SM_BAD_ARGUMENT;
    const size_t fields = field_count(table);
    for (size_t k = 0; k < points; k++, s += fields, amplitudes += table->modes) {
        int32_t cell[SM_MODES] = {0};
        SM_TRY(sm_table_slopes_from(table, amplitudes, 0, cell, s, NULL));
        if (!sm_all_finite(s, fields)) return SM_NOT_FINITE;
    }
    return SM_OK;
}

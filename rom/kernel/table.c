/* Friction tables: bicubic Hermite surfaces of S_j = Q_j |a_j| over the amplitude plane. */
#include "table.h"

#include "block.h"
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

static size_t lag_count(const sm_table *table) {
    return 2 * (size_t)(table->modes * table->modes);
}

/* What keeps a look-up inside the arrays. */
static int shape_is_valid(const sm_table *table) {
    if (!table || !table->node_a || !table->values) return 0;
    if (table->count_a < 2 || table->count_a > MAX_COUNT) return 0;
    if (table->near < 0 || table->near > SM_NEAR || (table->power & ~1)) return 0;
    if (table->modes == 1) return table->count_b == 1 && !table->visited;
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
    return !table->lag || sm_all_finite(table->lag, rows * lag_count(table)) ? SM_OK
                                                                             : SM_NOT_FINITE;
}

/* Doubles of the nodes, of the values and of the lag, bytes of the cells. */
typedef struct {
    size_t a, b, values, lag, cells;
} sizes;

static sizes sizes_of(const sm_table *table) {
    const size_t a = (size_t)table->count_a, b = (size_t)table->count_b;
    return (sizes){a, table->modes == SM_MODES ? b : 0, a * b * 4 * field_count(table),
                   table->lag ? a * b * 4 * lag_count(table) : 0,
                   table->visited ? (a - 1) * (b - 1) : 0};
}

size_t sm_table_size(const sm_table *table) {
    const sizes s = sizes_of(table);
    return s.a + s.b + s.values + s.lag + sm_doubles(s.cells);
}

sm_table sm_table_copy(const sm_table *table, double **memory) {
    const sizes s = sizes_of(table);
    sm_table copy = *table;
    copy.node_a = sm_keep(memory, table->node_a, s.a);
    copy.node_b = sm_keep(memory, table->node_b, s.b);
    copy.values = sm_keep(memory, table->values, s.values);
    copy.lag = sm_keep(memory, table->lag, s.lag);
    copy.visited = sm_keep_bytes(memory, table->visited, s.cells);
    return copy;
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

/* Cubic Hermite weights of (value, slope) at the left and right node of a cell. */
typedef struct {
    double value[4], slope[4]; /* for the cubic and for its derivative */
} hermite;

static hermite hermite_at(const double *node, double x) {
    const double h = node[1] - node[0], per_h = 1.0 / h;
    const double u = (x - node[0]) * per_h, u2 = u * u, u3 = u2 * u;
    const double right = 3.0 * u2 - 2.0 * u3, steep = 6.0 * (u - u2) * per_h;
    const hermite w = {{1.0 - right, h * (u - 2.0 * u2 + u3), right, h * (u3 - u2)},
                       {-steep, 1.0 - 4.0 * u + 3.0 * u2, steep, 3.0 * u2 - 2.0 * u}};
    return w;
}

#define PARTS 3 /* value, d/da and d/db of the surface */
#define WIDTH 4 /* fields side by side */

/* A cell of the table and where in it a point lies. */
typedef struct {
    size_t fields;
    const double *low, *high; /* rows of the nodes at its two ends in a, those in b one by one */
    hermite a, b;
    size_t node;              /* the first of its corners */
} patch;

/* Which of the arrays over the nodes is summed up. */
static void look_at(patch *cell, const sm_table *table, const double *values, size_t fields) {
    cell->fields = fields;
    cell->low = values + cell->node * 4 * fields;
    cell->high = cell->low + (size_t)table->count_b * 4 * fields;
}

static patch patch_at(const sm_table *table, const double *amplitudes, const int32_t *cell) {
    patch found = {.node = (size_t)cell[0] * (size_t)table->count_b};
    found.a = hermite_at(table->node_a + cell[0], amplitudes[0]);
    if (table->modes == SM_MODES) {
        found.b = hermite_at(table->node_b + cell[1], amplitudes[1]);
        found.node += (size_t)cell[1];
    } else {
        found.b.value[0] = 1.0;
    }
    look_at(&found, table, table->values, field_count(table));
    return found;
}

/* The surface at `width` fields from the first one on. Rows are summed along a, for the value
 * and d/db at each node in b, and then along b. `width`, `rows_b` and `parts` are literals. */
SM_INLINE void sum_fields(const patch *cell, size_t first, size_t width, int rows_b, int parts,
                          double *restrict s) {
    const double *a = cell->a.value, *a_slope = cell->a.slope;
    const size_t fields = cell->fields;
    SM_SIMD
    for (size_t f = first; f < first + width; f++) {
        double value = 0.0, in_a = 0.0, in_b = 0.0;
        for (int k = 0; k < rows_b; k++) {
            const double *low = cell->low + 2 * (size_t)k * fields + f;
            const double *high = cell->high + 2 * (size_t)k * fields + f;
            const double along = a[0] * low[0] + a[1] * low[fields] + a[2] * high[0]
                                 + a[3] * high[fields];
            value += cell->b.value[k] * along;
            if (parts == 1) continue;
            in_a += cell->b.value[k]
                    * (a_slope[0] * low[0] + a_slope[1] * low[fields] + a_slope[2] * high[0]
                       + a_slope[3] * high[fields]);
            in_b += cell->b.slope[k] * along;
        }
        s[f] = value;
        if (parts == 1) continue;
        s[fields + f] = in_a;
        s[2 * fields + f] = in_b;
    }
}

SM_INLINE void sum_patch(const patch *cell, int rows_b, int parts, double *s) {
    if (cell->fields < WIDTH) {
        sum_fields(cell, 0, 2, rows_b, parts, s);
        return;
    }
    for (size_t f = 0; f + WIDTH < cell->fields; f += WIDTH)
        sum_fields(cell, f, WIDTH, rows_b, parts, s);
    sum_fields(cell, cell->fields - WIDTH, WIDTH, rows_b, parts, s); /* some of them again */
}

SM_HOT static void values_of(const patch *cell, int modes, double *s) {
    if (modes == 1)
        sum_patch(cell, 1, 1, s);
    else
        sum_patch(cell, 4, 1, s);
}

SM_HOT static void slopes_of(const patch *cell, int modes, double *s) {
    if (modes == 1)
        sum_patch(cell, 1, PARTS, s);
    else
        sum_patch(cell, 4, PARTS, s);
}

static sm_status check_amplitude(double amplitude, double largest) {
    if (!isfinite(amplitude)) return SM_NOT_FINITE;
    return amplitude >= 0.0 && amplitude <= largest ? SM_OK : SM_OUTSIDE_TABLE;
}

/* Leaves the cell of the amplitudes, looked for first where `cell` says. */
static sm_status find_cell(const sm_table *table, const double *amplitudes, int32_t *cell) {
    const int32_t count_a = table->count_a, count_b = table->count_b;
    sm_status status = check_amplitude(amplitudes[0], table->node_a[count_a - 1]);
    if (status != SM_OK) return status;
    cell[0] = sm_find_cell(table->node_a, count_a, amplitudes[0], cell[0]);
    if (table->modes != SM_MODES) return SM_OK;
    status = check_amplitude(amplitudes[1], table->node_b[count_b - 1]);
    if (status != SM_OK) return status;
    cell[1] = sm_find_cell(table->node_b, count_b, amplitudes[1], cell[1]);
    const size_t place = (size_t)cell[0] * (size_t)(count_b - 1) + (size_t)cell[1];
    return !table->visited || table->visited[place] ? SM_OK : SM_OUTSIDE_TABLE;
}

/* The nodes and values are not checked one by one: a NaN among them shows in the result. */
sm_status sm_table_lookup(const sm_table *table, const double *amplitudes, double *s) {
    if (!shape_is_valid(table) || !amplitudes || !s) return SM_BAD_ARGUMENT;
    int32_t cell[SM_MODES] = {0};
    const sm_status status = find_cell(table, amplitudes, cell);
    if (status != SM_OK) return status;
    const patch found = patch_at(table, amplitudes, cell);
    values_of(&found, table->modes, s);
    return sm_all_finite(s, found.fields) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_table_lookup_slopes(const sm_table *table, const double *amplitudes,
                                 double *slopes) {
    if (!shape_is_valid(table) || !amplitudes || !slopes) return SM_BAD_ARGUMENT;
    int32_t cell[SM_MODES] = {0};
    double lag[SM_LAGS];
    const sm_status status = sm_table_slopes_from(table, amplitudes, cell, slopes, lag);
    if (status != SM_OK) return status;
    return sm_all_finite(slopes, PARTS * field_count(table)) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_table_slopes_from(const sm_table *table, const double *amplitudes, int32_t *cell,
                               double *slopes, double *lag) {
    const sm_status status = find_cell(table, amplitudes, cell);
    if (status != SM_OK) return status;
    patch found = patch_at(table, amplitudes, cell);
    slopes_of(&found, table->modes, slopes);
    if (!table->lag) return SM_OK;
    look_at(&found, table, table->lag, lag_count(table));
    values_of(&found, table->modes, lag);
    return SM_OK;
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

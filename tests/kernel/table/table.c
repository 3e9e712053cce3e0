/* Friction tables. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "fixtures.h"
#include "table/table.h"

/* Everywhere the polynomial of the fixture, which a bicubic surface holds exactly. */
static void check_values(int modes, int count_a, int count_b) {
    table t = new_table(modes, count_a, count_b);
    double *points = new_doubles(200 * (size_t)modes), *s = new_doubles(400 * (size_t)modes);
    CHECK_STATUS(sm_table_check(&t.table), SM_OK);
    for (int k = 0; k < 200 * modes; k++) points[k] = 4.0 * random_number();
    points[0] = 0.0;
    points[200 * modes - 1] = 4.0; /* both ends belong to the table */
    CHECK_STATUS(sm_table_lookup(&t.table, 200, points, s), SM_OK);
    for (int k = 0; k < 200; k++) {
        double exact[4], alone[4];
        const double *point = points + k * modes;
        exact_friction(modes, point[0], modes == 2 ? point[1] : 0.0, exact);
        CHECK_STATUS(sm_table_lookup(&t.table, 1, point, alone), SM_OK);
        for (int f = 0; f < 2 * modes; f++) {
            CHECK_NEAR(alone[f], exact[f], 1e-14);
            CHECK(s[k * 2 * modes + f] == alone[f]);
        }
    }
    free_table(&t);
    free(points);
    free(s);
}

/* The slopes are those of the polynomial, by differences within a cell. */
static void check_slopes(int modes, int count_a, int count_b) {
    const double step = 1e-5;
    table t = new_table(modes, count_a, count_b);
    for (int k = 0; k < 200; k++) {
        const double at[2] = {0.1 + 3.8 * random_number(), 0.1 + 3.8 * random_number()};
        double slopes[12], value[4], after[4], before[4];
        int32_t cell[2] = {0, 0};
        CHECK_STATUS(sm_table_lookup(&t.table, 1, at, value), SM_OK);
        CHECK_STATUS(sm_table_slopes_from(&t.table, at, 2 * (size_t)modes, cell, slopes, NULL), SM_OK);
        for (int f = 0; f < 2 * modes; f++) CHECK_NEAR(slopes[f], value[f], 1e-16);
        for (int j = 0; j < 2; j++) {
            const double b = modes == 2 ? at[1] : 0.0, in_b = modes == 2 && j == 1 ? step : 0.0;
            const double in_a = j == 0 ? step : 0.0;
            exact_friction(modes, at[0] + in_a, b + in_b, after);
            exact_friction(modes, at[0] - in_a, b - in_b, before);
            for (int f = 0; f < 2 * modes; f++)
                CHECK_NEAR(slopes[2 * modes * (j + 1) + f], (after[f] - before[f]) / (2.0 * step),
                           1e-10);
        }
    }
    free_table(&t);
}

static sm_status call_table_check(void *t) { return sm_table_check(t); }

static void check_table_refusals(int modes) {
    table t = new_table(modes, 3, 5);
    sm_table *T = &t.table;
    CHECK_STATUS(sm_table_check(NULL), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, T->node_a, NULL, sm_table_check(T), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, T->values, NULL, sm_table_check(T), SM_BAD_ARGUMENT);
    const int32_t wrong[] = {0, -1, 100001, INT32_MIN, INT32_MAX};
    for (int k = 0; k < 5; k++) {
        CHECK_REFUSES(int32_t, T->modes, wrong[k], sm_table_check(T), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, T->count_a, wrong[k], sm_table_check(T), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, T->count_b, wrong[k], sm_table_check(T), SM_BAD_ARGUMENT);
    }
    CHECK_REFUSES(int32_t, T->count_a, 1, sm_table_check(T), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, t.node_a[0], 0.1, sm_table_check(T), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, t.node_a[1], 0.0, sm_table_check(T), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, t.node_a[1], 4.0, sm_table_check(T), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, t.node_a[2], -1.0, sm_table_check(T), SM_BAD_ARGUMENT);
    CHECK_REFUSES_NOT_FINITE(t.node_a, 3, call_table_check, T);
    CHECK_REFUSES_NOT_FINITE(t.values, (size_t)(modes == 2 ? 240 : 24), call_table_check, T);
    if (modes == 2) {
        CHECK_REFUSES(const double *, T->node_b, NULL, sm_table_check(T), SM_BAD_ARGUMENT);
        CHECK_REFUSES(double, t.node_b[3], t.node_b[4], sm_table_check(T), SM_BAD_ARGUMENT);
        CHECK_REFUSES_NOT_FINITE(t.node_b, 5, call_table_check, T);
    } else {
        CHECK_REFUSES(int32_t, T->count_b, 2, sm_table_check(T), SM_BAD_ARGUMENT);
    }
    free_table(&t);
}

static void check_lookup_refusals(void) {
    table t = new_table(2, 4, 4);
    sm_table *T = &t.table;
    double s[4], at[2] = {1.0, 2.0};
    CHECK_STATUS(sm_table_lookup(NULL, 1, at, s), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_table_lookup(T, 1, NULL, s), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_table_lookup(T, 1, at, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_table_lookup(T, 0, NULL, NULL), SM_OK);
    CHECK_REFUSES(int32_t, T->modes, 3, sm_table_lookup(T, 1, at, s), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, T->count_b, 0, sm_table_lookup(T, 1, at, s), SM_BAD_ARGUMENT);
    for (int j = 0; j < 2; j++) {
        CHECK_REFUSES(double, at[j], nextafter(4.0, 5.0), sm_table_lookup(T, 1, at, s),
                      SM_OUTSIDE_TABLE);
        CHECK_REFUSES(double, at[j], -1e-300, sm_table_lookup(T, 1, at, s), SM_OUTSIDE_TABLE);
        CHECK_REFUSES(double, at[j], 1e308, sm_table_lookup(T, 1, at, s), SM_OUTSIDE_TABLE);
        CHECK_REFUSES(double, at[j], NAN, sm_table_lookup(T, 1, at, s), SM_NOT_FINITE);
        CHECK_REFUSES(double, at[j], INFINITY, sm_table_lookup(T, 1, at, s), SM_NOT_FINITE);
    }
    /* an unchecked table with a NaN in it gives a status, never the NaN */
    for (int k = 0; k < 4 * 4 * 16; k++) t.values[k] = NAN;
    CHECK_STATUS(sm_table_lookup(T, 1, at, s), SM_NOT_FINITE);
    free_table(&t);
}

/* Slopes of some columns alone: what is looked up is what it is among those of all. */
static void check_some_slopes(void) {
    table t = new_rich_table(9, 5, 2);
    for (size_t sloped = 0; sloped <= 10; sloped += 2) {
        const double at[2] = {4.0 * random_number(), 4.0 * random_number()};
        double all[30], some[30] = {0.0};
        int32_t cell[2] = {0, 0};
        CHECK_STATUS(sm_table_slopes_from(&t.table, at, 10, cell, all, NULL), SM_OK);
        CHECK_STATUS(sm_table_slopes_from(&t.table, at, sloped, cell, some, NULL), SM_OK);
        CHECK(memcmp(some, all, 10 * sizeof *some) == 0);
        for (size_t part = 1; part < 3; part++)
            for (size_t f = 0; f < 10; f++)
                CHECK(some[10 * part + f] == (f < sloped ? all[10 * part + f] : 0.0));
    }
    free_table(&t);
}

/* The rate correction is a surface of its own over the same nodes. */
static void check_rate_correction(void) {
    table t = new_rich_table(4, 5, 1);
    sm_table alone = t.table;
    alone.values = t.rate_correction;
    alone.rate_correction = NULL;
    alone.combinations = 1; /* as many columns */
    for (int k = 0; k < 100; k++) {
        const double at[2] = {4.0 * random_number(), 4.0 * random_number()};
        double slopes[3 * SM_MOST_FIELDS], rate_correction[SM_RATE_CORRECTIONS],
            expected[SM_RATE_CORRECTIONS];
        int32_t cell[2] = {0, 0};
        CHECK_STATUS(sm_table_slopes_from(&t.table, at, 0, cell, slopes, rate_correction), SM_OK);
        CHECK_STATUS(sm_table_lookup(&alone, 1, at, expected), SM_OK);
        CHECK(memcmp(rate_correction, expected, sizeof rate_correction) == 0);
    }
    CHECK_REFUSES_NOT_FINITE(t.rate_correction, 4 * 5 * 4 * SM_RATE_CORRECTIONS, call_table_check,
                             &t.table);
    free_table(&t);
}

void check_table(void) {
    check_rate_correction();
    check_some_slopes();
    check_values(1, 2, 1);
    check_values(1, 17, 1);
    check_values(2, 2, 2);
    check_values(2, 9, 5);
    check_slopes(1, 9, 1);
    check_slopes(2, 9, 5);
    check_table_refusals(1);
    check_table_refusals(2);
    check_lookup_refusals();
}

/* Solution curves: of functions that are known, and of the slow flow. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "fixtures.h"

#define ROW(unknowns) (2 * ((size_t)(unknowns) + 1) + (size_t)((unknowns) * (unknowns))) /* doubles */

/* y^2 + (p - 1/2)^2 = 0.16: folds at p = 0.1 and 0.9. */
static sm_status circle(const void *of, const double *z, double *F, double *J) {
    const double y = z[0], p = z[1] - 0.5;
    (void)of;
    F[0] = y * y + p * p - 0.16;
    J[0] = 2.0 * y;
    J[1] = 2.0 * p;
    return SM_OK;
}

/* A focus at (0.2 p, 0) that loses its stability at p = 0.3, beside a node; it ends at p = 0.8. */
static sm_status focus(const void *of, const double *z, double *F, double *J) {
    const double growth = z[3] - 0.3, x = z[0] - 0.2 * z[3], y = z[1];
    const double rows[3][4] = {{growth, -2.0, 0.0, x - 0.2 * growth},
                               {2.0, growth, 0.0, y - 0.4},
                               {0.0, 0.0, -1.0, 0.0}};
    (void)of;
    if (z[3] > 0.8) return SM_OUTSIDE_TABLE;
    F[0] = growth * x - 2.0 * y;
    F[1] = 2.0 * x + growth * y;
    F[2] = -z[2];
    memcpy(J, rows, sizeof rows);
    return SM_OK;
}

/* All arguments of the entries on a curve; arrays of exactly the size that they need. */
typedef struct {
    sm_curve curve;
    double start[SM_CURVE_UNKNOWNS + 1];
    size_t most, count;
    double *points, *first;
    sm_branch branch;
} call;

static call new_call(sm_curve_rates rates, int32_t unknowns, size_t most) {
    return (call){.curve = {unknowns, 0.02, rates, NULL},
                  .most = most,
                  .points = new_doubles((2 * most - 1) * ROW(unknowns))};
}

static void free_call(call *c) {
    free(c->points);
}

static sm_status branch(void *arguments) {
    call *c = arguments;
    return sm_curve_branch(&c->curve, c->start, c->most, c->points, &c->branch);
}

/* The points of a branch that there is. */
static void find_points(call *c) {
    c->count = c->branch.before + 1 + c->branch.after;
    c->first = c->points + (c->most - 1 - c->branch.before) * ROW(c->curve.unknowns);
}

static void check_closed(void) {
    call c = new_call(circle, 1, 200);
    c.start[0] = 0.4;
    c.start[1] = 0.5;
    CHECK_STATUS(branch(&c), SM_OK);
    CHECK(c.branch.closed && c.branch.before == 0);
    find_points(&c);
    int folds = 0;
    for (size_t i = 0; i + 1 < c.count; i++) {
        const double *row = c.first + i * ROW(1), *next = row + ROW(1);
        folds += row[3] * next[3] < 0.0; /* the tangent turns back */
        CHECK_NEAR(row[4], 2.0 * row[0], 1e-6);
    }
    CHECK(folds == 2);
    const double guess[] = {0.02, 0.09}, upwards[] = {1.0, 0.0};
    double point[ROW(1)];
    CHECK_STATUS(sm_curve_point_near(&c.curve, guess, upwards, upwards, point), SM_OK);
    CHECK_NEAR(point[0], 0.02, 1e-15);
    CHECK_NEAR(point[1], 0.5 - sqrt(0.16 - 0.02 * 0.02), 1e-12);
    CHECK(point[2] > 0.0);
    free_call(&c);
}

/* With no more room than that, it stops. */
static void check_room(void) {
    for (size_t most = 1; most <= 3; most++) {
        call c = new_call(circle, 1, most);
        c.start[0] = 0.4;
        c.start[1] = 0.5;
        CHECK_STATUS(branch(&c), SM_OK);
        CHECK(!c.branch.closed && c.branch.before == most - 1 && c.branch.after == most - 1);
        free_call(&c);
    }
}

static void check_hopf(void) {
    call c = new_call(focus, 3, 200);
    CHECK_STATUS(branch(&c), SM_OK);
    CHECK(!c.branch.closed && c.branch.before == 0); /* it begins at p = 0 */
    find_points(&c);
    const double *last = c.first + (c.count - 1) * ROW(3), *jacobian = last + 8;
    CHECK_NEAR(last[3], 0.8, 1e-6);
    CHECK_NEAR(jacobian[0], last[3] - 0.3, 1e-12);
    CHECK_NEAR(jacobian[1], -2.0, 1e-12);
    CHECK_NEAR(jacobian[8], -1.0, 1e-12);
    free_call(&c);
}

typedef struct {
    table t;
    sm_slow_flow flow;
    sm_inputs inputs[2];
    sm_forced forced;
    sm_curve curve;
    double z[2 * SM_MODES + 1]; /* a steady state */
} forced_call;

/* Little friction, so that the steady states are within the table. */
static forced_call new_forced(int modes) {
    forced_call c = {.t = new_table(modes, 6, modes == 2 ? 6 : 1)};
    const int values = 6 * (modes == 2 ? 6 : 1) * 4 * 2 * modes;
    for (int i = 0; i < values; i++) c.t.values[i] *= 0.01;
    c.flow = flow_over(&c.t);
    for (int k = 0; k < 2; k++) {
        c.inputs[k] = resonant_inputs();
        c.inputs[k].frequency[0] -= 0.02 * k;
    }
    return c;
}

static sm_status search(void *arguments) {
    forced_call *c = arguments;
    c->forced = (sm_forced){&c->flow, c->inputs, {4.0, 4.0}};
    const sm_status status = sm_forced_curve(&c->forced, 0.02, &c->curve);
    if (status != SM_OK) return status;
    for (int u = 0; u <= 2 * c->flow.table.modes; u++)
        c->z[u] = u < 2 * c->flow.table.modes ? 0.01 : 0.5;
    return sm_curve_solved(&c->curve, c->z);
}

/* What is found balances, and so does the branch through it. */
static void check_forced(int modes) {
    forced_call c = new_forced(modes);
    CHECK_STATUS(search(&c), SM_OK);
    CHECK_NEAR(c.z[2 * modes], 0.5, 1e-15);
    call along = new_call(NULL, 2 * modes, 500);
    along.curve = c.curve;
    memcpy(along.start, c.z, (2 * (size_t)modes + 1) * sizeof *c.z);
    CHECK_STATUS(branch(&along), SM_OK);
    CHECK(along.branch.after > 0);
    find_points(&along);
    for (size_t i = 0; i < along.count; i++) {
        const double *z = along.first + i * ROW(2 * modes);
        double F[2 * SM_MODES], J[2 * SM_MODES * (2 * SM_MODES + 1)];
        CHECK_STATUS(along.curve.rates(along.curve.of, z, F, J), SM_OK);
        for (int u = 0; u < 2 * modes; u++) CHECK_NEAR(F[u], 0.0, 1e-9);
    }
    free_call(&along);
    free_table(&c.t);
}

static void check_refusals(void) {
    call c = new_call(circle, 1, 4);
    c.start[0] = 0.4;
    c.start[1] = 0.5;
    CHECK_STATUS(sm_curve_branch(NULL, c.start, 4, c.points, &c.branch), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_branch(&c.curve, NULL, 4, c.points, &c.branch), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_branch(&c.curve, c.start, 4, NULL, &c.branch), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_branch(&c.curve, c.start, 4, c.points, NULL), SM_BAD_ARGUMENT);
    CHECK_REFUSES(size_t, c.most, 0, branch(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c.curve.unknowns, 0, branch(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c.curve.unknowns, 5, branch(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.curve.largest_step, 0.0, branch(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.curve.largest_step, NAN, branch(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c.start[1], 0.99, branch(&c), SM_NOT_CONVERGED);
    CHECK_REFUSES(double, c.start[0], NAN, branch(&c), SM_NOT_CONVERGED);
    CHECK_REFUSES(double, c.start[1], INFINITY, branch(&c), SM_NOT_CONVERGED);
    CHECK_STATUS(branch(&c), SM_OK);
    const double guess[] = {0.4, 0.5}, normal[] = {0.0, 1.0}, far[] = {0.0, 0.99};
    double point[ROW(1)];
    CHECK_STATUS(sm_curve_point_near(NULL, guess, normal, normal, point), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_point_near(&c.curve, NULL, normal, normal, point), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_point_near(&c.curve, guess, NULL, normal, point), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_point_near(&c.curve, guess, normal, NULL, point), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_point_near(&c.curve, guess, normal, normal, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_point_near(&c.curve, far, normal, normal, point), SM_NOT_CONVERGED);
    free_call(&c);

    forced_call f = new_forced(2);
    CHECK_STATUS(search(&f), SM_OK);
    CHECK_STATUS(sm_curve_solved(NULL, f.z), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_solved(&f.curve, NULL), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, f.inputs[1].frequency[0], -3.0, search(&f), SM_NOT_CONVERGED);
    CHECK_REFUSES(int32_t, f.flow.table.modes, 3, search(&f), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, f.inputs[0].frequency[0], NAN, search(&f), SM_NOT_CONVERGED);
    CHECK_REFUSES(double, f.inputs[1].force[1], NAN, search(&f), SM_NOT_CONVERGED);
    free_table(&f.t);
}

void check_curves(void) {
    check_closed();
    check_room();
    check_hopf();
    check_forced(1);
    check_forced(2);
    check_refusals();
}

/* Solution curves: of functions that are known, and of the slow flow. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "fixtures.h"

#define ROW(unknowns) (4 * (size_t)(unknowns) + 2) /* doubles of a point */

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
    size_t most, count, found;
    double *points, *first, *z;
    uint8_t *folds;
    sm_branch branch;
} call;

static call new_call(sm_curve_rates rates, int32_t unknowns, size_t most) {
    return (call){.curve = {unknowns, 0.02, rates, NULL},
                  .most = most,
                  .points = new_doubles((2 * most - 1) * ROW(unknowns))};
}

static void free_call(call *c) {
    free(c->points);
    free(c->z);
    free(c->folds);
}

static sm_status branch(void *arguments) {
    call *c = arguments;
    return sm_curve_branch(&c->curve, c->start, c->most, c->points, &c->branch);
}

/* Where it folds, and Hopf points, of a branch that there is. */
static void find_specials(call *c) {
    const int32_t k = c->curve.unknowns;
    c->count = c->branch.before + 1 + c->branch.after;
    c->first = c->points + (c->most - 1 - c->branch.before) * ROW(k);
    c->folds = calloc(c->count - 1, 1);
    c->z = new_doubles((c->count - 1) * ((size_t)k + 1));
    CHECK(c->folds != NULL);
    CHECK_STATUS(sm_curve_specials(&c->curve, c->count, c->first, c->folds, c->z, &c->found),
                 SM_OK);
}

static void check_closed(void) {
    call c = new_call(circle, 1, 200);
    c.start[0] = 0.4;
    c.start[1] = 0.5;
    CHECK_STATUS(branch(&c), SM_OK);
    CHECK(c.branch.closed && c.branch.before == 0);
    find_specials(&c);
    CHECK(c.found == 2 && c.folds[0] && c.folds[1]);
    CHECK_NEAR(c.z[1] + c.z[3], 1.0, 1e-8);
    CHECK_NEAR(fabs(c.z[1] - c.z[3]), 0.8, 1e-8);
    const double z[] = {-0.4, 0.5, 0.3, 0.5};
    uint8_t passed[2];
    CHECK_STATUS(sm_curve_passes(1, c.count, c.first, 2, z, passed), SM_OK);
    CHECK(passed[0] && !passed[1]);
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
    find_specials(&c);
    CHECK(c.found == 1 && !c.folds[0]);
    CHECK_NEAR(c.z[0], 0.06, 1e-8);
    CHECK_NEAR(c.z[3], 0.3, 1e-8);
    const double *last = c.first + (c.count - 1) * ROW(3), *eigenvalues = last + 8;
    CHECK_NEAR(last[3], 0.8, 1e-6);
    CHECK_NEAR(eigenvalues[0], last[3] - 0.3, 1e-12);
    CHECK_NEAR(fabs(eigenvalues[1]), 2.0, 1e-12);
    CHECK_NEAR(eigenvalues[4], -1.0, 1e-12);
    free_call(&c);
}

typedef struct {
    table t;
    sm_slow_flow flow;
    sm_inputs inputs[2];
    sm_forced forced;
    double *z;
    size_t sections, found;
} forced_call;

/* Little friction, so that the steady states are within the table. */
static forced_call new_forced(int modes) {
    forced_call c = {.t = new_table(modes, 6, modes == 2 ? 6 : 1), .sections = 2};
    const int values = 6 * (modes == 2 ? 6 : 1) * 4 * 2 * modes;
    for (int i = 0; i < values; i++) c.t.values[i] *= 0.01;
    c.flow = flow_over(&c.t);
    for (int k = 0; k < 2; k++) {
        c.inputs[k] = resonant_inputs();
        c.inputs[k].frequency[0] -= 0.02 * k;
    }
    c.z = new_doubles(c.sections * SM_FORCED_CELLS * (2 * (size_t)modes + 1));
    return c;
}

static sm_status search(void *arguments) {
    forced_call *c = arguments;
    c->forced = (sm_forced){&c->flow, c->inputs, {4.0, 4.0}};
    return sm_forced_search(&c->forced, c->sections, c->z, &c->found);
}

/* What is found balances, and so does the branch through it. */
static void check_forced(int modes) {
    forced_call c = new_forced(modes);
    CHECK_STATUS(search(&c), SM_OK);
    CHECK(c.found >= c.sections);
    call along = new_call(NULL, 2 * modes, 500);
    CHECK_STATUS(sm_forced_curve(&c.forced, 0.02, &along.curve), SM_OK);
    memcpy(along.start, c.z, (2 * (size_t)modes + 1) * sizeof *c.z);
    CHECK_STATUS(branch(&along), SM_OK);
    CHECK(along.branch.after > 0);
    find_specials(&along);
    for (size_t i = 0; i < along.count; i++) {
        const double *z = along.first + i * ROW(2 * modes);
        double F[2 * SM_MODES], J[2 * SM_MODES * (2 * SM_MODES + 1)];
        CHECK_STATUS(along.curve.rates(along.curve.of, z, F, J), SM_OK);
        for (int u = 0; u < 2 * modes; u++) CHECK_NEAR(F[u], 0.0, 1e-9);
    }
    free_call(&along);
    free(c.z);
    free_table(&c.t);
}

static void check_refusals(void) {
    call c = new_call(circle, 1, 4);
    uint8_t flags[4];
    double z[8];
    size_t found;
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
    CHECK_STATUS(sm_curve_specials(&c.curve, 2, NULL, flags, z, &found), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_specials(&c.curve, 2, c.points, NULL, z, &found), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_specials(&c.curve, 2, c.points, flags, NULL, &found), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_specials(&c.curve, 2, c.points, flags, z, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_passes(5, 2, c.points, 1, z, flags), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_passes(1, 2, NULL, 1, z, flags), SM_BAD_ARGUMENT);
    free_call(&c);

    forced_call f = new_forced(2);
    CHECK_REFUSES(size_t, f.sections, 1, search(&f), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, f.inputs[1].frequency[0], -1.0, search(&f), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, f.flow.table.modes, 3, search(&f), SM_BAD_ARGUMENT);
    CHECK_REFUSES_NOT_FINITE(f.inputs[0].frequency, SM_MODES, search, &f);
    CHECK_REFUSES_NOT_FINITE(f.inputs[1].force, SM_MODES, search, &f);
    free(f.z);
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

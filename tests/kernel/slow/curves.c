/* Solution curves: of functions that are known, and of the slow flow. */
#include "fixtures.h"

void check_curves(int times);
void check_curves_refusals(void);

#define ROW(unknowns) (2 * ((size_t)(unknowns) + 1) + (size_t)((unknowns) * (unknowns))) /* doubles */

/* y^2 + (p - 1/2)^2 = 0.16: folds at p = 0.1 and 0.9. */
static sm_status circle(const void *of, const double *z, double *F, double *J) {
    (void)of;
    F[0] = z[0] * z[0] + (z[1] - 0.5) * (z[1] - 0.5) - 0.16;
    J[0] = 2.0 * z[0];
    J[1] = 2.0 * (z[1] - 0.5);
    return SM_OK;
}

/* All arguments of the entries on a curve; arrays of exactly the size that they need. */
typedef struct {
    sm_curve curve, *of;
    double start[SM_CURVE_UNKNOWNS + 1], *z, *points, *first;
    size_t most, count;
    sm_branch branch;
} call;

static void new_call(call *c, sm_curve curve, size_t most) {
    *c = (call){.curve = curve, .most = most, .start = {0.4, 0.5},
                .points = new_doubles((2 * most - 1) * ROW(curve.unknowns))};
    c->of = &c->curve;
    c->z = c->start;
}

static sm_status branch(void *arguments) {
    call *c = arguments;
    const sm_status status = sm_curve_branch(c->of, c->z, c->most, c->points, &c->branch);
    c->count = c->branch.before + 1 + c->branch.after;
    c->first = c->points + (c->most - 1 - c->branch.before) * ROW(c->curve.unknowns);
    return status;
}

static void check_circle(void) {
    call c;
    new_call(&c, (sm_curve){1, 0.02, circle, NULL}, 200);
    CHECK_STATUS(branch(&c), SM_OK);
    CHECK(c.branch.closed && c.branch.before == 0);
    int folds = 0;
    for (size_t i = 0; i < c.count; i++) {
        const double *row = c.first + i * ROW(1);
        CHECK_NEAR(hypot(row[0], row[1] - 0.5), 0.4, 1e-9);
        CHECK_NEAR(row[4], 2.0 * row[0], 1e-6);
        CHECK(sm_curve_is_stable(1, row) == (row[0] < 0.0));
        folds += i + 1 < c.count && row[3] * row[ROW(1) + 3] < 0.0; /* the tangent turns back */
    }
    CHECK(folds == 2);
    const double on[] = {0.4 * sin(1.0), 0.5 + 0.4 * cos(1.0)}, off[] = {0.3, 0.5};
    CHECK(sm_curve_passes(1, c.count, ROW(1), c.first, on));
    CHECK(!sm_curve_passes(1, c.count, ROW(1), c.first, off));
    const double guess[] = {0.02, 0.09}, upwards[] = {1.0, 0.0};
    double point[ROW(1)];
    CHECK_STATUS(sm_curve_point_near(&c.curve, guess, upwards, upwards, point), SM_OK);
    CHECK_NEAR(point[1], 0.5 - sqrt(0.16 - 0.02 * 0.02), 1e-12);
    CHECK(point[2] > 0.0);
}

/* Stable if all eigenvalues are on the left: of blocks [d -w; w d] in random coordinates. */
static void check_stability(void) {
    for (int k = 0; k < 200; k++) {
        double A[4][4] = {{0.0}}, row[ROW(4)] = {0.0}, d[2] = {random_sign(), random_sign()};
        const double w[2] = {3.0 * random_number(), random_number()};
        for (int i = 0; i < 4; i++) {
            A[i][i] = d[i / 2];
            A[i][i ^ 1] = i % 2 ? w[i / 2] : -w[i / 2];
        }
        for (int shear = 0; shear < 12; shear++) { /* (1 + s E_ij) A (1 - s E_ij) */
            const int i = shear % 4, j = (i + 1 + shear / 4) % 4;
            const double s = random_sign();
            for (int m = 0; m < 4; m++) A[i][m] += s * A[j][m];
            for (int m = 0; m < 4; m++) A[m][j] -= s * A[m][i];
        }
        memcpy(row + 10, A, sizeof A);
        CHECK(sm_curve_is_stable(4, row) == (d[0] < 0.0 && d[1] < 0.0));
    }
}

/* The steady states of the flow while the frequency of mode A falls and friction is little. */
typedef struct {
    table t;
    sm_slow_flow flow;
    sm_inputs inputs[2];
    sm_forced forced;
} forced_call;

static sm_status forced_curve(forced_call *f, int modes, double friction, call *c) {
    sm_curve curve = {.unknowns = 0};
    f->t = new_table(modes, 6, 6);
    for (int i = 0; i < 24 * (modes == 2 ? 24 : 2); i++) f->t.values[i] *= friction;
    f->flow = flow_over(&f->t);
    for (int k = 0; k < 2; k++) {
        f->inputs[k] = resonant_inputs();
        f->inputs[k].frequency[0] -= 0.02 * k;
    }
    f->forced = (sm_forced){&f->flow, f->inputs, {4.0, 4.0}};
    const sm_status status = sm_forced_curve(&f->forced, 0.02, &curve);
    if (status != SM_OK) return status;
    new_call(c, curve, 500);
    for (int u = 0; u <= 2 * modes; u++) c->start[u] = u < 2 * modes ? 0.01 : 0.5;
    return sm_curve_solved(&c->curve, c->start);
}

/* Without friction a = F / 2 / D; with it, the points of the branch balance, and are found again from
 * anywhere. */
static void check_forced(int modes, double friction) {
    forced_call f;
    call c;
    CHECK_STATUS(forced_curve(&f, modes, friction, &c), SM_OK);
    CHECK_STATUS(branch(&c), SM_OK);
    CHECK(c.branch.after > 0);
    for (size_t i = 0; i < c.count; i++) {
        const double *z = c.first + i * ROW(2 * modes);
        double parts[16], amplitude[4];
        for (int u = 0; u < 2 * modes; u++) amplitude[u] = 4.0 * z[u];
        sm_inputs at = f.inputs[0];
        at.frequency[0] -= 0.02 * z[2 * modes];
        CHECK_STATUS(sm_slow_flow_balance(&f.flow, 1, &at, amplitude, parts, NULL), SM_OK);
        for (int u = 0; u < 2 * modes; u++) CHECK_NEAR(parts[6 * modes + u], 0.0, 1e-8);
        for (int j = 0; j < modes && friction == 0.0; j++) {
            const double Omega = at.frequency[j], natural = f.flow.natural[j];
            const double complex D = natural * natural - Omega * Omega + I * f.flow.damping[j] * Omega;
            CHECK_NEAR(cabs(amplitude[2 * j] + I * amplitude[2 * j + 1] - 0.5 * at.force[j] / D),
                       0.0, 1e-7);
        }
    }
    double found[5 * 9];
    size_t count;
    CHECK_STATUS(sm_forced_solutions(&f.forced, 3, 9, found, &count), SM_OK);
    CHECK(count >= 1 && count <= 9);
    for (size_t k = 0; k < count; k++)
        CHECK(sm_curve_passes(2 * modes, c.count, ROW(2 * modes), c.first,
                              found + k * (2 * (size_t)modes + 1)));
}

void check_curves(int times) {
    (void)times;
    check_circle();
    check_stability();
    for (int modes = 1; modes <= 2; modes++) {
        check_forced(modes, 0.0);
        check_forced(modes, 0.01);
    }
}

void check_curves_refusals(void) {
    call c;
    forced_call f;
    const double normal[] = {0.0, 1.0}, far[] = {0.0, 0.99};
    double point[ROW(1)];
    new_call(&c, (sm_curve){1, 0.02, circle, NULL}, 4);
    REFUSES_NULL(&c.of, branch, &c);
    REFUSES_NULL(&c.z, branch, &c);
    REFUSES_NULL(&c.points, branch, &c);
    REFUSES_NULL(&c.most, branch, &c);
    REFUSES_INTS(&c.curve.unknowns, branch, &c, 0, -1, 5);
    REFUSES(&c.curve.largest_step, branch, &c, 0.0, NAN);
    CHECK_WITH(&c.start[1], 0.99, branch(&c), SM_NOT_CONVERGED);
    CHECK_WITH(&c.start[0], NAN, branch(&c), SM_NOT_CONVERGED);
    CHECK_STATUS(branch(&c), SM_OK); /* with no more room than that, it stops */
    CHECK(!c.branch.closed && c.branch.before == 3 && c.branch.after == 3);
    CHECK_STATUS(sm_curve_point_near(NULL, far, normal, normal, point), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_point_near(&c.curve, far, normal, normal, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_point_near(&c.curve, far, normal, normal, point), SM_NOT_CONVERGED);
    CHECK_STATUS(forced_curve(&f, 2, 0.01, &c), SM_OK);
    CHECK_STATUS(sm_curve_solved(NULL, c.start), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_solved(&c.curve, NULL), SM_BAD_ARGUMENT);
    CHECK_WITH(&f.inputs[1].frequency[0], -3.0, sm_curve_solved(&c.curve, c.start), SM_NOT_CONVERGED);
    CHECK_WITH(&f.inputs[1].force[1], NAN, sm_curve_solved(&c.curve, c.start), SM_NOT_CONVERGED);
}

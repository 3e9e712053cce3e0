/* Calls along a curve that is known. */
#include "fixtures.h"

#include <string.h>

void check_curves(int times);
void check_curves_refusals(void);

#define ROW(unknowns) (2 * ((size_t)(unknowns) + 1) + (size_t)((unknowns) * (unknowns)))

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
    double start[SM_CURVE_UNKNOWNS + 1], *z, *points;
    size_t most;
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
    return sm_curve_branch(c->of, c->z, c->most, c->points, &c->branch);
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

void check_curves(int times) {
    (void)times;
    check_stability();
}

void check_curves_refusals(void) {
    call c;
    sm_forced forced = {.flow = NULL};
    const double normal[] = {0.0, 1.0}, far[] = {0.0, 0.99};
    double point[ROW(1)];
    new_call(&c, (sm_curve){1, 0.02, circle, NULL, 0.0}, 4);
    REFUSES_NULL(branch, &c, &c.of, &c.z, &c.points, &c.most);
    REFUSES_INTS(&c.curve.unknowns, branch, &c, 0, -1, SM_CURVE_UNKNOWNS + 1);
    REFUSES(&c.curve.largest_step, branch, &c, 0.0, NAN);
    REFUSES(&c.curve.noise, branch, &c, -1.0, NAN);
    CHECK_WITH(&c.start[1], 0.99, branch(&c), SM_NOT_CONVERGED);
    CHECK_WITH(&c.start[0], NAN, branch(&c), SM_NOT_CONVERGED);
    CHECK_STATUS(branch(&c), SM_OK); /* with no more room than that, it stops */
    CHECK(!c.branch.closed && c.branch.before == 3 && c.branch.after == 3);
    CHECK_STATUS(sm_curve_point_near(NULL, far, normal, normal, point), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_point_near(&c.curve, far, normal, normal, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_point_near(&c.curve, far, normal, normal, point), SM_NOT_CONVERGED);
    CHECK_STATUS(sm_curve_solved(NULL, c.start), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_curve_solved(&c.curve, NULL), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_forced_curve(&forced, 0.02, &c.curve), SM_BAD_ARGUMENT);
}

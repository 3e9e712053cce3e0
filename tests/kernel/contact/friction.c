/* Friction laws as resolvents, and the stage equation of the implicit step. */
#include <math.h>
#include <stdlib.h>

#include "contact/friction.h"
#include "contact/stage/active_set.h"
#include "contact/stage/chebyshev.h"
#include "driver.h"
#include "fixtures.h"

#define STEPS 48

/* g(v) as the model defines it, not as the core computes it */
static double tanh_force(const sm_contact *contact, int i, double v) {
    return contact->limit[i] * tanh(v / contact->alpha);
}

/* Velocities v(y) and slopes dv/dy, lanes by lanes, each checked against the law. */
static void check_resolvent(int32_t law, double s, double limit, double alpha, const double *y,
                            int lanes) {
    const sm_resolvent f = sm_resolvent_make(law, s, limit, alpha);
    double v[SM_LANES], d[SM_LANES];
    for (int l = 0; l < SM_LANES; l += lanes) {
        if (lanes == 1)
            sm_resolve(1, &f, y + l, v + l, d + l);
        else
            sm_resolve(SM_LANES, &f, y, v, d);
    }
    for (int l = 0; l < SM_LANES; l++) {
        if (law == SM_TANH && limit > 0.0) {
            const double t = tanh(v[l] / alpha), rate = limit / alpha * (1.0 - t * t);
            CHECK_NEAR(s * v[l] + limit * t, y[l], 1e-14 * (limit + fabs(y[l])));
            CHECK_NEAR(s * v[l] + limit * t, y[l], 1e-12 * fabs(y[l]) + 1e-16 * limit);
            /* it only steers Newton; and 1 - tanh^2 is known to rounding only */
            CHECK_NEAR(d[l] * (s + rate), 1.0, 1e-3 + 1e-15 * limit / alpha / s);
        } else if (fabs(y[l]) <= limit) {
            CHECK(v[l] == 0.0 && d[l] == 0.0);
        } else {
            CHECK_NEAR(s * v[l] + copysign(limit, v[l]), y[l], 1e-14 * fabs(y[l]));
            CHECK_NEAR(d[l] * s, 1.0, 1e-14);
        }
    }
}

static void check_resolvents(void) {
    const double limits[] = {0.0, 1e-3, 2.0, 1e9}, stiff[] = {1e-6, 0.06, 3.0, 1e4};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            for (int e = 0; e <= 8; e++) {
                const double limit = limits[i], scale = limit > 0.0 ? limit : 1.0;
                double y[SM_LANES];
                for (int l = 0; l < SM_LANES; l++) /* from far inside to far beyond the limit */
                    y[l] = (l % 2 ? -1.0 : 1.0) * scale * pow(10.0, 0.4 * (l - 11.3));
                y[0] = 0.0;
                y[1] = scale;
                y[2] = -scale * (1.0 - 1e-9);
                y[3] = scale * (1.0 + 1e-9);
                const double alpha = pow(10.0, -e);
                for (int lanes = 1; lanes <= SM_LANES; lanes += SM_LANES - 1)
                    check_resolvent(e == 0 ? SM_COULOMB : SM_TANH, stiff[k], limit, alpha, y,
                                    lanes);
            }
}

/* S v + g(v) = r, or -limit <= r - S v <= limit in stick, with S and r of the driver's own. */
static void check_stage(const sm_contact *contact, double h, const double *u, const double *x,
                        const double *v) {
    const int n = contact->contacts;
    for (int i = 0; i < n; i++) {
        double r = u[i], scale = contact->limit[i] + fabs(u[i]), rest;
        for (int j = 0; j < n; j++) {
            const double k = contact->stiffness[i * n + j];
            const double viscous = (contact->damping[i * n + j] + SM_GAMMA * h * k) * v[j];
            r -= k * x[j] + viscous;
            scale += fabs(k * x[j]) + fabs(viscous);
        }
        if (contact->law == SM_TANH)
            rest = fabs(r - tanh_force(contact, i, v[i]));
        else
            rest = v[i] == 0.0 ? fmax(0.0, fabs(r) - contact->limit[i])
                               : fabs(r - copysign(contact->limit[i], v[i]));
        CHECK_NEAR(rest, 0.0, 2.0 * SM_STAGE_TOLERANCE * scale);
    }
}

/* Contacts in one lane, and the memory that they are in. */
typedef struct {
    sm_stepper stepper;
    sm_lanes lane;
    sm_warm warm;
    double *memory, *pull;
} one_lane;

/* At rest, to be released by free(memory). Stages are solved to rounding. */
static one_lane new_lane(const sm_contact *contact, double h) {
    const int n = contact->contacts;
    one_lane m = {.memory = NULL};
    sm_block block = {NULL, 0};
    for (int counts = 1; counts >= 0; counts--) {
        if (!counts) CHECK(sm_allocate(&block));
        m.memory = block.memory;
        m.pull = sm_take(&block, (size_t)n);
        sm_stepper_place(&m.stepper, n, &block);
        sm_lanes_place(&m.lane, n, 1, &block);
        sm_warm_place(&m.warm, n, &block);
    }
    CHECK_STATUS(sm_stepper_set(&m.stepper, contact, h), SM_OK);
    sm_warm_start(&m.stepper, &m.warm, m.lane.v, m.lane.x); /* both are 0 */
    m.warm.tolerance = 1e-13;
    return m;
}

static sm_status stage_of(one_lane *m, int stage) {
    return sm_stage_one(&m->stepper, &m->warm, &m->lane, m->pull, stage);
}

/* A period under forces that make contacts slip and stick; `spread` tells them apart. */
static void check_steps(const sm_contact *contact, double spread) {
    const int n = contact->contacts;
    const double h = TWO_PI / STEPS;
    double *u = new_doubles((size_t)n), *x = new_doubles((size_t)n);
    one_lane m = new_lane(contact, h);
    sm_lanes *lane = &m.lane;
    int slips = 0, sticks = 0;
    for (int k = 0; k < 2 * STEPS; k++) {
        const int stage = k % 2;
        for (int i = 0; i < n; i++)
            lane->u[i] = u[i] = 3.0 * (1.0 + spread * i)
                               * sin(h * (k / 2 + (stage ? 1.0 : SM_TR_END)) + spread * i);
        CHECK_STATUS(stage_of(&m, stage), SM_OK);
        memcpy(x, lane->base, (size_t)n * sizeof(double));
        check_stage(contact, h, u, x, lane->v);
        for (int i = 0; i < n; i++) {
            const int stuck = fabs(lane->v[i]) <= 1e-4 * contact->alpha;
            slips += !stuck;
            sticks += stuck;
        }
    }
    CHECK(slips > 0);
    CHECK(contact->law == SM_TANH || sticks > 0);
    free(m.memory);
    free(u);
    free(x);
}

/* One stage from rest under forces u; its status, and its velocities if that is good. */
static sm_status solve_stage(const sm_contact *contact, double h, const double *u, double *v) {
    const size_t size = (size_t)contact->contacts * sizeof(double);
    one_lane m = new_lane(contact, h);
    memcpy(m.lane.u, u, size);
    const sm_status status = stage_of(&m, 0);
    memcpy(v, m.lane.v, size);
    free(m.memory);
    return status;
}

/* Contacts without friction, no force at two of them: the residual there is rounding alone. */
static void check_frictionless_stage(void) {
    problem p = new_problem(3, 1, SM_COULOMB);
    const double u[] = {1.0, 0.0, 0.0}, x[3] = {0.0};
    double v[3];
    for (int i = 0; i < 3; i++) p.limit[i] = 0.0;
    CHECK_STATUS(solve_stage(&p.contact, 0.1, u, v), SM_OK);
    CHECK(fabs(v[1]) > 0.1);
    check_stage(&p.contact, 0.1, u, x, v);
    free_problem(&p);
}

/* Three contacts on a part that moves in a plane: K has rank two, and Newton nothing to divide by
 * where all slide. */
static void check_rank_deficient_stage(void) {
    for (int law = SM_TANH; law <= SM_COULOMB; law++)
        for (int k = 0; k < 50; k++) {
            const double direction[3][2] = {
                {1.0, 0.0}, {0.0, 1.0}, {cos(0.1 * (k + 1)), sin(0.1 * (k + 1))}};
            problem p = new_problem(3, 1, law);
            const double f[] = {20.0 * random_number() - 10.0, 20.0 * random_number() - 10.0};
            double u[3], v[3];
            const double x[3] = {0.0};
            for (int i = 0; i < 3; i++) {
                u[i] = direction[i][0] * f[0] + direction[i][1] * f[1];
                p.limit[i] *= 0.1 * (k % 3); /* without friction, too */
                for (int j = 0; j < 3; j++) {
                    p.damping[3 * i + j] = 0.0;
                    p.stiffness[3 * i + j] = 20.0 * (direction[i][0] * direction[j][0]
                                                     + direction[i][1] * direction[j][1]);
                }
            }
            CHECK_STATUS(solve_stage(&p.contact, 0.1, u, v), SM_OK);
            check_stage(&p.contact, 0.1, u, x, v);
            free_problem(&p);
        }
}

/* Forces whose velocities overflow: a status, not a NaN that counts as solved. */
static void check_overflowing_stage(void) {
    for (int n = 2; n <= 3; n++) {
        problem p = new_problem(n, 1, SM_TANH);
        const double u[] = {1e308, -1e308, 1e308};
        double v[3];
        CHECK_STATUS(solve_stage(&p.contact, 1e-3, u, v), SM_NOT_FINITE);
        free_problem(&p);
    }
}

static void check_coupled_steps(void) {
    for (int e = 1; e <= 9; e++) { /* 9: exact Coulomb */
        problem p = new_problem(7, 1, e == 9 ? SM_COULOMB : SM_TANH);
        p.contact.alpha = pow(10.0, -e);
        check_steps(&p.contact, 1.0);
        free_problem(&p);
    }
}

/* Limits that are scaled from one march to the next, in steps of one length. */
static void check_scaled_limits(void) {
    problem p = new_problem(2, 1, SM_COULOMB);
    one_lane m = new_lane(&p.contact, 0.1);
    p.limit[0] *= 0.5;
    CHECK_STATUS(sm_stepper_set(&m.stepper, &p.contact, 0.1), SM_OK);
    for (int i = 0; i < 2; i++) CHECK_NEAR(m.stepper.laws[i].limit, p.limit[i], 0.0);
    free(m.memory);
    free_problem(&p);
}

/* Contacts on a rigid part: K is singular, and without damping the stage matrix too. */
static void check_singular_stiffness(void) {
    const double alphas[] = {0.0, 0.02, 1e-6};
    for (int a = 0; a < 3; a++)
        for (int n = 2; n <= 3; n++)
            for (int equal = 0; equal <= 1; equal++) {
                problem p = new_problem(n, 1, alphas[a] > 0.0 ? SM_TANH : SM_COULOMB);
                p.contact.alpha = alphas[a];
                for (int k = 0; k < n * n; k++) {
                    p.stiffness[k] = 1.0 / (SM_GAMMA * TWO_PI / STEPS); /* S = 1 */
                    p.damping[k] = 0.0;
                }
                for (int i = 0; i < n && equal; i++) p.limit[i] = 2.0;
                check_steps(&p.contact, 0.0);
                check_steps(&p.contact, 0.3);
                free_problem(&p);
            }
}

/* A chain: each contact joined to the next by `joint` of its own stiffness. */
static void join(problem *p, double joint) {
    const int n = p->contact.contacts;
    for (int k = 0; k < n * n; k++) {
        const int i = k / n, apart = abs(i - k % n), joints = (i > 0) + (i < n - 1);
        p->stiffness[k] = apart == 0   ? 20.0 * (1.0 + joint * joints)
                          : apart == 1 ? -20.0 * joint
                                       : 0.0;
        p->damping[k] = 0.01 * p->stiffness[k];
    }
}

/* Contacts, each joined to the next by `joint` of its own stiffness, in lanes under different
 * forces; alpha 0: exact Coulomb. Whether conjugate gradients were enough. */
static int check_many_contacts(int n, double joint, double alpha) {
    problem p = new_problem(n, 1, alpha > 0.0 ? SM_TANH : SM_COULOMB);
    p.contact.alpha = alpha;
    join(&p, joint);
    const double h = TWO_PI / STEPS;
    double *u = new_doubles((size_t)n), *x = new_doubles((size_t)n), *v = new_doubles((size_t)n);
    sm_stepper stepper;
    sm_lanes lanes;
    sm_block block = {NULL, 0};
    for (int counts = 1; counts >= 0; counts--) {
        if (!counts) CHECK(sm_allocate(&block));
        sm_stepper_place(&stepper, n, &block);
        sm_lanes_place(&lanes, n, SM_LANES, &block);
    }
    CHECK_STATUS(sm_stepper_set(&stepper, &p.contact, h), SM_OK);
    double *base = new_doubles((size_t)n * SM_LANES), *forces = new_doubles((size_t)n * SM_LANES);
    int enough = 1;
    for (int k = 0; k < 2 * STEPS; k++) {
        const double t = h * (k / 2 + (k % 2 ? 1.0 : SM_GAMMA));
        for (int i = 0; i < n * SM_LANES; i++) /* from sticking to sliding */
            forces[i] = (i % SM_LANES) * sin(t + 0.02 * (i / SM_LANES));
        memcpy(lanes.u, forces, (size_t)n * SM_LANES * sizeof(double));
        memcpy(base, k % 2 ? lanes.base : lanes.x, (size_t)n * SM_LANES * sizeof(double));
        CHECK_STATUS(sm_stage_lanes(&stepper, &lanes, k % 2), SM_OK);
        enough &= lanes.factors_for == 0;
        for (int l = 0; l < SM_LANES; l++) {
            for (int i = 0; i < n; i++) {
                u[i] = forces[i * SM_LANES + l];
                x[i] = base[i * SM_LANES + l];
                v[i] = lanes.v[i * SM_LANES + l];
            }
            check_stage(&p.contact, h, u, x, v);
        }
    }
    free(block.memory);
    free(u);
    free(x);
    free(v);
    free(base);
    free(forces);
    free_problem(&p);
    return enough;
}

#define MANY 32 /* contacts: conjugate gradients take over from here on */

static void check_many(void) {
    for (int e = 1; e <= 5; e++) { /* smaller alpha: some stages by factors */
        const int enough = check_many_contacts(MANY, 0.25, pow(10.0, -e));
        CHECK(enough || e > 2);
    }
    CHECK(!check_many_contacts(MANY, 1e4, 1e-3)); /* stiffly joined: by factors */
    problem p = new_problem(60, 1, SM_TANH);    /* one lane */
    check_steps(&p.contact, 0.02);
    free_problem(&p);
}

/* The forces of one stage need not lie close to those of the last: here they have nothing to do
 * with each other. Every third contact is without friction. */
static void check_any_forces(int n, double joint) {
    problem p = new_problem(n, 1, SM_COULOMB);
    const double h = 1.0;
    double *u = new_doubles((size_t)n), *x = new_doubles((size_t)n);
    join(&p, joint);
    for (int i = 2; i < n; i += 3) p.limit[i] = 0.0;
    one_lane m = new_lane(&p.contact, h);
    for (int k = 0; k < 200; k++) {
        for (int i = 0; i < n; i++) m.lane.u[i] = u[i] = 20.0 * random_number() - 10.0;
        memset(m.lane.x, 0, (size_t)n * sizeof(double));
        CHECK_STATUS(stage_of(&m, 0), SM_OK);
        check_stage(&p.contact, h, u, x, m.lane.v);
    }
    free(m.memory);
    free(u);
    free(x);
    free_problem(&p);
}

/* Up to a bar that is all but rigid: neither Newton nor Gauss-Seidel sweeps solve its stages. */
static void check_joined_coulomb_contacts(void) {
    const double joints[] = {1.0, 10.0, 25.0, 100.0, 1e3, 1e4, 1e5, 1e7};
    for (int k = 0; k < 8; k++) {
        for (int n = 2; n <= 30; n += n < 10 ? 4 : 20) {
            check_many_contacts(n, joints[k], 0.0);
            check_any_forces(n, joints[k]);
        }
    }
    check_many_contacts(100, 1e4, 0.0);
    check_any_forces(100, 1e4);
}

static sm_status call_contact_check(void *p) { return sm_contact_check(p); }

static void check_contact_refusals(void) {
    problem p = new_problem(3, 2, SM_TANH);
    sm_contact *c = &p.contact;
    CHECK_STATUS(sm_contact_check(c), SM_OK);
    CHECK_STATUS(sm_contact_check(NULL), SM_BAD_ARGUMENT);
    const int32_t counts[] = {0, -1, INT32_MIN, INT32_MAX, 32769};
    for (int k = 0; k < 5; k++) {
        CHECK_REFUSES(int32_t, c->contacts, counts[k], sm_contact_check(c), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, c->modes, counts[k], sm_contact_check(c), SM_BAD_ARGUMENT);
        if (counts[k] != SM_TANH)
            CHECK_REFUSES(int32_t, c->law, counts[k], sm_contact_check(c), SM_BAD_ARGUMENT);
    }
    CHECK_REFUSES(const double *, p.contact.limit, NULL, sm_contact_check(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, p.contact.stiffness, NULL, sm_contact_check(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, p.contact.damping, NULL, sm_contact_check(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, p.contact.coupling, NULL, sm_contact_check(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES_NOT_FINITE(p.limit, 3, call_contact_check, c);
    CHECK_REFUSES_NOT_FINITE(p.stiffness, 9, call_contact_check, c);
    CHECK_REFUSES_NOT_FINITE(p.damping, 9, call_contact_check, c);
    CHECK_REFUSES_NOT_FINITE(p.coupling, 12, call_contact_check, c);
    CHECK_REFUSES_NOT_FINITE(&c->alpha, 1, call_contact_check, c);
    CHECK_REFUSES(double, c->alpha, 0.0, sm_contact_check(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->alpha, -0.02, sm_contact_check(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.limit[2], -1e-9, sm_contact_check(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.stiffness[4], 0.0, sm_contact_check(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.stiffness[1], 18.1, sm_contact_check(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.damping[1], 0.17, sm_contact_check(c), SM_BAD_ARGUMENT);
    double mass[] = {1.0, 0.1, 0.0, 0.1, 1.0, 0.1, 0.0, 0.1, 1.0};
    c->mass = mass;
    CHECK_REFUSES_NOT_FINITE(mass, 9, call_contact_check, c);
    CHECK_REFUSES(double, mass[1], 0.2, sm_contact_check(c), SM_BAD_ARGUMENT);
    c->law = SM_COULOMB; /* has no use for alpha */
    CHECK_REFUSES(double, c->alpha, NAN, sm_contact_check(c), SM_OK);
    free_problem(&p);
}

static void check_response_refusals(void) {
    problem p = new_problem(2, 2, SM_TANH);
    double dynamic_stiffness[8] = {0.1, 0.0, 0.02, 0.01, 0.02, 0.01, 0.1, 0.0};
    int32_t orders[] = {2, -1};
    sm_modal_response response = {
        .orders_count = 1, .orders = orders, .dynamic_stiffness = dynamic_stiffness};
    sm_contact *c = &p.contact;
    c->response = &response;
    CHECK_STATUS(sm_contact_check(c), SM_OK);
    CHECK_REFUSES(const double *, response.dynamic_stiffness, NULL, sm_contact_check(c), SM_OK);
    CHECK_REFUSES(const int32_t *, response.orders, NULL, sm_contact_check(c), SM_BAD_ARGUMENT);
    const int32_t wrong[] = {-100000, INT32_MIN, INT32_MAX};
    for (int k = 0; k < 3; k++) {
        CHECK_REFUSES(int32_t, response.orders_count, wrong[k], sm_contact_check(c),
                      SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, orders[1], wrong[k], sm_contact_check(c), SM_BAD_ARGUMENT);
    }
    CHECK_REFUSES_NOT_FINITE(dynamic_stiffness, 8, call_contact_check, c);
    free_problem(&p);
}

/* Contacts begin and cease to slip in any order: the factor stays that of S over those that do. */
static void check_slipping(void) {
    enum { N = 12 };
    double matrix[N * N], counts[N + 1] = {0.0}, factor[N * N] = {0.0};
    for (int i = 0; i < N; i++)
        for (int j = 0; j <= i; j++)
            matrix[i * N + j] = matrix[j * N + i] = i == j ? N : random_number();
    const sm_slipping a = sm_slipping_of(N, 0, counts, factor);
    int most = 0;
    for (int k = 0; k < 2000; k++) {
        const int i = (int)(N * random_number()) % N;
        if (a.place[i])
            sm_slipping_remove(&a, N, i);
        else
            sm_slipping_add(&a, N, matrix, i);
        double z[N], b[N];
        for (int row = 0; row < *a.count; row++) z[row] = b[row] = random_number() - 0.5;
        sm_slipping_divide(&a, N, z);
        for (int row = 0; row < *a.count; row++) {
            CHECK(a.place[a.order[row]] == row + 1);
            double rest = b[row];
            for (int j = 0; j < *a.count; j++)
                rest -= matrix[a.order[row] * N + a.order[j]] * z[j];
            CHECK_NEAR(rest, 0.0, 1e-13);
        }
        most = *a.count > most ? *a.count : most;
    }
    CHECK(most > N / 2);
    sm_slipping_forget(&a, N);
    CHECK(*a.count == 0);
    for (int i = 0; i < N; i++) CHECK(a.place[i] == 0);
}

void check_friction(void) {
    check_slipping();
    check_resolvents();
    check_coupled_steps();
    check_many();
    check_joined_coulomb_contacts();
    check_scaled_limits();
    check_singular_stiffness();
    check_frictionless_stage();
    check_rank_deficient_stage();
    check_overflowing_stage();
    check_contact_refusals();
    check_response_refusals();
}

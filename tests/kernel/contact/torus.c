/* Periodic contact motion on the torus. */
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "fixtures.h"

/* All arguments of sm_torus_harmonics. */
typedef struct {
    problem p;
    double rates[SM_MODES], smallest_scale[SM_MODES], tolerance;
    int32_t steps, lines, max_periods, orders_count;
    size_t points;
    double *amplitudes, *harmonics, *mean_square, *residual;
    int32_t *orders, *marched;
} torus_call;

#define ORDERS 4

static torus_call new_call(int contacts, int modes, int law, int32_t lines, size_t points) {
    static const int32_t orders[ORDERS][2] = {{1, 0}, {0, 1}, {3, 0}, {-2, 1}};
    torus_call c = {.p = new_problem(contacts, modes, law),
                    .rates = {1.0, 1.7},
                    .tolerance = 1e-6,
                    .steps = 16,
                    .lines = lines,
                    .max_periods = 100,
                    .orders_count = ORDERS,
                    .points = points};
    c.amplitudes = new_doubles(points * (size_t)modes);
    c.harmonics = new_doubles(points * ORDERS * (size_t)contacts * 2);
    c.mean_square = new_doubles(points * (size_t)contacts);
    c.residual = new_doubles(points);
    c.marched = calloc(points, sizeof *c.marched);
    c.orders = malloc(sizeof orders);
    if (!c.marched || !c.orders) abort();
    memcpy(c.orders, orders, sizeof orders);
    for (size_t k = 0; k < points * (size_t)modes; k++) c.amplitudes[k] = 0.4 * (double)(k % 9);
    return c;
}

static void free_call(torus_call *c) {
    free_problem(&c->p);
    free(c->amplitudes);
    free(c->harmonics);
    free(c->mean_square);
    free(c->residual);
    free(c->marched);
    free(c->orders);
}

static sm_status solve(void *arguments) {
    torus_call *c = arguments;
    const sm_discretisation grid = {c->rates,        c->steps,  c->lines,     c->orders_count,
                                    c->orders,       c->tolerance, c->smallest_scale,
                                    c->max_periods};
    const sm_torus_points points = {.count = c->points, .amplitudes = c->amplitudes};
    const sm_torus_motion motion = {c->harmonics, c->mean_square, c->residual, c->marched};
    return sm_torus_harmonics(&c->p.contact, &grid, &points, &motion);
}

/* P_nm of contact i, the q-th order at a point. */
static double complex harmonic(const torus_call *c, size_t point, int q, int i) {
    const size_t n = (size_t)c->p.contact.contacts;
    const double *P = c->harmonics + 2 * ((point * ORDERS + (size_t)q) * n + (size_t)i);
    return P[0] + I * P[1];
}

static double complex coupling(const torus_call *c, int mode, int i) {
    const double *L = c->p.coupling + 2 * (mode * c->p.contact.contacts + i);
    return L[0] + I * L[1];
}

/* Mean power that goes into friction and contact damping, the work of the forcing on x. */
static double dissipated(const torus_call *c, size_t point) {
    const int modes = c->p.contact.modes;
    double power = 0.0;
    for (int j = 0; j < modes; j++) {
        const double a = c->amplitudes[point * (size_t)modes + (size_t)j];
        for (int i = 0; i < c->p.contact.contacts; i++)
            power += 2.0 * c->rates[j] * a
                     * cimag(conj(coupling(c, j, i)) * harmonic(c, point, j, i));
    }
    return power;
}

/* Five points do not fill a group of 16 lanes; each must come out as if it were alone, as closely
 * as either found the periodic motion. All displacements are below 1. */
static void check_points_apart(int contacts, int modes, int law, int32_t lines) {
    const size_t points = 5;
    torus_call all = new_call(contacts, modes, law, lines, points);
    torus_call one = new_call(contacts, modes, law, lines, 1);
    const size_t per_point = ORDERS * (size_t)contacts * 2;
    CHECK_STATUS(solve(&all), SM_OK);
    CHECK_FINITE(all.harmonics, points * per_point);
    for (size_t k = 0; k < points; k++) {
        CHECK(all.residual[k] >= 0.0 && all.marched[k] >= 1 && all.marched[k] <= 100 * all.steps);
        CHECK(dissipated(&all, k) >= -1e-9);
    }
    for (size_t k = 0; k < points; k += 4) {
        memcpy(one.amplitudes, all.amplitudes + k * (size_t)modes, (size_t)modes * sizeof(double));
        CHECK_STATUS(solve(&one), SM_OK);
        if (modes == 1) CHECK(one.residual[0] <= one.tolerance);
        const double apart = 1e-9 + all.residual[k] + one.residual[0];
        for (size_t q = 0; q < per_point; q++)
            CHECK_NEAR(all.harmonics[k * per_point + q], one.harmonics[q], apart);
    }
    CHECK(dissipated(&all, points - 1) > 1e-3);
    free_call(&all);
    free_call(&one);
}

static void check_shapes(void) {
    const int contacts[] = {1, 2, 3, 7}, lines[] = {1, 4, 8, 16, 32};
    for (int n = 0; n < 4; n++)
        for (int k = 0; k < 5; k++)
            for (int modes = 1; modes <= 2; modes++) {
                if (modes == 1 && lines[k] > 1) continue; /* they would all be the same */
                if (contacts[n] == 7 && lines[k] == 32) continue; /* like 3, but dear */
                check_points_apart(contacts[n], modes, SM_TANH, lines[k]);
                check_points_apart(contacts[n], modes, SM_COULOMB, lines[k]);
            }
}

/* A light mass, and modes that respond to the contacts: 0 is neither, 1 and 2 are the one or the
 * other. */
enum { MASSLESS, MASSIVE, RESPONDING, LINEAR_CASES };

static const double MASS[9] = {0.5, 0.1, 0.0, 0.1, 0.7, 0.1, 0.0, 0.1, 0.6};
static const double NATURAL[2] = {1.0, 1.7}, MODAL_DAMPING[2] = {0.01, 0.03};
static const double SPRING[6] = {-1.0, 0.5, 0.3, 0.8, -1.2, 0.4};
static const double DAMPER[6] = {0.1, 0.0, 0.05, 0.0, 0.1, -0.1};

/* Coupling of a mode to contact i at frequency nu. */
static double complex response_coupling(int mode, int i, double nu) {
    return SPRING[3 * mode + i] + I * nu * DAMPER[3 * mode + i];
}

/* H of contacts i and k at the carrier of a mode: the response of the other mode. */
static double complex dynamic_stiffness_of(double nu, int other, int i, int k) {
    const double complex dynamic =
        NATURAL[other] * NATURAL[other] - nu * nu + I * MODAL_DAMPING[other] * nu;
    return response_coupling(other, i, nu) * response_coupling(other, k, nu) / dynamic;
}

static void fill_dynamic_stiffness(const torus_call *c, double *dynamic_stiffness) {
    for (int mode = 0; mode < 2; mode++)
        for (int k = 0; k < 9; k++) {
            const double complex H = dynamic_stiffness_of(c->rates[mode], 1 - mode, k / 3, k % 3);
            dynamic_stiffness[2 * (9 * mode + k)] = creal(H);
            dynamic_stiffness[2 * (9 * mode + k) + 1] = cimag(H);
        }
}

/* (K + i nu D [- nu^2 M] [- H(nu)]) P + L a of contact i at the carrier of a mode, which is 0. */
static double complex linear_rest(const torus_call *c, int mode, int i, int what) {
    const double nu = c->rates[mode];
    double complex rest = coupling(c, mode, i) * c->amplitudes[mode];
    for (int k = 0; k < 3; k++) {
        const int at = 3 * i + k;
        double complex stiffness = c->p.stiffness[at] + I * nu * c->p.damping[at];
        if (what == MASSIVE) stiffness -= nu * nu * MASS[at];
        if (what == RESPONDING) stiffness -= dynamic_stiffness_of(nu, 1 - mode, i, k);
        rest += stiffness * harmonic(c, 0, mode, k);
    }
    return rest;
}

/* The error that the second-order rule leaves without friction. */
static double linear_error(int32_t steps, int what) {
    double dynamic_stiffness[ORDERS * 9 * 2] = {0.0};
    torus_call c = new_call(3, 2, SM_TANH, 4, 1);
    double worst = 0.0;
    c.steps = steps;
    c.tolerance = 1e-12;
    c.amplitudes[0] = 1.3;
    c.amplitudes[1] = 0.7;
    if (what == MASSIVE) c.p.contact.mass = MASS;
    fill_dynamic_stiffness(&c, dynamic_stiffness);
    const sm_modal_response response = {
        .orders_count = c.orders_count, .orders = c.orders, .dynamic_stiffness = dynamic_stiffness};
    if (what == RESPONDING) c.p.contact.response = &response;
    for (int i = 0; i < 3; i++) c.p.limit[i] = 0.0;
    for (int k = 0; k < 9; k++) c.p.damping[k] = c.p.stiffness[k]; /* time constant 1 s */
    CHECK_STATUS(solve(&c), SM_OK);
    for (int mode = 0; mode < 2; mode++)
        for (int i = 0; i < 3; i++) worst = fmax(worst, cabs(linear_rest(&c, mode, i, what)));
    free_call(&c);
    return worst;
}

static void check_linear_contacts(void) {
    for (int what = 0; what < LINEAR_CASES; what++) {
        const double coarse = linear_error(64, what), fine = linear_error(128, what);
        CHECK_NEAR(log2(coarse / fine), 2.0, 0.1);
        CHECK_NEAR(linear_error(512, what), 0.0, 2e-4);
    }
}

/* One mode, one undamped Coulomb contact: sliding by the play operator, in closed form. */
static double complex exact_friction_function(double k, double K, double limit, double a) {
    const double r = limit / (2.0 * k * a), pi = 0.5 * TWO_PI;
    if (r >= 1.0) return 0.0;
    const double re = 0.5 * pi + asin(1.0 - 2.0 * r) + 2.0 * (1.0 - 2.0 * r) * sqrt(r * (1.0 - r));
    return k * k / K * (re - I * 4.0 * r * (1.0 - r)) / pi;
}

static void check_play_operator(void) {
    const double amplitudes[] = {0.5, 0.99, 1.05, 1.3, 2.0, 4.0, 50.0};
    torus_call c = new_call(1, 1, SM_COULOMB, 1, 7);
    c.steps = 8192;
    c.p.stiffness[0] = 20.0;
    c.p.damping[0] = 0.0;
    c.p.coupling[0] = -1.0;
    c.p.coupling[1] = 0.0;
    memcpy(c.amplitudes, amplitudes, sizeof amplitudes);
    CHECK_STATUS(solve(&c), SM_OK);
    for (size_t p = 0; p < 7; p++) {
        const double a = amplitudes[p];
        const double complex Q = harmonic(&c, p, 0, 0) / a;
        const double complex exact = exact_friction_function(1.0, 20.0, 2.0, a);
        CHECK_NEAR(cabs(Q - exact), 0.0, a < 1.0 ? 0.0 : 2e-8);
    }
    free_call(&c);
}

/* The modes must respond to the harmonics that are computed, and to no others. */
static void check_response_refusals(void) {
    torus_call c = new_call(3, 2, SM_TANH, 4, 1);
    double dynamic_stiffness[ORDERS * 9 * 2] = {0.0};
    int32_t orders[2 * ORDERS];
    sm_modal_response response = {
        .orders_count = ORDERS, .orders = orders, .dynamic_stiffness = dynamic_stiffness};
    memcpy(orders, c.orders, sizeof orders);
    c.p.contact.response = &response;
    CHECK_STATUS(solve(&c), SM_OK);
    CHECK_REFUSES(const double *, response.dynamic_stiffness, NULL, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, response.orders_count, ORDERS - 1, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, response.asked, -1, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, response.asked, ORDERS + 1, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, orders[3], 2, solve(&c), SM_BAD_ARGUMENT);
    free_call(&c);
}

static void check_limits(void) {
    torus_call c = new_call(2, 2, SM_COULOMB, 8, 3);
    c.p.limit[0] = c.p.limit[1] = 1e12; /* never slips */
    CHECK_STATUS(solve(&c), SM_OK);
    for (size_t k = 0; k < 3 * ORDERS * 4; k++) CHECK(c.harmonics[k] == 0.0);
    c.points = 0; /* nothing to do is no error */
    CHECK_STATUS(solve(&c), SM_OK);
    free_call(&c);
    c = new_call(2, 2, SM_TANH, 8, 3);
    c.max_periods = 1; /* nothing to compare with yet; the third point moves */
    CHECK_STATUS(solve(&c), SM_OK);
    CHECK(isinf(c.residual[2]));
    free_call(&c);
}

static void check_not_finite_arguments(torus_call *c) {
    CHECK_REFUSES_NOT_FINITE(c->rates, 2, solve, c);
    CHECK_REFUSES_NOT_FINITE(c->smallest_scale, 2, solve, c);
    CHECK_REFUSES_NOT_FINITE(&c->tolerance, 1, solve, c);
    CHECK_REFUSES_NOT_FINITE(c->amplitudes, 6, solve, c);
    CHECK_REFUSES_NOT_FINITE(c->p.limit, 2, solve, c);
    CHECK_REFUSES_NOT_FINITE(c->p.stiffness, 4, solve, c);
    CHECK_REFUSES_NOT_FINITE(c->p.damping, 4, solve, c);
    CHECK_REFUSES_NOT_FINITE(c->p.coupling, 8, solve, c);
    /* finite, but what follows from them is not */
    CHECK_REFUSES(double, c->amplitudes[0], 1e308, solve(c), SM_NOT_FINITE);
    CHECK_REFUSES(double, c->rates[0], 1e-308, solve(c), SM_NOT_FINITE);
}

static void check_bad_pointers(torus_call *c) {
    CHECK_REFUSES(double *, c->amplitudes, NULL, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, c->harmonics, NULL, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, c->mean_square, NULL, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, c->residual, NULL, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t *, c->marched, NULL, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t *, c->orders, NULL, solve(c), SM_BAD_ARGUMENT);
    const double *smallest = c->smallest_scale;
    const sm_discretisation good = {c->rates, 16, 8, 1, c->orders, 1e-6, smallest, 9};
    const sm_discretisation no_rates = {NULL, 16, 8, 1, c->orders, 1e-6, smallest, 9};
    const sm_discretisation no_scale = {c->rates, 16, 8, 1, c->orders, 1e-6, NULL, 9};
    const sm_torus_points none = {.count = 0};
    const sm_torus_motion nowhere = {.harmonics = NULL};
    const sm_contact *contact = &c->p.contact;
    CHECK_STATUS(sm_torus_harmonics(contact, &good, &none, &nowhere), SM_OK);
    CHECK_STATUS(sm_torus_harmonics(NULL, &good, &none, &nowhere), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_torus_harmonics(contact, NULL, &none, &nowhere), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_torus_harmonics(contact, &no_rates, &none, &nowhere), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_torus_harmonics(contact, &no_scale, &none, &nowhere), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_torus_harmonics(contact, &good, NULL, &nowhere), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_torus_harmonics(contact, &good, &none, NULL), SM_BAD_ARGUMENT);
}

static void check_bad_numbers(torus_call *c) {
    const int32_t wrong[] = {0, -1, -16, 3, INT32_MIN, INT32_MAX};
    for (int k = 0; k < 6; k++) {
        CHECK_REFUSES(int32_t, c->steps, wrong[k], solve(c), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, c->lines, wrong[k], solve(c), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, c->p.contact.contacts, k == 3 ? 32769 : wrong[k], solve(c),
                      SM_BAD_ARGUMENT);
        if (wrong[k] == 3) continue;
        CHECK_REFUSES(int32_t, c->orders_count, wrong[k], solve(c), SM_BAD_ARGUMENT);
        CHECK_REFUSES(int32_t, c->max_periods, wrong[k], solve(c), SM_BAD_ARGUMENT);
    }
    CHECK_REFUSES(int32_t, c->max_periods, 2001, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c->lines, 24, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c->lines, 8192, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c->orders[5], INT32_MIN, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c->orders[4], INT32_MAX, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(size_t, c->points, SIZE_MAX, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(size_t, c->points, SIZE_MAX / 2, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->rates[0], 0.0, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->rates[1], -1.0, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->tolerance, -1e-9, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->smallest_scale[1], -1.0, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->amplitudes[5], -1e-9, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->p.limit[1], -1.0, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->p.contact.alpha, 0.0, solve(c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, c->p.damping[0], -50.0, solve(c), SM_BAD_ARGUMENT);
}

/* K = [20 30; 30 22] has a negative eigenvalue, and nothing else holds the contacts. */
static void check_indefinite_stiffness(torus_call *c) {
    c->p.stiffness[1] = c->p.stiffness[2] = 30.0;
    for (int k = 0; k < 4; k++) c->p.damping[k] = 0.0;
    CHECK_STATUS(solve(c), SM_BAD_ARGUMENT);
}

static void check_no_memory(torus_call *c) {
    sm_status status = SM_NO_MEMORY;
    int allowed = 0;
    for (; status == SM_NO_MEMORY; allowed++) { /* whichever allocation fails, none leaks */
        allocations_left = allowed;
        status = solve(c);
    }
    allocations_left = -1;
    CHECK_STATUS(status, SM_OK);
    CHECK(allowed > 1);
}

void check_torus(void) {
    check_shapes();
    check_linear_contacts();
    check_play_operator();
    check_response_refusals();
    check_limits();
    torus_call c = new_call(2, 2, SM_TANH, 8, 3);
    check_not_finite_arguments(&c);
    check_bad_pointers(&c);
    check_bad_numbers(&c);
    check_no_memory(&c);
    check_indefinite_stiffness(&c);
    free_call(&c);
}

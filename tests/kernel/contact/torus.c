/* Periodic contact motion on the torus, in steady motion and while amplitudes grow. */
#include <pthread.h>

#include "fixtures.h"

void check_torus_refusals(void);
void check_same_bits(int times);

#define ORDERS 4

/* All arguments of sm_torus_harmonics and of sm_torus_growing. */
typedef struct {
    sm_contact *contact;
    double rates[SM_MODES], smallest[SM_MODES];
    sm_discretisation grid;
    sm_torus_points where;
    sm_torus_motion motion;
    double *amplitudes, *growth;
    int32_t orders[2 * ORDERS];
} torus_call;

static void new_call(torus_call *c, sm_contact *contact, int32_t lines, size_t points) {
    const int32_t orders[2 * ORDERS] = {1, 0, 0, 1, 3, 0, -2, 1};
    const size_t n = (size_t)contact->contacts, modes = (size_t)contact->modes;
    *c = (torus_call){.contact = contact, .rates = {1.0, 1.7},
                      .amplitudes = new_doubles(points * modes),
                      .growth = new_doubles(points * modes)};
    memcpy(c->orders, orders, sizeof orders);
    for (size_t k = 0; k < points * modes; k++) c->amplitudes[k] = 0.4 * (double)(k % 9);
    c->grid = (sm_discretisation){c->rates, 16, lines, ORDERS, c->orders, 1e-6, c->smallest, 100};
    c->where = (sm_torus_points){.count = points, .amplitudes = c->amplitudes};
    c->motion = (sm_torus_motion){new_doubles(points * ORDERS * n * 2), new_doubles(points * n),
                                  new_doubles(points), (int32_t *)(void *)new_doubles(points)};
}

static sm_status solve(void *arguments) {
    const torus_call *c = arguments;
    return sm_torus_harmonics(c->contact, &c->grid, &c->where, &c->motion);
}

static sm_status grow(void *arguments) {
    const torus_call *c = arguments;
    return sm_torus_growing(c->contact, &c->grid, c->where.count, c->where.amplitudes, c->growth,
                            c->motion.harmonics);
}

/* P_nm of contact i, the q-th order at a point; L_j. */
static double complex harmonic(const torus_call *c, size_t point, int q, int i) {
    const size_t n = (size_t)c->contact->contacts;
    const double *P = c->motion.harmonics + 2 * ((point * ORDERS + (size_t)q) * n + (size_t)i);
    return P[0] + I * P[1];
}

static double complex coupling(const torus_call *c, int mode, int i) {
    const double *L = c->contact->coupling + 2 * (mode * c->contact->contacts + i);
    return L[0] + I * L[1];
}

static void *solve_in_thread(void *call) {
    CHECK_STATUS(solve(call), SM_OK);
    return NULL;
}

/* A call gives the same bits also beside others; points that do not fill a group of lanes come out
 * as if each were alone, as closely as either found the periodic motion. Friction takes the work
 * of the forcing, L a on x. */
void check_same_bits(int times) {
    enum { THREADS = 4, POINTS = 5, VALUES = 3 * 2 * ORDERS };
    (void)times;
    for (int law = SM_TANH; law <= SM_COULOMB; law++) {
        pthread_t thread[THREADS];
        torus_call c[THREADS], one;
        problem p = new_problem(3, 2, law);
        for (int k = 0; k < THREADS; k++) {
            new_call(&c[k], &p.contact, 8, POINTS);
            CHECK(pthread_create(&thread[k], NULL, solve_in_thread, &c[k]) == 0);
        }
        for (int k = 0; k < THREADS; k++) {
            CHECK(pthread_join(thread[k], NULL) == 0);
            CHECK(memcmp(c[k].motion.harmonics, c->motion.harmonics,
                         POINTS * VALUES * sizeof(double)) == 0);
        }
        new_call(&one, &p.contact, 8, 1);
        for (size_t k = 0; k < POINTS; k++) {
            double power = 0.0;
            for (int i = 0; i < 6; i++)
                power += 2.0 * c->rates[i / 3] * c->amplitudes[2 * k + (size_t)i / 3]
                         * cimag(conj(coupling(c, i / 3, i % 3)) * harmonic(c, k, i / 3, i % 3));
            CHECK(power >= (k < POINTS - 1 ? -1e-9 : 1e-3));
            memcpy(one.amplitudes, c->amplitudes + 2 * k, 2 * sizeof(double));
            CHECK_STATUS(solve(&one), SM_OK);
            const double apart = 1e-9 + c->motion.residual[k] + one.motion.residual[0];
            for (size_t q = 0; q < VALUES; q++)
                CHECK_NEAR(c->motion.harmonics[k * VALUES + q], one.motion.harmonics[q], apart);
        }
    }
}

static void check_both(torus_call *c, entry call) {
    REFUSES_NOT_FINITE(call, c, {c->rates, 2}, {c->amplitudes, 6});
    CHECK_WITH(&c->amplitudes[0], 1e308, call(c), SM_NOT_FINITE); /* what follows is not finite */
    REFUSES_NULL(call, c, &c->contact, &c->grid.rates, &c->grid.orders, &c->where.amplitudes,
                 &c->motion.harmonics);
    REFUSES_INTS(&c->grid.steps, call, c, 0, -16, 3, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&c->grid.lines, call, c, 0, -16, 3, 24, 8192, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&c->grid.orders_count, call, c, 0, -1, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&c->orders[5], call, c, INT32_MIN, INT32_MAX);
    REFUSES_INTS(&c->contact->contacts, call, c, 0, 32769);
    REFUSES(&c->rates[1], call, c, 0.0, -1.0);
    const size_t points[] = {SIZE_MAX, SIZE_MAX / 2};
    check_refuses(&c->where.count, points, sizeof *points, 2, call, c, HERE("points"));
    check_no_memory(call, c);
    const size_t count = c->where.count;
    c->where.count = 0; /* nothing to do is no error */
    CHECK_STATUS(call(c), SM_OK);
    c->where.count = count;
}

void check_torus_refusals(void) {
    problem p = new_problem(2, 2, SM_TANH);
    torus_call c;
    double H[ORDERS * 4 * 2] = {0.0};
    int32_t orders[2 * ORDERS];
    sm_modal_response response = {
        .orders_count = ORDERS, .orders = orders, .dynamic_stiffness = H};
    new_call(&c, &p.contact, 8, 3);
    check_both(&c, solve);
    check_both(&c, grow);
    REFUSES_NOT_FINITE(grow, &c, {c.growth, 6});
    REFUSES_NOT_FINITE(solve, &c, {c.smallest, 2}, {&c.grid.tolerance, 1});
    REFUSES_NULL(solve, &c, &c.grid.smallest_scale, &c.motion.mean_square, &c.motion.residual,
                 &c.motion.marched);
    REFUSES_INTS(&c.grid.max_periods, solve, &c, 0, -1, 2001, INT32_MAX);
    REFUSES(&c.grid.tolerance, solve, &c, -1e-9);
    REFUSES(&c.smallest[1], solve, &c, -1.0);
    REFUSES(&c.amplitudes[5], solve, &c, -1e-9);
    REFUSES(&p.damping[0], solve, &c, -50.0);
    memcpy(orders, c.orders, sizeof orders);
    p.contact.response = &response; /* modes must respond to the harmonics that are computed */
    CHECK_STATUS(solve(&c), SM_OK);
    CHECK_STATUS(grow(&c), SM_BAD_ARGUMENT);
    REFUSES_NULL(solve, &c, &response.dynamic_stiffness);
    REFUSES_INTS(&response.orders_count, solve, &c, ORDERS - 1);
    REFUSES_INTS(&orders[3], solve, &c, 2);
    p.contact.response = NULL;
    /* nothing holds the contacts where K is indefinite */
    memset(p.damping, 0, 4 * sizeof(double));
    p.stiffness[1] = p.stiffness[2] = 30.0;
    CHECK_STATUS(solve(&c), SM_BAD_ARGUMENT);
}

/* Contact motion while amplitudes grow. */
#include <math.h>
#include <stdlib.h>

#include "driver.h"
#include "fixtures.h"

#define POINTS 3

typedef struct {
    problem p;
    double rates[SM_MODES], *amplitudes, *growth, *harmonics;
    int32_t steps, lines, orders_count, orders[2 * SM_MODES];
    size_t points;
} growing_call;

static growing_call new_call(int contacts, int modes, int law) {
    const size_t values = POINTS * (size_t)modes;
    growing_call c = {.p = new_problem(contacts, modes, law),
                      .rates = {1.0, 1.7},
                      .steps = 64,
                      .lines = modes == 2 ? 8 : 1,
                      .orders_count = modes,
                      .orders = {1, 0, 0, 1},
                      .points = POINTS};
    c.amplitudes = new_doubles(values);
    c.growth = new_doubles(values);
    c.harmonics = new_doubles(values * (size_t)contacts * 2);
    for (size_t k = 0; k < values; k++) c.amplitudes[k] = 0.4 * (double)(k + 1);
    return c;
}

static void free_call(growing_call *c) {
    free_problem(&c->p);
    free(c->amplitudes);
    free(c->growth);
    free(c->harmonics);
}

static sm_status solve(void *arguments) {
    growing_call *c = arguments;
    const sm_discretisation grid = {.rates = c->rates,
                                    .steps = c->steps,
                                    .lines = c->lines,
                                    .orders_count = c->orders_count,
                                    .orders = c->orders};
    return sm_torus_growing(&c->p.contact, &grid, c->points, c->amplitudes, c->growth,
                            c->harmonics);
}

/* Contacts that hardly resist follow at once: the hat sees the amplitude in its middle. */
static void check_that_linear_contacts_need_no_rate_correction(void) {
    growing_call c = new_call(1, 1, SM_COULOMB);
    double still[2 * POINTS];
    c.p.limit[0] = 0.0;
    c.p.damping[0] = 0.0;
    c.steps = 4096;
    CHECK_STATUS(solve(&c), SM_OK);
    for (int k = 0; k < 2 * POINTS; k++) still[k] = c.harmonics[k];
    for (int k = 0; k < POINTS; k++) c.growth[k] = 0.1;
    CHECK_STATUS(solve(&c), SM_OK);
    for (int k = 0; k < 2 * POINTS; k++) CHECK_NEAR(c.harmonics[k], still[k], 1e-6);
    CHECK(hypot(still[0], still[1]) > 1e-3);
    free_call(&c);
}

static void check_refusals(void) {
    growing_call c = new_call(2, 2, SM_TANH);
    double dynamic_stiffness[2 * 4 * 2] = {0.0};
    const sm_modal_response response = {
        .orders_count = 2, .orders = c.orders, .dynamic_stiffness = dynamic_stiffness};
    CHECK_REFUSES_NOT_FINITE(c.rates, 2, solve, &c);
    CHECK_REFUSES_NOT_FINITE(c.amplitudes, 2 * POINTS, solve, &c);
    CHECK_REFUSES_NOT_FINITE(c.growth, 2 * POINTS, solve, &c);
    CHECK_REFUSES_NOT_FINITE(c.p.stiffness, 4, solve, &c);
    CHECK_REFUSES(double, c.growth[3], 1e308, solve(&c), SM_NOT_FINITE);
    CHECK_REFUSES(double *, c.amplitudes, NULL, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, c.growth, NULL, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, c.harmonics, NULL, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c.steps, 3, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c.lines, 3, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, c.orders_count, 0, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(size_t, c.points, SIZE_MAX, solve(&c), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const sm_modal_response *, c.p.contact.response, &response, solve(&c),
                  SM_BAD_ARGUMENT);
    CHECK_REFUSES(size_t, c.points, 0, solve(&c), SM_OK);
    sm_status status = SM_NO_MEMORY;
    for (int allowed = 0; status == SM_NO_MEMORY; allowed++) { /* whichever fails, none leaks */
        allocations_left = allowed;
        status = solve(&c);
    }
    allocations_left = -1;
    CHECK_STATUS(status, SM_OK);
    CHECK_FINITE(c.harmonics, 2 * POINTS * 2 * 2);
    free_call(&c);
}

void check_torus_growth(void) {
    check_that_linear_contacts_need_no_rate_correction();
    check_refusals();
}

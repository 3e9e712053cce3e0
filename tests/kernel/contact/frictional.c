/* Friction under a varying normal force, as a return map: paths in closed form. */
#include "fixtures.h"

void check_frictional(int times);

#define MOST 5 /* doubles that a contact remembers */
#define MU 0.5
#define K_T 3.0
#define K_N 2.0

static void move(int tangents, double preload, const double *x, double *memory, double *force) {
    const double reference[] = {K_T, K_T, K_N};
    const sm_element element = {.law = SM_FRICTIONAL, .column = {0, 1, 2}, .tangents = tangents,
                                .friction = MU, .preload = preload,
                                .tangential_stiffness = K_T, .normal_stiffness = K_N};
    const sm_elastic elastic = {.elements = 1, .element = &element, .reference = reference};
    CHECK(sm_elastic_memory(&elastic) == (size_t)(2 * tangents + 1));
    CHECK_STATUS(sm_elastic_force(&elastic, tangents + 1, x, memory, force), SM_OK);
}

/* Dragged along a straight line the spring turns as the string of a tractrix. After a way s its
 * angle to the line is 2 atan(tan(theta / 2) exp(-s / rho)), rho = mu N / k_t. */
static void check_tractrix(int steps) {
    const double N = 1.2, rho = MU * N / K_T, along = 0.7, angle = 1.2;
    double memory[MOST] = {0.0}, x[3] = {0.0}, force[3];
    x[0] = 4.0 * cos(angle + along); /* slides far in this direction */
    x[1] = 4.0 * sin(angle + along);
    move(2, N, x, memory, force);
    CHECK_NEAR(force[0], MU * N * cos(angle + along), 1e-12);
    for (int k = 0; k < steps; k++) {
        x[0] += 0.5 / steps * cos(along);
        x[1] += 0.5 / steps * sin(along);
        move(2, N, x, memory, force);
    }
    const double after = along + 2.0 * atan(tan(0.5 * angle) * exp(-0.5 / rho));
    CHECK_NEAR(force[0], MU * N * cos(after), 1e-11);
    CHECK_NEAR(force[1], MU * N * sin(after), 1e-11);
}

/* A path that touches down on the way: sliders stop there. */
static void check_touch_down(int tangents) {
    double memory[MOST] = {0.0}, force[3], open[3] = {1.0}, closed[3] = {1.04};
    open[tangents] = -0.3;
    closed[tangents] = 0.1;
    move(tangents, 0.0, open, memory, force);
    CHECK(force[0] == 0.0 && force[tangents] == 0.0);
    move(tangents, 0.0, closed, memory, force);
    CHECK_NEAR(force[0], K_T * 0.01, 1e-14); /* of 0.04, a quarter after touch-down */
    CHECK_NEAR(force[tangents], K_N * 0.1, 1e-15);
}

void check_frictional(int times) {
    (void)times;
    check_tractrix(1);
    check_tractrix(64);
    check_touch_down(1);
    check_touch_down(2);
}

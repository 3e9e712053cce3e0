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

/* Dragged along a straight line the spring turns as the string of a tractrix: after a way s its angle
 * to the line has tan(theta / 2) exp(-s / rho), rho = mu N / k_t. In one step, or in many. */
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

/* Wherever it goes: no tension, friction within its cone, and on it only if it has slid. A force that
 * is continuous along any path, so that a tenth of a path changes it by little; on a closed loop the
 * work on the contact is lost, not gained. */
static void check_any_path(int tangents, double preload) {
    double memory[MOST] = {0.0}, x[3] = {0.0}, to[3], last[3] = {0.0}, force[3], work = 0.0;
    int open = 0, slips = 0;
    enum { TURNS = 500, PARTS = 64 };
    move(tangents, preload, x, memory, last);
    for (int k = 0; k < TURNS; k++) {
        for (int i = 0; i <= tangents; i++) to[i] = k < TURNS - 1 ? 0.5 * random_sign() : 0.0;
        double from[3] = {x[0], x[1], x[2]};
        for (int part = 1; part <= PARTS; part++) {
            double size = 0.0, moved = 0.0, changed = 0.0;
            for (int i = 0; i <= tangents; i++) {
                const double at = from[i] + (to[i] - from[i]) * part / PARTS;
                moved = fmax(moved, fabs(at - x[i]));
                x[i] = at;
            }
            move(tangents, preload, x, memory, force);
            for (int i = 0; i <= tangents; i++) {
                work += 0.5 * (force[i] + last[i]) * (to[i] - from[i]) / PARTS;
                changed = fmax(changed, fabs(force[i] - last[i]));
                if (i < tangents) size = hypot(size, force[i]);
                last[i] = force[i];
            }
            const double normal = force[tangents] + preload;
            CHECK_NEAR(normal, fmax(0.0, preload + K_N * x[tangents]), 1e-14);
            CHECK(size <= MU * normal + 1e-13);
            CHECK(changed <= 2.0 * (K_T + MU * K_N) * moved);
            open += normal == 0.0;
            slips += normal > 0.0 && size > MU * normal - 1e-13;
        }
    }
    CHECK(open > 1000 && slips > 1000 && work > 1.0);
}

void check_frictional(int times) {
    (void)times;
    check_tractrix(1);
    check_tractrix(64);
    for (int tangents = 1; tangents <= 2; tangents++) {
        check_touch_down(tangents);
        check_any_path(tangents, 0.0);
        check_any_path(tangents, 0.3);
    }
}

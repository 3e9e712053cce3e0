/* The return map of a frictional contact: tangents against differences, no jumps, closed forms. */
#include <math.h>
#include <string.h>

#include "contact/elastic/law.h"
#include "driver.h"
#include "fixtures.h"

#define MOST 5 /* doubles that a contact remembers */

static const sm_elastic NOTHING = {.elements = 1};

static sm_element contact(int tangents, double preload) {
    return (sm_element){.law = SM_FRICTIONAL,
                        .column = {0, 1, 2},
                        .tangents = tangents,
                        .friction = 0.5,
                        .preload = preload,
                        .tangential_stiffness = 3.0,
                        .normal_stiffness = 2.0};
}

static sm_element_force at(const sm_element *element, const double *x, const double *memory) {
    double next[MOST];
    sm_element_force result = {.next = next};
    sm_element_evaluate(&NOTHING, element, 1.0, x, memory, &result);
    result.next = NULL;
    return result;
}

static void move(const sm_element *element, const double *x, double *memory) {
    sm_element_force result = {.next = memory};
    sm_element_evaluate(&NOTHING, element, 1.0, x, memory, &result);
}

static void random_place(double *x, const double *from, double size) {
    for (int k = 0; k < 3; k++) x[k] = (from ? from[k] : 0.0) + size * (2.0 * random_number() - 1.0);
}

/* Each tangent lies between the differences to either side: these differ at kinks. */
static int check_tangent(const sm_element *element, const double *x, const double *memory) {
    const sm_element_force here = at(element, x, memory);
    int smooth = 1;
    for (int j = 0; j <= element->tangents; j++) {
        const double d = 1e-8;
        double up[3], down[3];
        memcpy(up, x, sizeof up);
        memcpy(down, x, sizeof down);
        up[j] += d;
        down[j] -= d;
        const sm_element_force a = at(element, up, memory), b = at(element, down, memory);
        for (int i = 0; i <= element->tangents; i++) {
            const double right = (a.force[i] - here.force[i]) / d;
            const double left = (here.force[i] - b.force[i]) / d;
            const double tolerance = 2e-6 * (1.0 + fabs(left));
            CHECK(here.tangent[i][j] >= fmin(left, right) - tolerance);
            CHECK(here.tangent[i][j] <= fmax(left, right) + tolerance);
            smooth &= fabs(right - left) < 1e-2;
        }
    }
    return smooth;
}

/* Between two places the force moves by as little as they lie apart. */
static void check_no_jump(const sm_element *element, const double *from, const double *to,
                          const double *memory) {
    double low = 0.0, high = 1.0;
    sm_element_force a = at(element, from, memory), b = at(element, to, memory);
    for (int k = 0; k < 45; k++) { /* towards the half in which it moves more */
        const double middle = 0.5 * (low + high);
        double x[3], first = 0.0, second = 0.0;
        for (int i = 0; i < 3; i++) x[i] = from[i] + middle * (to[i] - from[i]);
        const sm_element_force m = at(element, x, memory);
        for (int i = 0; i <= element->tangents; i++) {
            first += fabs(m.force[i] - a.force[i]);
            second += fabs(b.force[i] - m.force[i]);
        }
        if (first > second) {
            high = middle;
            b = m;
        } else {
            low = middle;
            a = m;
        }
    }
    for (int i = 0; i <= element->tangents; i++) CHECK_NEAR(a.force[i], b.force[i], 1e-10);
}

/* Also if sliders were moved, by so much: beyond where friction holds them. */
static void check_maps(int tangents, double preload, double moved) {
    const sm_element element = contact(tangents, preload);
    int seen[3] = {0}, smooth = 0;
    for (int k = 0; k < 20000; k++) {
        double memory[MOST] = {0.0}, last[3], x[3], other[3];
        for (int s = 0; s < 3; s++) {
            random_place(last, NULL, 0.3);
            move(&element, last, memory);
        }
        for (int s = 0; s < tangents; s++) memory[s] += moved * (2.0 * random_number() - 1.0);
        random_place(x, last, pow(10.0, -3.0 * random_number()));
        smooth += check_tangent(&element, x, memory);
        random_place(other, x, 0.5);
        check_no_jump(&element, x, other, memory);
        seen[at(&element, x, memory).state]++;
    }
    CHECK(smooth > 15000);
    for (int state = 0; state < 3; state++) CHECK(seen[state] > 1000);
}

/* A straight path in one step is what it is in many: the tractrix is exact. */
static void check_straight_path(void) {
    const sm_element element = contact(2, 1.0);
    const double from[3] = {0.3, -0.2, 0.0}, to[3] = {0.1, 0.5, 0.0};
    double once[MOST] = {0.0}, often[MOST] = {0.0};
    move(&element, from, once);
    move(&element, from, often);
    for (int k = 1; k <= 64; k++) {
        double x[3] = {0.0};
        for (int i = 0; i < 2; i++) x[i] = from[i] + k / 64.0 * (to[i] - from[i]);
        move(&element, x, often);
    }
    move(&element, to, once);
    for (int k = 0; k < MOST; k++) CHECK_NEAR(once[k], often[k], 1e-14);
}

/* And so is one that touches down on the way: the sliders stop there. */
static void check_touch_down(void) {
    for (int tangents = 1; tangents <= 2; tangents++) {
        const sm_element element = contact(tangents, 0.0);
        double memory[MOST] = {0.0}, open[3] = {0.0}, closed[3] = {0.0};
        open[0] = 1.0;
        closed[0] = 1.04;
        open[tangents] = -0.3;
        closed[tangents] = 0.1;
        move(&element, open, memory);
        const sm_element_force f = at(&element, closed, memory);
        CHECK(f.state == SM_STICK);
        CHECK_NEAR(f.force[0], 3.0 * 0.01, 1e-14); /* of 0.04, a quarter after touch-down */
        CHECK_NEAR(f.force[tangents], 0.2, 1e-15);
    }
}

void check_frictional_contact(void) {
    for (int tangents = 1; tangents <= 2; tangents++) {
        check_maps(tangents, 0.0, 0.0);
        check_maps(tangents, 0.3, 0.0);
        check_maps(tangents, 0.3, 0.1);
    }
    check_straight_path();
    check_touch_down();
}

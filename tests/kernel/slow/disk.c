/* Amplitudes of disks: linear motion against its exact solution, refusals. */
#include <math.h>
#include <stdlib.h>

#include "base/cnumber.h"
#include "driver.h"
#include "fixtures.h"

#define MODES 3
#define CONTACTS 10 /* more than a block of rows, and not a multiple */
#define KINDS 2
#define NODES 4

typedef struct {
    sm_disk disk;
    double *pole, *excitation, *motion, *projection, *others, *secant, *amplitude, *deficit, *step;
} problem_disk;

/* Contact j is moved by mode j % MODES alone, and acts on it; contacts do not act on each other.
 * From a small onset on its deficit is (0.3 + 0.1 i) c. */
static problem_disk new_disk(void) {
    problem_disk p = {.pole = new_doubles(2 * MODES),
                      .excitation = new_doubles(2 * MODES),
                      .motion = new_doubles(2 * MODES * CONTACTS),
                      .projection = new_doubles(2 * MODES * CONTACTS),
                      .others = new_doubles(2 * CONTACTS * (CONTACTS + 1)),
                      .secant = new_doubles(4 * NODES * KINDS),
                      .amplitude = new_doubles(2 * MODES),
                      .deficit = new_doubles(2 * CONTACTS),
                      .step = new_doubles(1)};
    for (int m = 0; m < MODES; m++) {
        p.pole[m] = -0.01 * (m + 1);
        p.pole[MODES + m] = 1.0 + 0.1 * m;
        p.excitation[m] = 0.5;
        p.excitation[MODES + m] = -0.2 * m;
    }
    for (int j = 0; j < CONTACTS; j++) {
        p.motion[2 * CONTACTS * (j % MODES) + j] = 0.1;
        p.projection[2 * MODES * j + MODES + j % MODES] = 0.2;
    }
    for (int k = 0; k < NODES * KINDS; k++) {
        p.secant[4 * k] = 0.3;
        p.secant[4 * k + 1] = 0.1;
    }
    p.disk = (sm_disk){.modes = MODES, .contacts = CONTACTS, .kinds = KINDS, .nodes = NODES,
                       .pole = p.pole, .excitation = p.excitation, .motion = p.motion,
                       .projection = p.projection, .others = p.others, .onset = 1e-9,
                       .first = -10.0, .spacing = 20.0, .secant = p.secant, .tolerance = 1e-4};
    return p;
}

static void free_disk(problem_disk *p) {
    double *arrays[] = {p->pole, p->excitation, p->motion, p->projection, p->others,
                        p->secant, p->amplitude, p->deficit, p->step};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) free(arrays[i]);
}

static sm_status march(problem_disk *p, const sm_disk_inputs *inputs) {
    return sm_disk_march(&p->disk, inputs, p->amplitude, p->deficit, p->step);
}

typedef struct {
    problem_disk *problem;
    sm_disk_inputs *inputs;
} disk_call;

static sm_status march_call(void *arguments) {
    const disk_call *call = arguments;
    return march(call->problem, call->inputs);
}

/* From a, after a time: contacts change the pole, a' = lambda a + b. */
static sm_complex after(sm_complex lambda, sm_complex b, sm_complex a, double time) {
    const sm_complex steady = sm_cscale(sm_cdiv(b, lambda), -1.0);
    const sm_complex factor = sm_cscale(sm_unit(lambda.im * time), exp(lambda.re * time));
    return sm_cadd(steady, sm_cmul(factor, sm_csub(a, steady)));
}

static void check_linear(void) {
    problem_disk p = new_disk();
    const sm_disk_inputs inputs = {30.0, {1.05, 1.05}, {1.0, 1.0}};
    /* the forces deflect the contacts of the first step from rest */
    CHECK_STATUS(march(&p, &inputs), SM_OK);
    CHECK(p.step[0] > 0.0);
    for (int m = 0; m < MODES; m++) {
        const int touching = (CONTACTS - m + MODES - 1) / MODES;
        const sm_complex by_contacts =
            sm_cscale(sm_cmul(sm_cx(0.0, 0.2), sm_cx(0.3, 0.1)), 0.1 * touching);
        const sm_complex pole = sm_cx(p.pole[m], p.pole[MODES + m] - 1.05);
        const sm_complex b = sm_cx(p.excitation[m], p.excitation[MODES + m]);
        const sm_complex exact = after(sm_cadd(pole, by_contacts), b, sm_cx(0.0, 0.0), 30.0);
        const double size = sqrt(sm_cabs2(exact));
        CHECK_NEAR(p.amplitude[m], exact.re, 1e-3 * size);
        CHECK_NEAR(p.amplitude[MODES + m], exact.im, 1e-3 * size);
    }
    free_disk(&p);
}

static void check_refusals(void) {
    problem_disk p = new_disk();
    sm_disk_inputs inputs = {1.0, {1.0, 1.0}, {1.0, 1.0}};
    CHECK_REFUSES(int32_t, p.disk.modes, 0, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, p.disk.kinds, 3, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, p.disk.nodes, 1, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, p.disk.pole, NULL, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.disk.onset, 0.0, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.disk.spacing, -1.0, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.disk.contraction, -1.0, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.step[0], -1.0, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, p.disk.nodes, INT32_MAX, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, p.amplitude, NULL, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, p.deficit, NULL, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double *, p.step, NULL, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, inputs.duration, -1.0, march(&p, &inputs), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, inputs.frequency[1], 0.0, march(&p, &inputs), SM_BAD_ARGUMENT);
    disk_call call = {&p, &inputs};
    CHECK_REFUSES_NOT_FINITE(inputs.force, 2, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(inputs.frequency, 2, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(&inputs.duration, 1, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(p.pole, 2 * MODES, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(p.excitation, 2 * MODES, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(p.motion, 2 * MODES * CONTACTS, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(p.projection, 2 * MODES * CONTACTS, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(p.others, 2 * CONTACTS * (CONTACTS + 1), march_call, &call);
    CHECK_REFUSES_NOT_FINITE(p.secant, 4 * NODES * KINDS, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(p.amplitude, 2 * MODES, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(p.deficit, 2 * CONTACTS, march_call, &call);
    CHECK_REFUSES_NOT_FINITE(p.step, 1, march_call, &call);
    double *numbers[] = {&p.disk.onset, &p.disk.first, &p.disk.spacing, &p.disk.contraction,
                         &p.disk.tolerance};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        CHECK_REFUSES_NOT_FINITE(numbers[i], 1, march_call, &call);
    CHECK_STATUS(march(&p, &inputs), SM_OK);
    /* contacts that act on each other so strongly that their deficits do not converge */
    for (int m = 0; m < 2 * MODES; m++) p.amplitude[m] = 1.0;
    for (int j = 0; j + 1 < CONTACTS; j++) p.others[2 * CONTACTS * j + j + 1] = 1e3;
    p.others[2 * CONTACTS * (CONTACTS - 1)] = 1e3;
    p.disk.contraction = 400.0;
    for (int j = 0; j < 2 * CONTACTS; j++) p.deficit[j] = 0.5;
    p.step[0] = 0.25;
    for (int m = 0; m < 2 * MODES; m++) CHECK(p.amplitude[m] == 1.0);
    for (int j = 0; j < 2 * CONTACTS; j++) CHECK(p.deficit[j] == 0.5);
    CHECK(p.step[0] == 0.25);
    free_disk(&p);
}

void check_disk(void);

void check_disk(void) {
    check_linear();
    check_refusals();
}

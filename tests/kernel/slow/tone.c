/* Calls of the slow flow of one tone, under contacts of constant secants. */
#include "fixtures.h"

void check_tone_refusals(void);

#define MODES 3
#define CONTACTS 10 /* more than a block of rows, and not a multiple */
#define KINDS 2
#define NODES 4

typedef struct {
    sm_tone tone;
    sm_tone_inputs inputs;
    double pole[2 * MODES], excitation[2 * MODES], motion[2 * MODES * CONTACTS],
        projection[2 * MODES * CONTACTS], others[2 * CONTACTS * (CONTACTS + 1)],
        secant[4 * NODES * KINDS], start[2 * MODES], rest[2 * CONTACTS], first, *amplitude,
        *deficit, *step;
} tone_call;

/* Contact j is moved by mode j % MODES alone, and acts on it; contacts do not act on each other.
 * From a small onset on its deficit is (0.3 + 0.1 i) c. */
static void new_tone(tone_call *p) {
    *p = (tone_call){.inputs = {30.0, {1.05, 1.05}, {1.0, 1.0}}};
    for (int m = 0; m < MODES; m++) {
        p->pole[m] = -0.01 * (m + 1);
        p->pole[MODES + m] = 1.0 + 0.1 * m;
        p->excitation[m] = 0.5;
        p->excitation[MODES + m] = -0.2 * m;
    }
    for (int j = 0; j < CONTACTS; j++) {
        p->motion[2 * CONTACTS * (j % MODES) + j] = 0.1;
        p->projection[2 * MODES * j + MODES + j % MODES] = 0.2;
    }
    for (int k = 0; k < NODES * KINDS; k++) {
        p->secant[4 * k] = 0.3;
        p->secant[4 * k + 1] = 0.1;
    }
    p->tone = (sm_tone){.modes = MODES, .contacts = CONTACTS, .kinds = KINDS, .nodes = NODES,
                        .pole = p->pole, .excitation = p->excitation, .motion = p->motion,
                        .projection = p->projection, .others = p->others, .onset = 1e-9,
                        .first = -10.0, .spacing = 20.0, .secant = p->secant, .tolerance = 1e-6};
    p->amplitude = p->start;
    p->deficit = p->rest;
    p->step = &p->first;
}

static sm_status march(void *arguments) {
    tone_call *p = arguments;
    return sm_tone_march(&p->tone, &p->inputs, p->amplitude, p->deficit, p->step);
}

void check_tone_refusals(void) {
    tone_call p;
    new_tone(&p);
    REFUSES_INTS(&p.tone.modes, march, &p, 0, -1, INT32_MAX);
    REFUSES_INTS(&p.tone.kinds, march, &p, 0, 3);
    REFUSES_INTS(&p.tone.nodes, march, &p, 1, INT32_MAX);
    REFUSES_NULL(march, &p, &p.tone.pole, &p.amplitude, &p.deficit, &p.step);
    REFUSES(&p.inputs.frequency[1], march, &p, 0.0);
    double *const numbers[] = {&p.tone.onset, &p.tone.spacing, &p.tone.tolerance, &p.first,
                               &p.tone.contraction, &p.inputs.duration};
    for (size_t k = 0; k < COUNT(numbers); k++) {
        REFUSES(numbers[k], march, &p, -1.0);
        REFUSES_NOT_FINITE(march, &p, {numbers[k], 1});
    }
    REFUSES_NOT_FINITE(march, &p, {p.inputs.frequency, 4}, {p.pole, COUNT(p.pole)},
                       {p.motion, COUNT(p.motion)}, {p.others, COUNT(p.others)},
                       {p.secant, COUNT(p.secant)}, {p.start, COUNT(p.start)});
    /* contacts that act on each other so strongly that their deficits do not converge */
    for (int j = 0; j < CONTACTS; j++) p.others[2 * CONTACTS * j + (j + 1) % CONTACTS] = 1e3;
    for (int k = 0; k < 2 * CONTACTS; k++) p.rest[k] = 0.5;
    p.tone.contraction = 400.0;
    p.first = 0.25;
    const tone_call before = p;
    CHECK_STATUS(march(&p), SM_NOT_CONVERGED);
    CHECK(memcmp(&p, &before, sizeof p) == 0);
}

/* Calls of the slow flow of two tones, under contacts of constant secants. */
#include "fixtures.h"

void check_tone_refusals(void);

#define MODES 3
#define CONTACTS 10 /* more than a block of rows, and not a multiple */
#define KINDS 2
#define NODES 4
#define SHARES 2
#define ROWS 3

typedef struct {
    sm_tone tone;
    sm_inputs inputs;
    double pole[2 * MODES], excitation[2 * MODES], motion[2 * MODES * CONTACTS],
        projection[2 * MODES * CONTACTS], output[2 * MODES * ROWS],
        others[2 * CONTACTS * (CONTACTS + 1)], own[2 * CONTACTS], stiffness[CONTACTS], rows[2 * ROWS * (CONTACTS + 1)],
        onset[KINDS], secant[16 * NODES * SHARES * KINDS], tolerance,
        duration;
    sm_tone_flow *flow; /* NULL: made anew in each call */
} tone_call;

/* Contact j is moved by mode j % MODES alone, and acts on it; contacts do not act on each other.
 * From a small onset on its deficit is 0.3 c. The second tone has the same modes, without a force. */
static void new_tone(tone_call *p) {
    *p = (tone_call){.inputs = resonant_inputs(), .tolerance = 1e-6, .duration = 30.0};
    p->inputs.frequency[0] = 1.05;
    p->inputs.force[1] = 0.0;
    for (int m = 0; m < MODES; m++) {
        p->pole[m] = -0.01 * (m + 1);
        p->pole[MODES + m] = 1.0 + 0.1 * m;
        p->excitation[m] = 0.5;
        p->excitation[MODES + m] = -0.2 * m;
        p->output[2 * ROWS * m + m % ROWS] = 1.0;
    }
    for (int j = 0; j < CONTACTS; j++) {
        p->motion[2 * CONTACTS * (j % MODES) + j] = 0.1;
        p->projection[2 * MODES * j + MODES + j % MODES] = 0.2;
    }
    for (int k = 0; k < NODES * SHARES * KINDS; k++)
        p->secant[16 * k] = p->secant[16 * k + 8] = 0.3; /* the real parts of both tones */
    for (int k = 0; k < KINDS; k++) p->onset[k] = 1e-9;
    const sm_tone_modes modes = {MODES,     p->pole,       p->excitation, p->excitation,
                                 p->motion, p->projection, p->output};
    sm_tone_carrier carrier = {.slow = modes, .fast = modes, .amplitudes = 1, .reference = 1.0,
                               .flexibility = p->others, .own = p->own, .output = p->rows};
    carrier.fast.count = 1; /* it reads the first numbers of arrays for three modes */
    p->tone = (sm_tone){.tones = 2, .carrier = {carrier, carrier}, .contacts = CONTACTS,
                        .kinds = KINDS, .nodes = NODES, .shares = SHARES, .elastic = 1,
                        .contact_motion = 1, .stiffness = p->stiffness, .onset = p->onset,
                        .first = -10.0, .spacing = 20.0, .secant = p->secant};
    p->tone.carrier[1].reference = 2.0;
}

static sm_status create(void *arguments) {
    tone_call *p = arguments;
    sm_tone_flow *made = NULL;
    const sm_status status = sm_tone_create(&p->tone, p->tolerance, &made);
    CHECK((status == SM_OK) == (made != NULL));
    sm_tone_free(p->flow);
    p->flow = made;
    return status;
}

/* Steps a flow with outputs, from rest. */
static sm_status step(void *arguments) {
    tone_call *p = arguments;
    double outputs[10 + 3 * CONTACTS + 1]; /* of an amplitude on each tone, and one DOF */
    size_t done;
    CHECK_STATUS(create(p), SM_OK);
    CHECK(sm_tone_output_count(p->flow) == COUNT(outputs));
    return sm_tone_run(p->flow, 1, &p->duration, &p->inputs, outputs, &done);
}

void check_tone_refusals(void) {
    tone_call p;
    new_tone(&p);
    REFUSES_INTS(&p.tone.carrier[1].slow.count, create, &p, 0, -1, INT32_MAX);
    REFUSES_INTS(&p.tone.tones, create, &p, 0, 3);
    REFUSES_INTS(&p.tone.shares, create, &p, 1);
    REFUSES_INTS(&p.tone.kinds, create, &p, 0, 3);
    REFUSES_INTS(&p.tone.nodes, create, &p, 1, INT32_MAX);
    REFUSES_NULL(create, &p, &p.tone.carrier[0].slow.pole, &p.tone.carrier[1].fast.motion,
                 &p.tone.carrier[1].own);
    double *const numbers[] = {&p.onset[1], &p.tone.spacing, &p.tone.carrier[1].reference,
                               &p.tolerance, &p.tone.contraction};
    for (size_t k = 0; k < COUNT(numbers); k++) {
        REFUSES(numbers[k], create, &p, -1.0);
        REFUSES_NOT_FINITE(create, &p, {numbers[k], 1});
    }
    REFUSES_NOT_FINITE(create, &p, {p.pole, COUNT(p.pole)}, {p.motion, COUNT(p.motion)},
                       {p.others, COUNT(p.others)}, {p.secant, COUNT(p.secant)},
                       {p.output, COUNT(p.output)}, {p.rows, COUNT(p.rows)});
    REFUSES(p.inputs.frequency + 1, step, &p, 0.0, -1.0);
    REFUSES(&p.duration, step, &p, 0.0, -1.0);
    REFUSES_NOT_FINITE(step, &p, {p.inputs.force, INPUT_COUNT}, {&p.duration, 1});
    check_no_memory(create, &p);
    /* contacts that act on each other so strongly that their deficits do not converge */
    for (int j = 0; j < CONTACTS; j++) p.others[2 * CONTACTS * j + (j + 1) % CONTACTS] = 1e3;
    p.tone.contraction = 400.0;
    CHECK_STATUS(step(&p), SM_NOT_CONVERGED);
    const size_t size = sm_tone_state_count(p.flow);
    double *state = new_doubles(size), *fresh = new_doubles(size);
    CHECK_STATUS(sm_tone_get_state(p.flow, state), SM_OK);
    CHECK_STATUS(create(&p), SM_OK);
    CHECK_STATUS(sm_tone_get_state(p.flow, fresh), SM_OK);
    CHECK(memcmp(state, fresh, size * sizeof *state) == 0);
    sm_tone_free(p.flow);
}

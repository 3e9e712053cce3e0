/* Calls of full order with elastic contacts. */
#include "fixtures.h"

void check_full_refusals(void);

#define N 4
#define CONTACTS 3
#define STATE (2 * N + 3 * CONTACTS + 1)

/* Masses with a contact each but the last, forces on all; trapezoidal rule. */
typedef struct {
    sm_full full;
    sm_elastic elastic;
    sm_element element[CONTACTS];
    sm_inputs inputs;
    sm_full_samples samples;
    double slider[2 * CONTACTS], reference[CONTACTS], stiffness[N], damping[N], inverse[N], own[N],
        directions[CONTACTS * N], patterns[2 * N], output[N], flexibility[CONTACTS * CONTACTS];
    double *state, *contact;
} full_call;

static void new_full(full_call *p, size_t samples) {
    *p = (full_call){.inputs = resonant_inputs(),
                     .elastic = {CONTACTS, CONTACTS, p->element, p->slider, p->reference},
                     .output = {1.0}};
    p->full = (sm_full){.coordinates = N, .contacts = CONTACTS, .modes = 2, .outputs = 1,
                        .law = SM_ELASTIC, .diagonal = 1, .step = 0.05, .stiffness = p->stiffness,
                        .damping = p->damping, .directions = p->directions,
                        .patterns = p->patterns, .output = p->output, .inverse = p->inverse,
                        .elastic = &p->elastic, .own = p->own, .ahead = p->own,
                        .flexibility = p->flexibility};
    for (int k = 0; k < N; k++) {
        p->damping[k] = 0.1;
        p->patterns[k] = p->patterns[2 * N - 1 - k] = 1.0 + k;
        p->stiffness[k] = k; /* the first mass is free */
        p->own[k] = 0.025;
        p->inverse[k] = 1.0 / (1.0 / 0.025 + 0.1 + 0.025 * k);
    }
    for (int i = 0; i < CONTACTS; i++) {
        p->slider[2 * i] = 0.5 + i;
        p->slider[2 * i + 1] = p->reference[i] = 4.0;
        p->directions[i * N + i] = 1.0;
        p->element[i] = (sm_element){.law = SM_SLIDERS, .column = {i}, .sliders = 1,
                                     .first_slider = i};
        const double D = 0.025 * p->inverse[i];
        p->flexibility[i * (CONTACTS + 1)] = D / (1.0 + 4.0 * D);
    }
    p->contact = new_doubles(samples * 3 * CONTACTS);
    p->samples = (sm_full_samples){samples, 5, new_doubles(samples), new_doubles(samples),
                                   p->contact, new_doubles(samples)};
    p->state = new_doubles(sm_full_state_count(&p->full));
}

static sm_status march(void *arguments) {
    full_call *p = arguments;
    return sm_full_march(&p->full, &p->inputs, 0.0, p->state, &p->samples);
}

void check_full_refusals(void) {
    full_call p;
    new_full(&p, 2);
    REFUSES_INTS(&p.full.law, march, &p, -1, 3);
    REFUSES_INTS(&p.full.coordinates, march, &p, 0, -1, 2);
    REFUSES_INTS(&p.elastic.elements, march, &p, 4);
    REFUSES_INTS(&p.element[1].column[0], march, &p, 3);
    REFUSES_NULL(march, &p, &p.full.flexibility, &p.full.own, &p.full.ahead, &p.full.elastic,
                 &p.elastic.reference, &p.samples.contact, &p.samples.every);
    REFUSES(&p.own[2], march, &p, 0.0, -1.0);
    REFUSES(&p.slider[1], march, &p, 0.0);
    REFUSES(&p.full.step, march, &p, 0.0);
    REFUSES_NOT_FINITE(march, &p, {p.flexibility, COUNT(p.flexibility)},
                       {p.slider, COUNT(p.slider)}, {p.inverse, N}, {p.own, N},
                       {p.state, STATE + CONTACTS});
    check_no_memory(march, &p);
}

/* Full order with elastic contacts: conservation of energy, friction with lift-off. */
#include "fixtures.h"

void check_full(int times);
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

static void set_step(full_call *p, double h) {
    const double own = 0.5 * h;
    p->full.step = h;
    for (size_t k = 0; k < N; k++) {
        p->own[k] = own;
        p->inverse[k] = 1.0 / (1.0 / own + p->damping[k] + own * p->stiffness[k]);
        if (k == CONTACTS) break;
        const double D = own * p->inverse[k];
        p->flexibility[k * (CONTACTS + 1)] = D / (1.0 + p->reference[k] * D);
    }
}

/* Jenkins elements, or one frictional contact in two directions on three masses. */
static void new_full(full_call *p, int frictional, size_t samples) {
    *p = (full_call){.inputs = resonant_inputs(),
                     .elastic = {frictional ? 1 : CONTACTS, frictional ? 0 : CONTACTS, p->element,
                                 p->slider, p->reference},
                     .output = {1.0}};
    p->full = (sm_full){.coordinates = N, .contacts = CONTACTS, .modes = 2, .outputs = 1,
                        .law = SM_ELASTIC, .diagonal = 1, .stiffness = p->stiffness,
                        .damping = p->damping, .directions = p->directions,
                        .patterns = p->patterns, .output = p->output, .inverse = p->inverse,
                        .elastic = &p->elastic, .own = p->own, .ahead = p->own,
                        .flexibility = p->flexibility};
    for (int k = 0; k < N; k++) {
        p->damping[k] = 0.1;
        p->patterns[k] = p->patterns[2 * N - 1 - k] = 1.0 + k;
        p->stiffness[k] = k; /* the first mass is free */
    }
    for (int i = 0; i < CONTACTS; i++) {
        p->slider[2 * i] = 0.5 + i;
        p->slider[2 * i + 1] = p->reference[i] = 4.0;
        p->directions[i * N + i] = 1.0;
        p->element[i] = (sm_element){.law = SM_SLIDERS, .column = {i}, .sliders = 1,
                                     .first_slider = i};
    }
    if (frictional)
        p->element[0] = (sm_element){.law = SM_FRICTIONAL, .column = {0, 1, 2}, .tangents = 2,
                                     .friction = 0.4, .preload = 0.5, .tangential_stiffness = 4.0,
                                     .normal_stiffness = 4.0};
    p->contact = new_doubles(samples * 3 * CONTACTS);
    p->samples = (sm_full_samples){samples, 5, new_doubles(samples), new_doubles(samples),
                                   p->contact, new_doubles(samples)};
    set_step(p, 0.05);
    p->state = new_doubles(sm_full_state_count(&p->full));
}

static sm_status march(void *arguments) {
    full_call *p = arguments;
    return sm_full_march(&p->full, &p->inputs, 0.0, p->state, &p->samples);
}

/* The trapezoidal rule conserves energy exactly: without forces and dampers, what the masses lose
 * is the work on the contacts. Friction stays within its limit, or on the cone of contacts that
 * open. */
static void check_energy(int frictional) {
    full_call p;
    int slips = 0, open = 0;
    new_full(&p, frictional, 1);
    memset(p.inputs.force, 0, sizeof p.inputs.force);
    memset(p.damping, 0, sizeof p.damping);
    set_step(&p, 0.05);
    for (int k = 0; k < N; k++) p.state[N + k] = 1.0 + 0.5 * k;
    for (int k = 0; k < CONTACTS; k++) p.state[2 * N + CONTACTS + k] = p.state[N + k];
    for (int s = 0; s < 400; s++) {
        double energy = p.samples.dissipated[0] - 0.5 * (1.0 + 2.25 + 4.0 + 6.25);
        const double *x = p.contact, *f = x + 6;
        for (int k = 0; k < N; k++)
            energy += 0.5 * (p.stiffness[k] * pow(p.state[k], 2.0) + pow(p.state[N + k], 2.0));
        CHECK_NEAR(energy, 0.0, 1e-11);
        CHECK_STATUS(march(&p), SM_OK);
        const double normal = fmax(0.0, 0.5 + 4.0 * x[2]), size = hypot(f[0], f[1]);
        for (int i = 0; i < CONTACTS && !frictional; i++) CHECK(fabs(f[i]) <= p.slider[2 * i]);
        if (!frictional) continue;
        CHECK_NEAR(f[2], normal - 0.5, 1e-12);
        CHECK(size <= 0.4 * normal * (1.0 + 1e-9) + 1e-12);
        open += normal == 0.0;
        slips += normal > 0.0 && size > 0.4 * normal * (1.0 - 1e-9);
    }
    CHECK(!frictional || (open > 20 && slips > 5));
}

void check_full(int times) {
    (void)times;
    check_energy(0);
    check_energy(1);
}

void check_full_refusals(void) {
    full_call p;
    new_full(&p, 0, 2);
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

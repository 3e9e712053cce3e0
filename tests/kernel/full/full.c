/* Full order with elastic contacts: one mass on a Jenkins element, refusals, random calls. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"
#include "fixtures.h"

/* Free masses with unit damping rates, one contact each; arrays in blocks of their own. */
typedef struct {
    sm_full full;
    sm_elastic elastic;
    sm_element *element;
    double *slider, *reference, *stiffness, *damping, *directions, *patterns, *output, *inverse,
        *own, *ahead, *flexibility, *state, *displacement, *velocity, *contact, *dissipated;
    sm_inputs inputs;
    size_t samples, every;
} problem_full;

static void set_step(problem_full *p, double h) {
    const double own = 0.5 * h;
    const size_t n = (size_t)p->full.coordinates, contacts = (size_t)p->full.contacts;
    p->full.step = h;
    for (size_t k = 0; k < n; k++) {
        p->own[k] = p->ahead[k] = own; /* the trapezoidal rule */
        p->inverse[k] = 1.0 / (1.0 / own + p->damping[k] + own * p->stiffness[k]);
    }
    for (size_t i = 0; i < contacts; i++) { /* each contact is on one mass */
        const double D = own * p->inverse[i];
        p->flexibility[i * contacts + i] = D / (1.0 + p->reference[i] * D);
    }
}

/* `contacts` Jenkins elements, or one frictional contact in two directions on three masses. */
static problem_full new_full(int frictional, size_t samples) {
    const size_t contacts = 3, n = 4;
    problem_full p = {.samples = samples, .every = 5};
    p.element = calloc(frictional ? 1 : contacts, sizeof *p.element);
    p.slider = new_doubles(2 * contacts);
    p.reference = new_doubles(contacts);
    for (size_t i = 0; i < contacts; i++) {
        p.slider[2 * i] = 0.5 + (double)i;
        p.slider[2 * i + 1] = 4.0;
        p.reference[i] = 4.0;
        if (!frictional)
            p.element[i] = (sm_element){.law = SM_SLIDERS, .column = {(int32_t)i}, .sliders = 1,
                                        .first_slider = (int32_t)i};
    }
    if (frictional)
        p.element[0] = (sm_element){.law = SM_FRICTIONAL, .column = {0, 1, 2}, .tangents = 2,
                                    .friction = 0.4, .preload = 0.5,
                                    .tangential_stiffness = 4.0, .normal_stiffness = 4.0};
    p.elastic = (sm_elastic){.elements = frictional ? 1 : (int32_t)contacts,
                             .sliders = frictional ? 0 : (int32_t)contacts,
                             .element = p.element, .slider = p.slider, .reference = p.reference};
    p.stiffness = new_doubles(n);
    p.damping = new_doubles(n);
    p.inverse = new_doubles(n);
    p.own = new_doubles(n);
    p.ahead = new_doubles(n);
    p.directions = new_doubles(contacts * n);
    p.patterns = new_doubles(2 * n);
    p.output = new_doubles(n);
    p.flexibility = new_doubles(contacts * contacts);
    for (size_t k = 0; k < n; k++) {
        p.damping[k] = 0.1;
        p.patterns[k] = p.patterns[n + (n - 1 - k)] = 1.0 + (double)k;
        p.stiffness[k] = (double)k; /* the first mass is free */
    }
    for (size_t i = 0; i < contacts; i++) p.directions[i * n + i] = 1.0;
    p.output[0] = 1.0;
    p.inputs = resonant_inputs();
    p.full = (sm_full){.coordinates = (int32_t)n, .contacts = (int32_t)contacts, .modes = 2,
                       .outputs = 1, .law = SM_ELASTIC, .diagonal = 1,
                       .stiffness = p.stiffness, .damping = p.damping,
                       .directions = p.directions, .patterns = p.patterns, .output = p.output,
                       .inverse = p.inverse, .own = p.own, .ahead = p.ahead,
                       .flexibility = p.flexibility};
    set_step(&p, 0.05);
    p.state = new_doubles(2 * n + 3 * contacts + 1 + sm_elastic_memory(&p.elastic));
    p.displacement = new_doubles(samples);
    p.velocity = new_doubles(samples);
    p.contact = new_doubles(samples * 3 * contacts);
    p.dissipated = new_doubles(samples);
    return p;
}

static void free_full(problem_full *p) {
    double *const arrays[] = {p->slider, p->reference, p->stiffness, p->damping, p->directions,
                              p->patterns, p->output, p->inverse, p->own, p->ahead,
                              p->flexibility, p->state,
                              p->displacement, p->velocity, p->contact, p->dissipated};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) free(arrays[k]);
    free(p->element);
}

static sm_status march(void *arguments) {
    problem_full *p = arguments;
    p->full.elastic = &p->elastic; /* the problem itself may have moved */
    const sm_full_samples samples = {p->samples,  p->every,   p->displacement,
                                     p->velocity, p->contact, p->dissipated};
    return sm_full_march(&p->full, &p->inputs, 0.0, p->state, &samples);
}

static void clear_state(problem_full *p) {
    memset(p->state, 0, sm_full_state_count(&p->full) * sizeof(double));
}

/* A mass set free beyond the limit: it swings about where its slider stops, and loses limit times
 * the way that the slider goes. */
static void check_free_mass(void) {
    problem_full p = new_full(0, 1600);
    memset(p.damping, 0, 4 * sizeof(double));
    memset(p.inputs.force, 0, sizeof p.inputs.force);
    set_step(&p, 0.0025);
    CHECK_STATUS(march(&p), SM_OK);
    CHECK(sm_full_state_count(&p.full) == 2 * 4 + 3 * 3 + 1 + 3);
    clear_state(&p);
    p.state[4] = p.state[4 + 4 + 3] = 2.0; /* velocity, of the mass and of its contact */
    CHECK_STATUS(march(&p), SM_OK);
    const double slid = p.state[2 * 4 + 3 * 3 + 1]; /* half of v^2 = 4 less what the spring has */
    CHECK_NEAR(slid, (2.0 - 0.5 * 0.25 / 4.0) / 0.5, 1e-4);
    for (size_t s = 800; s < p.samples; s++) {
        const double *x = p.contact + s * 9;
        CHECK_NEAR(x[6], 4.0 * (x[0] - slid), 1e-5);
        CHECK_NEAR(x[3] * x[3] + 4.0 * (x[0] - slid) * (x[0] - slid), 0.25 / 4.0, 1e-4);
    }
    free_full(&p);
}

/* Friction stays on its disk; the contact opens and closes, and energy is only lost. */
static void check_frictional(void) {
    problem_full p = new_full(1, 2000);
    CHECK_STATUS(march(&p), SM_OK);
    int open = 0, slips = 0;
    for (size_t s = 0; s < p.samples; s++) {
        const double *x = p.contact + s * 9, *f = x + 6;
        const double normal = fmax(0.0, 0.5 + 4.0 * x[2]), most = 0.4 * normal;
        const double size = sqrt(f[0] * f[0] + f[1] * f[1]);
        CHECK_NEAR(f[2], normal - 0.5, 1e-12);
        CHECK(size <= most * (1.0 + 1e-9) + 1e-12);
        open += normal == 0.0;
        slips += normal > 0.0 && size > most * (1.0 - 1e-9);
    }
    CHECK(open > 20 && slips > 200 && open + slips < 1990);
    free_full(&p);
}

static void check_refusals(void) {
    problem_full p = new_full(0, 2);
    CHECK_STATUS(march(&p), SM_OK);
    CHECK_REFUSES(int32_t, p.full.law, 3, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, p.full.flexibility, NULL, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, p.full.own, NULL, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, p.full.ahead, NULL, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.own[2], 0.0, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.ahead[2], -1.0, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, p.elastic.reference, NULL, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, p.elastic.elements, 4, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, p.element[1].column[0], 3, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.slider[1], 0.0, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, p.full.step, 0.0, march(&p), SM_BAD_ARGUMENT);
    CHECK_REFUSES_NOT_FINITE(p.flexibility, 9, march, &p);
    CHECK_REFUSES_NOT_FINITE(p.reference, 3, march, &p);
    CHECK_REFUSES_NOT_FINITE(p.slider, 6, march, &p);
    CHECK_REFUSES_NOT_FINITE(p.inverse, 4, march, &p);
    CHECK_REFUSES_NOT_FINITE(p.own, 4, march, &p);
    CHECK_REFUSES_NOT_FINITE(p.ahead, 4, march, &p);
    CHECK_REFUSES_NOT_FINITE(p.state, sm_full_state_count(&p.full), march, &p);
    p.full.elastic = NULL;
    const sm_full_samples samples = {p.samples,  p.every,   p.displacement,
                                     p.velocity, p.contact, p.dissipated};
    CHECK_STATUS(sm_full_march(&p.full, &p.inputs, 0.0, p.state, &samples), SM_BAD_ARGUMENT);
    allocations_left = 0;
    CHECK_STATUS(march(&p), SM_NO_MEMORY);
    allocations_left = -1;
    CHECK_STATUS(march(&p), SM_OK);
    free_full(&p);
}

/* Forces at a displacement, and the memory moved along. */
static void check_force(void) {
    problem_full p = new_full(0, 1);
    double x[] = {0.1, -2.0, 5.0}, memory[3] = {0.0}, force[3];
    CHECK_STATUS(sm_elastic_force(&p.elastic, 3, x, memory, force), SM_OK);
    CHECK_NEAR(force[0], 0.4, 1e-15);
    CHECK_NEAR(force[1], -1.5, 1e-15);
    CHECK_NEAR(force[2], 2.5, 1e-15);
    CHECK(memory[0] == 0.0);
    CHECK_NEAR(memory[1], -2.0 + 1.5 / 4.0, 1e-15);
    CHECK_STATUS(sm_elastic_force(&p.elastic, 3, x, memory, NULL), SM_BAD_ARGUMENT);
    x[0] = NAN;
    CHECK_STATUS(sm_elastic_force(&p.elastic, 3, x, memory, force), SM_NOT_FINITE);
    free_full(&p);
}

/* Whatever drives them, contacts are solved for. */
static void check_random_marches(void) {
    for (int k = 0; k < 300; k++) {
        problem_full p = new_full(k % 2, 20);
        for (size_t i = 0; i < 3; i++) {
            p.slider[2 * i] *= pow(10.0, 8.0 * random_number() - 4.0);
            p.slider[2 * i + 1] = p.reference[i] = pow(10.0, 8.0 * random_number() - 4.0);
        }
        if (k % 2) {
            p.element[0].friction = 2.0 * random_number();
            p.element[0].preload = random_below(2) ? 0.0 : 10.0 * random_number();
            p.element[0].tangential_stiffness = p.reference[0] = p.reference[1];
            p.element[0].normal_stiffness = p.reference[2];
        }
        for (int j = 0; j < 2; j++) p.inputs.force[j] *= pow(10.0, 6.0 * random_number() - 3.0);
        set_step(&p, pow(10.0, 3.0 * random_number() - 3.0));
        CHECK_STATUS(march(&p), SM_OK);
        CHECK_FINITE(p.contact, p.samples * 9);
        free_full(&p);
    }
}

void check_full(void) {
    check_free_mass();
    check_frictional();
    check_force();
    check_refusals();
    check_random_marches();
}

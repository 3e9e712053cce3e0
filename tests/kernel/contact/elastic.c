/* Elastic contacts: their solver on random systems, what is refused, random torus and motion. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact/elastic/solve.h"
#include "driver.h"
#include "elastic_fixture.h"

#define STEPS 60

/* new_joints, with the addresses of where they are. */
static void connected(int elements, int modes, int laws, double mu, double coupling, joints *j) {
    *j = new_joints(elements, modes, laws, mu, coupling);
    j->elastic.element = j->element;
    j->elastic.slider = j->slider;
    j->elastic.reference = j->reference;
    j->contact.elastic = &j->elastic;
}

/* |x - R y - u| at most, y found anew from the law. */
static double residual_of(const joints *j, const double *u, const double *x,
                          const double *memory) {
    const size_t n = (size_t)j->contact.contacts;
    double *y = new_doubles(n), *next = new_doubles(sm_elastic_memory(&j->elastic)), most = 0.0;
    for (int e = 0; e < j->elastic.elements; e++) {
        const sm_element *element = &j->element[e];
        sm_element_force at = {.next = next};
        sm_element_evaluate(&j->elastic, element, 1.0, x, memory, &at);
        memory += sm_element_memory(element);
        for (int k = 0; k < sm_element_columns(element); k++) {
            const int32_t i = element->column[k];
            y[i] = j->reference[i] * x[i] - at.force[k];
        }
    }
    for (size_t i = 0; i < n; i++) {
        double sum = x[i] - u[i];
        for (size_t k = 0; k < n; k++) sum -= j->flexibility[i * n + k] * y[k];
        most = fmax(most, fabs(sum));
    }
    free(y);
    free(next);
    return most;
}

static double largest(const double *values, size_t count) {
    double most = 0.0;
    for (size_t k = 0; k < count; k++) most = fmax(most, fabs(values[k]));
    return most;
}

/* Sliders of frictional contacts as another phase line had them: out of place by up to `size`. */
static void move_sliders(const joints *j, double size, double *memory) {
    for (int e = 0; e < j->elastic.elements; e++) {
        const sm_element *element = &j->element[e];
        for (int k = 0; k < element->tangents; k++) /* 0 of others */
            memory[k] += size * (2.0 * random_number() - 1.0);
        memory += sm_element_memory(element);
    }
}

/* Steps of a motion with leaps, with u exactly 0, and with sliders moved, that are not solved. */
static int unsolved_steps(const joints *j) {
    const size_t n = (size_t)j->contact.contacts, remembered = sm_elastic_memory(&j->elastic);
    double *u = new_doubles(n), *last = new_doubles(n), *x = new_doubles(n);
    double *before = new_doubles(n), *memory = new_doubles(remembered), constant = 0.0;
    double *taken = new_doubles(n), *residual = new_doubles(n);
    const double size = pow(10.0, 3.0 * random_number() - 2.5), turn = 0.02 + random_number();
    const int follows = random_below(2);
    int unsolved = 0;
    sm_elastic_solver solver;
    sm_block block = {NULL, 0};
    sm_elastic_solver_place(&solver, &j->elastic, (int)n, j->flexibility, &block);
    CHECK(sm_allocate(&block));
    sm_elastic_solver_place(&solver, &j->elastic, (int)n, j->flexibility, &block);
    for (int e = 0; e < j->elastic.elements; e++) {
        const sm_element *element = &j->element[e];
        if (element->law == SM_FRICTIONAL)
            constant = fmax(constant,
                            fmax(element->preload / element->normal_stiffness, element->gap));
    }
    solver.least = follows ? 1e-3 * size : 0.0; /* rounding of all steps so far stays */
    for (int k = 0; k < STEPS; k++) {
        const int leap = random_below(40);
        for (size_t i = 0; i < n; i++) {
            u[i] = size * (sin(turn * (1.0 + (double)(i % 3)) * k) + 0.3 * sin(2.7 * turn * k));
            if (leap == 0) u[i] = 5.0 * size * (random_number() - 0.5);
            if (leap == 1) u[i] = 0.0;
            before[i] = x[i];
            x[i] += u[i] - last[i];
        }
        if (leap == 2) move_sliders(j, size, memory);
        const double scale = fmax(solver.least, fmax(largest(u, n), largest(x, n)));
        const sm_status status =
            follows ? sm_elastic_follow(&solver, u, memory, x, taken, residual)
                    : sm_elastic_solve(&solver, u, memory, x);
        if (status != SM_OK) {
            unsolved++;
            memcpy(x, before, n * sizeof(double));
            for (size_t i = 0; i < n; i++) {
                taken[i] = 0.0;
                residual[i] = x[i] - last[i];
            }
            continue;
        }
        const double allowed = 1e-10 * fmax(scale, largest(x, n)) + 1e-14 * constant;
        CHECK(residual_of(j, u, x, memory) <= allowed);
        memcpy(memory, solver.next, remembered * sizeof(double));
        memcpy(last, u, n * sizeof(double));
    }
    free(block.memory);
    free(u);
    free(last);
    free(x);
    free(before);
    free(memory);
    free(taken);
    free(residual);
    return unsolved;
}

/* Unique solutions are found, all; where strong friction on soft structures jams, nearly all. */
static void check_solver(void) {
    const struct {
        int laws;
        double mu, coupling;
        int most;
    } cases[] = {{ONLY_SLIDERS, 0.0, 1.0, 0}, {ANY_LAW, 0.3, 0.5, 0}, {ANY_LAW, 2.0, 0.9, 3}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        int unsolved = 0;
        for (int k = 0; k < 150; k++) {
            joints j;
            connected(1 + random_below(6), 1, cases[c].laws, cases[c].mu, cases[c].coupling, &j);
            CHECK_STATUS(sm_contact_check(&j.contact), SM_OK);
            unsolved += unsolved_steps(&j);
            free_joints(&j);
        }
        CHECK(unsolved <= cases[c].most);
    }
}

static sm_status check_call(void *arguments) {
    return sm_contact_check(&((joints *)arguments)->contact);
}

static void check_refusals(void) {
    joints j;
    do { /* until a frictional contact comes first, and sliders next */
        connected(5, 2, ANY_LAW, 0.5, 0.5, &j);
        if (j.element[0].law == SM_FRICTIONAL && j.element[1].law == SM_SLIDERS) break;
        free_joints(&j);
    } while (1);
    const size_t n = (size_t)j.contact.contacts;
    sm_element *f = &j.element[0], *s = &j.element[1];
    CHECK_STATUS(check_call(&j), SM_OK);
    CHECK_REFUSES(const sm_elastic *, j.contact.elastic, NULL, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, j.contact.stiffness, NULL, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, j.contact.coupling, NULL, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, j.contact.mass, j.stiffness, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const sm_element *, j.elastic.element, NULL, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, j.elastic.slider, NULL, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const double *, j.elastic.reference, NULL, check_call(&j), SM_BAD_ARGUMENT);
    const int32_t elements[] = {0, -1, 4, INT32_MAX}; /* there are 5 */
    for (size_t k = 0; k < sizeof elements / sizeof *elements; k++)
        CHECK_REFUSES(int32_t, j.elastic.elements, elements[k], check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, j.elastic.sliders, -1, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, j.elastic.sliders, 0, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, j.elastic.sliders, INT32_MAX, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, f->law, 2, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, f->column[0], -1, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, f->column[0], (int32_t)n, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, f->column[0], f->column[1], check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, f->column[0], s->column[0], check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, f->tangents, 0, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, f->tangents, 3, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, s->sliders, 0, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, s->sliders, INT32_MAX, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, s->first_slider, -1, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, s->first_slider, INT32_MAX, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, f->friction, -0.1, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, f->preload, -0.1, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, f->gap, -0.1, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, f->tangential_stiffness, 0.0, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, f->normal_stiffness, -1.0, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, j.slider[0], -1.0, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, j.slider[1], 0.0, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, j.reference[0], -1.0, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, j.stiffness[0], 1.0, check_call(&j), SM_BAD_ARGUMENT);
    CHECK_REFUSES(double, j.stiffness[1], j.stiffness[1] + 1e3, check_call(&j), SM_BAD_ARGUMENT);
    double *const numbers[] = {&f->friction, &f->preload, &f->gap, &f->tangential_stiffness,
                               &f->normal_stiffness};
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
        CHECK_REFUSES_NOT_FINITE(numbers[k], 1, check_call, &j);
    CHECK_REFUSES_NOT_FINITE(j.slider, 2 * (size_t)j.elastic.sliders, check_call, &j);
    CHECK_REFUSES_NOT_FINITE(j.reference, n, check_call, &j);
    CHECK_REFUSES_NOT_FINITE(j.stiffness, n * n, check_call, &j);
    CHECK_REFUSES_NOT_FINITE(j.coupling, 4 * n, check_call, &j);
    free_joints(&j);
}

/* Something of it wrong, or extreme, every other time. */
static void spoil_joints(joints *j) {
    const double wrong[] = {0.0, -1.0, NAN, INFINITY, 1e300, -1e300, 1e-300, 5e-324, 1e12};
    const double value = wrong[random_below((int)(sizeof wrong / sizeof *wrong))];
    const int32_t number = (int32_t[]){-1, 0, 2, 7, INT32_MAX, INT32_MIN}[random_below(6)];
    sm_element *element = &j->element[random_below(j->elastic.elements)];
    const size_t n = (size_t)j->contact.contacts;
    switch (random_below(20)) {
    case 0: element->friction = value; break;
    case 1: element->preload = value; break;
    case 2: element->gap = value; break;
    case 3: element->tangential_stiffness = value; break;
    case 4: element->normal_stiffness = value; break;
    case 5: element->column[random_below(3)] = number; break;
    case 6: element->sliders = number; break;
    case 7: element->first_slider = number; break;
    case 8: element->tangents = number; break;
    case 9: element->law = number; break;
    case 10: j->reference[random_below((int)n)] = value; break;
    case 11: j->stiffness[(n + 1) * (size_t)random_below((int)n)] = value; break;
    case 12: j->coupling[random_below(2 * (int)n)] = value; break;
    case 13: if (j->elastic.sliders) j->slider[random_below(2 * j->elastic.sliders)] = value; break;
    default: break;
    }
}

static void check_response(sm_status status, const double *values, size_t count) {
    CHECK(status >= SM_OK && status <= SM_STEP_TOO_SMALL);
    if (status == SM_OK) CHECK_FINITE(values, count);
}

/* Sliders that stick lack no force, however they are moved. */
static void check_that_what_sticks_needs_no_rate_correction(void) {
    joints j;
    connected(3, 2, ONLY_SLIDERS, 0.0, 0.7, &j);
    const double rates[] = {1.0, 1.7}, growth[] = {0.2, -0.1, 0.0, 0.3};
    double amplitudes[] = {1e-9, 2e-9, 3.0, 2.0}, P[2 * 2 * 3 * 2], stuck = 0.0, slipped = 0.0;
    const int32_t orders[] = {1, 0, 0, 1};
    double slow[4];
    for (int k = 0; k < 2 * j.elastic.sliders; k += 2)
        j.slider[k] = fmax(j.slider[k], 1e-3); /* each holds a little */
    for (int k = 0; k < 4; k++) slow[k] = 1e-9 * growth[k];
    const sm_discretisation grid = {rates, 32, 8, 2, orders, 0.0, NULL, 0};
    CHECK_STATUS(sm_torus_growing(&j.contact, &grid, 2, amplitudes, slow, P), SM_OK);
    for (int k = 0; k < 12; k++) stuck = fmax(stuck, fabs(P[k]));
    for (int k = 12; k < 24; k++) slipped = fmax(slipped, fabs(P[k]));
    CHECK(stuck < 1e-18 && slipped > 1e-3);
    free_joints(&j);
}

static int random_torus(void) {
    joints j;
    connected(1 + random_below(4), 1 + random_below(2), ANY_LAW, 0.6, 0.7, &j);
    const size_t points = (size_t)random_below(3), n = (size_t)j.contact.contacts;
    const size_t modes = (size_t)j.contact.modes;
    const int32_t orders[] = {1, 0, 0, 1, 0, 0, 2, 0}, count = 4;
    const double rates[] = {1.0, 1.7}, smallest[] = {0.0, 0.1};
    double *H = new_doubles(4 * n * n * 2);
    for (size_t k = 0; k < 4 * n * n * 2; k++) H[k] = 0.02 * (random_number() - 0.5);
    double *start = new_doubles(4 * n * 2), *held = new_doubles(4 * n * 2);
    for (size_t k = 0; k < 4 * n * 2; k++) {
        start[k] = random_number() - 0.5;
        held[k] = 0.1 * (random_number() - 0.5);
    }
    if (random_below(16) == 0) (random_below(2) ? start : held)[random_below((int)n)] = NAN;
    const sm_modal_response response = {.orders_count = count,
                                        .orders = orders,
                                        .asked = random_below(count + 1),
                                        .dynamic_stiffness = H,
                                        .start = random_below(2) ? start : NULL,
                                        .held = random_below(2) ? held : NULL};
    double *amplitudes = new_doubles(points * modes), *P = new_doubles(points * 4 * n * 2);
    double *residual = new_doubles(points), *square = new_doubles(points * n);
    double *near = new_doubles(points * 4 * n * 2);
    int32_t *marched = malloc((points + 1) * sizeof *marched);
    for (size_t k = 0; k < points * modes; k++) amplitudes[k] = 3.0 * random_number();
    for (size_t k = 0; k < points * 4 * n * 2; k++) near[k] = random_number() - 0.5;
    if (points > 0 && random_below(16) == 0) near[random_below((int)points)] = NAN;
    if (random_below(2)) j.contact.response = &response;
    spoil_joints(&j);
    sm_discretisation grid = {rates, 4 + random_below(9), 1 << random_below(4), count, orders,
                              1e-3,  smallest,            1 + random_below(6)};
    const sm_torus_points where = {points, amplitudes, random_below(2) ? near : NULL};
    const sm_torus_motion motion = {P, square, residual, marched};
    const sm_status status = sm_torus_harmonics(&j.contact, &grid, &where, &motion);
    check_response(status, P, points * 4 * n * 2);
    check_response(status, square, points * n);
    for (size_t k = 0; k < points && status == SM_OK; k++) CHECK(residual[k] >= 0.0);
    grid.steps = 4 + random_below(9);
    grid.lines = 1 << random_below(4);
    const sm_status growing =
        sm_torus_growing(&j.contact, &grid, points, amplitudes, amplitudes, P);
    check_response(growing, P, points * 4 * n * 2);
    if (status == SM_OK && j.contact.response) CHECK_STATUS(growing, SM_BAD_ARGUMENT);
    free_joints(&j);
    free(H);
    free(start);
    free(held);
    free(amplitudes);
    free(P);
    free(residual);
    free(square);
    free(near);
    free(marched);
    return status == SM_OK;
}

static int random_motion(void) {
    joints j;
    connected(1 + random_below(4), 1 + random_below(2), ANY_LAW, 0.6, 0.7, &j);
    const size_t n = (size_t)j.contact.contacts;
    const sm_segment g = {.start = 1.0,
                          .duration = 2.0,
                          .amplitude_start = {1.0, 0.0, 0.0, 1.0},
                          .amplitude_end = {0.5, 2.0, 0.3, 0.0},
                          .angle = {0.1, 0.2},
                          .frequency = {1.0, 1.7}};
    const double times[] = {1.5, 2.0, 3.0};
    double *x = new_doubles(9 * n), *from = new_doubles(n);
    if (random_below(8) == 0) from[random_below((int)n)] = random_below(2) ? NAN : 1e200;
    spoil_joints(&j);
    const sm_contact_samples samples = {3, times, x, x + 3 * n, x + 6 * n};
    const sm_status status =
        sm_contact_motion(&j.contact, 1, &g, from, 4 + random_below(60), &samples);
    check_response(status, x, 9 * n);
    free_joints(&j);
    free(x);
    free(from);
    return status == SM_OK;
}

/* Outputs, runs and states of a component have the sizes that it says, and continue exactly. */
static void check_component_of(int laws) {
    joints j;
    connected(3, 2, laws, 0.5, 0.5, &j);
    const size_t n = (size_t)j.contact.contacts, outputs = SM_OUTPUTS_FIXED + 3 * n + 1;
    table t = new_table(2, 4, 4);
    const sm_slow_flow flow = flow_over(&t);
    double *modes_out = new_doubles(4), *forces_out = new_doubles(4), *contacts_out = new_doubles(n);
    for (size_t i = 0; i < n; i++) contacts_out[i] = 0.1 * (double)i;
    const sm_motion motion = {.wanted = 1, .elastic = 1, .modes_out = modes_out, .forces_out = forces_out,
                              .contacts_out = contacts_out, .steps_per_period = 32,
                              .memory_periods = 4.0};
    sm_component *c, *twin;
    CHECK_STATUS(sm_component_create(&flow, &j.contact, &motion, 1e-6, &c), SM_OK);
    CHECK_STATUS(sm_component_create(&flow, &j.contact, &motion, 1e-6, &twin), SM_OK);
    CHECK(sm_component_output_count(c) == outputs);
    const size_t count = sm_component_state_count(c);
    double *state = new_doubles(count), *rows = new_doubles(3 * outputs), *row = new_doubles(outputs);
    const sm_inputs inputs[] = {resonant_inputs(), resonant_inputs(), resonant_inputs()};
    const double durations[] = {0.1, 30.0, 0.7};
    size_t done;
    CHECK_STATUS(sm_component_run(c, 2, durations, inputs, rows, &done), SM_OK);
    CHECK_STATUS(sm_component_get_state(c, state), SM_OK);
    CHECK_STATUS(sm_component_set_state(twin, state), SM_OK);
    CHECK_STATUS(sm_component_step(c, durations[2]), SM_OK);
    CHECK_STATUS(sm_component_outputs(c, row), SM_OK);
    CHECK_STATUS(sm_component_run(twin, 1, durations + 2, inputs, rows, &done), SM_OK);
    CHECK_FINITE(row, outputs);
    CHECK(memcmp(row, rows, outputs * sizeof(double)) == 0);
    CHECK(largest(row + SM_OUTPUTS_FIXED, n) > 1e-3);
    state[count - 1] = NAN;
    CHECK_STATUS(sm_component_set_state(twin, state), SM_NOT_FINITE);
    sm_component_free(c);
    sm_component_free(twin);
    free_joints(&j);
    free_table(&t);
    free(modes_out);
    free(forces_out);
    free(contacts_out);
    free(state);
    free(rows);
    free(row);
}

/* A component of a model without contacts; what solves or marches contacts refuses it. */
static void check_no_contacts(void) {
    sm_element element = {.law = SM_SLIDERS, .sliders = 1};
    double number = 1.0, mean_square, residual, modes_out[] = {1.0, 0.0}, forces_out[2] = {0.0};
    sm_elastic none = {.element = &element, .slider = &number, .reference = &number};
    sm_contact contact = {.modes = 1, .law = SM_ELASTIC, .stiffness = &number,
                          .coupling = &number, .elastic = &none};
    CHECK_STATUS(sm_contact_check(&contact), SM_OK);
    CHECK_REFUSES(int32_t, contact.law, SM_TANH, sm_contact_check(&contact), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, none.elements, 1, sm_contact_check(&contact), SM_BAD_ARGUMENT);
    CHECK_REFUSES(int32_t, none.sliders, 1, sm_contact_check(&contact), SM_BAD_ARGUMENT);
    CHECK_REFUSES(const sm_elastic *, contact.elastic, NULL, sm_contact_check(&contact),
                  SM_BAD_ARGUMENT);

    table t = new_table(1, 4, 1);
    const sm_slow_flow flow = flow_over(&t);
    const sm_motion motion = {.wanted = 1, .elastic = 1, .modes_out = modes_out,
                              .forces_out = forces_out, .steps_per_period = 32,
                              .memory_periods = 4.0};
    sm_component *c;
    CHECK_STATUS(sm_component_create(&flow, &contact, &motion, 1e-6, &c), SM_OK);
    CHECK(sm_component_output_count(c) == SM_OUTPUTS_FIXED + 1);
    const double start[] = {1.0, 0.5, 0.0, 0.0};
    double row[SM_OUTPUTS_FIXED + 1];
    double *state = new_doubles(sm_component_state_count(c));
    CHECK_STATUS(sm_component_reset(c, 0.0, start), SM_OK);
    CHECK_STATUS(sm_component_step(c, 2.3), SM_OK);
    CHECK_STATUS(sm_component_outputs(c, row), SM_OK);
    const double x = 2.0 * (row[1] * cos(row[5]) - row[2] * sin(row[5]));
    CHECK(fabs(row[SM_OUTPUTS_FIXED] - x) <= 1e-12);
    CHECK_STATUS(sm_component_get_state(c, state), SM_OK);
    CHECK_STATUS(sm_component_set_state(c, state), SM_OK);
    sm_component_free(c);
    free_table(&t);
    free(state);

    const int32_t orders[] = {1, 0};
    int32_t marched;
    const sm_discretisation grid = {&number, 32, 1, 1, orders, 1e-3, &number, 10};
    const sm_torus_points where = {1, &number, NULL};
    const sm_torus_motion found = {row, &mean_square, &residual, &marched};
    CHECK_STATUS(sm_torus_harmonics(&contact, &grid, &where, &found), SM_BAD_ARGUMENT);
    CHECK_STATUS(sm_torus_growing(&contact, &grid, 1, &number, &number, row), SM_BAD_ARGUMENT);
    const sm_segment segment = {.duration = 1.0, .frequency = {1.0}};
    const sm_contact_samples samples = {1, &mean_square, row, row, row};
    mean_square = 0.5; /* the time */
    CHECK_STATUS(sm_contact_motion(&contact, 1, &segment, NULL, 32, &samples), SM_BAD_ARGUMENT);
}

void check_elastic(void) {
    int tori = 0, motions = 0;
    check_refusals();
    check_no_contacts();
    check_solver();
    check_that_what_sticks_needs_no_rate_correction();
    check_component_of(ONLY_SLIDERS);
    check_component_of(ONLY_FRICTIONAL);
    for (int k = 0; k < 300; k++) {
        tori += random_torus();
        motions += random_motion();
    }
    CHECK(tori > 100 && tori < 300 && motions > 100 && motions < 300);
}

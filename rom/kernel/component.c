/* The step-able component: inputs held or ramped over a step, slow flow, contact motion at the
 * communication point. It owns copies of everything it needs, in one block of memory. */
#include <stdlib.h>

#include "check.h"
#include "exact_sum.h"
#include "motion.h"
#include "slow_flow.h"

typedef struct {
    sm_exact_sum time;            /* [s] */
    sm_exact_sum energy;          /* dissipated at the contacts [J] */
    sm_exact_sum angle[SM_MODES]; /* theta_j in [0, 2 pi) [rad] */
    double amplitude[2 * SM_MODES];
    double step;                  /* next internal step, 0: not chosen yet [s] */
} slow_state;

#define SLOW_STATE_COUNT (sizeof(slow_state) / sizeof(double))
#define MAX_TRIES 200000 /* internal steps of one call: inputs that race would never end */
#define INPUTS_COUNT (sizeof(sm_inputs) / sizeof(double))

struct sm_component {
    sm_slow_flow flow;
    sm_contact contact;
    sm_motion motion;
    double tolerance;
    sm_inputs inputs;
    slow_state slow;
    const double *limit;    /* (N_c) friction limits of the model */
    double *scaled_limit;   /* (N_c) as they are in the march: contact.limit */
    double *contact_state;  /* x_c, v_c, f_c at the communication point, 3 N_c */
    sm_march march;
    uint64_t accepted, rejected;
    /* what follows from state and inputs, kept where it is known: to the bit what it would be */
    int rate_known;
    double rate[SM_UNKNOWNS];
    sm_instant instant;
};

static sm_status check_motion(const sm_motion *motion, size_t modes, size_t contacts) {
    if (!motion->wanted) return SM_OK;
    if (motion->elastic < 0 || motion->elastic > 1000000) return SM_BAD_ARGUMENT;
    if (motion->steps_per_period < 4 || motion->steps_per_period > 65536) return SM_BAD_ARGUMENT;
    const size_t elastic = (size_t)motion->elastic;
    if (elastic > 0) {
        if (!motion->modes_out || !motion->contacts_out) return SM_BAD_ARGUMENT;
        if (!sm_all_finite(motion->modes_out, elastic * modes) ||
            !sm_all_finite(motion->contacts_out, elastic * contacts))
            return SM_NOT_FINITE;
    }
    return sm_check_positive(motion->memory_periods);
}

/* Copies `count` doubles to *memory and moves it on; returns where they went. */
static const double *keep(double **memory, const double *source, size_t count) {
    double *place = *memory;
    memcpy(place, source, count * sizeof(double));
    *memory += count;
    return place;
}

sm_status sm_component_create(const sm_slow_flow *flow, const sm_contact *contact,
                              const sm_motion *motion, double tolerance,
                              sm_component **component) {
    if (!flow || !motion || !component) return SM_BAD_ARGUMENT;
    sm_status status = sm_check_positive(tolerance);
    if (status == SM_OK) status = sm_table_check(&flow->table);
    if (status == SM_OK) status = sm_slow_flow_check(flow);
    if (status == SM_OK) status = sm_contact_check(contact);
    if (status != SM_OK) return status;
    if (contact->modes != flow->table.modes || tolerance >= 1.0) return SM_BAD_ARGUMENT;
    const size_t modes = (size_t)flow->table.modes, n = (size_t)contact->contacts;
    status = check_motion(motion, modes, n);
    if (status != SM_OK) return status;

    const size_t count_a = (size_t)flow->table.count_a;
    const size_t count_b = modes == 2 ? (size_t)flow->table.count_b : 0;
    const size_t fields = 2 * (modes + (size_t)flow->table.near + (size_t)flow->table.power);
    const size_t values = count_a * (modes == 2 ? count_b : 1) * 4 * fields;
    const size_t elastic = motion->wanted ? (size_t)motion->elastic : 0;
    const size_t total = count_a + count_b + values + 2 * n + 3 * n * n + 2 * modes * n
                         + elastic * (modes + n) + 3 * n + sm_march_size(contact->contacts);
    const size_t header = (sizeof(sm_component) + 63) & ~(size_t)63;
    sm_component *c = calloc(1, header + total * sizeof(double));
    if (!c) return SM_NO_MEMORY;
    double *memory = (double *)(void *)((char *)c + header);
    sm_march_place(&c->march, contact->contacts, memory);
    memory += sm_march_size(contact->contacts);
    c->contact_state = memory;
    memory += 3 * n;
    c->flow = *flow;
    c->contact = *contact;
    c->motion = *motion;
    c->tolerance = tolerance;
    c->flow.table.node_a = keep(&memory, flow->table.node_a, count_a);
    c->flow.table.node_b = modes == 2 ? keep(&memory, flow->table.node_b, count_b) : NULL;
    c->flow.table.values = keep(&memory, flow->table.values, values);
    c->limit = keep(&memory, contact->limit, n);
    c->contact.limit = c->scaled_limit = memory;
    memory += n;
    c->contact.stiffness = keep(&memory, contact->stiffness, n * n);
    c->contact.damping = keep(&memory, contact->damping, n * n);
    c->contact.mass = contact->mass ? keep(&memory, contact->mass, n * n) : NULL;
    c->contact.answer = NULL; /* the march has no harmonics to answer to */
    c->contact.coupling = keep(&memory, contact->coupling, 2 * modes * n);
    if (elastic > 0) {
        c->motion.modes_out = keep(&memory, motion->modes_out, elastic * modes);
        c->motion.contacts_out = keep(&memory, motion->contacts_out, elastic * n);
    }
    c->inputs.limit_scale = 1.0;
    for (size_t j = 0; j < modes; j++) c->inputs.frequency[j] = flow->natural[j];
    *component = c;
    return SM_OK;
}

void sm_component_free(sm_component *component) { free(component); }

/* The inputs carry the angles for the near resonances; the state has them exactly. */
static void align_angles(sm_component *c) {
    for (int j = 0; j < SM_MODES; j++) c->inputs.angle[j] = c->slow.angle[j].value;
}

/* SM_OK where the slow flow is defined: finite amplitudes inside the table. */
static sm_status rate_at(const sm_component *c, const sm_inputs *inputs, const double *amplitude,
                         double *rate) {
    sm_instant instant = {.known = 0};
    if (!sm_all_finite(amplitude, 2 * (size_t)c->flow.table.modes)) return SM_NOT_FINITE;
    return sm_slow_flow_derivative(&c->flow, inputs, &instant, amplitude, rate);
}

sm_status sm_component_reset(sm_component *c, double time, const double *amplitude) {
    if (!c || !amplitude) return SM_BAD_ARGUMENT;
    if (!isfinite(time)) return SM_NOT_FINITE;
    double rate[SM_UNKNOWNS];
    const sm_status status = rate_at(c, &c->inputs, amplitude, rate);
    if (status != SM_OK) return status;
    slow_state fresh = {.time = {time, 0.0}};
    memcpy(fresh.amplitude, amplitude, 2 * (size_t)c->flow.table.modes * sizeof(double));
    c->slow = fresh;
    align_angles(c);
    c->rate_known = 0; /* the angles are others */
    memset(c->contact_state, 0, 3 * (size_t)c->contact.contacts * sizeof(double));
    return SM_OK;
}

/* The limits can be scaled where friction is homogeneous. */
static sm_status check_inputs(const sm_component *c, const sm_inputs *inputs) {
    const sm_status status = sm_inputs_check(inputs, c->flow.table.modes);
    const int scaled = inputs->limit_scale != 1.0 || inputs->limit_scale_rate != 0.0;
    if (status != SM_OK || !scaled) return status;
    return c->contact.law == SM_COULOMB ? SM_OK : SM_BAD_ARGUMENT;
}

sm_status sm_component_set_inputs(sm_component *c, const sm_inputs *inputs) {
    if (!c || !inputs) return SM_BAD_ARGUMENT;
    const sm_status status = check_inputs(c, inputs);
    if (status != SM_OK) return status;
    const sm_inputs before = c->inputs;
    c->inputs = sm_inputs_after(inputs, c->flow.table.modes, 0.0);
    align_angles(c);
    if (memcmp(&before, &c->inputs, sizeof before) != 0) c->rate_known = 0;
    return status;
}

/* Marches the contacts over the part of [from, from + h] that lies after `marched_from`. */
static sm_status march_segment(sm_component *c, double from, double h, double marched_from,
                               const double *y, const double *dy, const double *y_new,
                               const double *dy_new) {
    sm_segment g = {.start = from, .duration = h};
    for (int k = 0; k < 2 * SM_MODES; k++) {
        g.amplitude_start[k] = y[k];
        g.amplitude_end[k] = y_new[k];
        g.rate_start[k] = dy[k];
        g.rate_end[k] = dy_new[k];
    }
    for (int j = 0; j < c->flow.table.modes; j++) {
        const double rate = c->inputs.frequency_rate[j];
        g.angle[j] = c->slow.angle[j].value + from * (c->inputs.frequency[j] + 0.5 * rate * from);
        g.frequency[j] = c->inputs.frequency[j] + rate * from;
        g.frequency_rate[j] = rate;
    }
    const double start = marched_from > from ? marched_from - from : 0.0;
    if (start >= h) return SM_OK;
    const double middle = from + 0.5 * (start + h);
    const double scale = c->inputs.limit_scale + c->inputs.limit_scale_rate * middle;
    for (int i = 0; i < c->contact.contacts; i++) c->scaled_limit[i] = scale * c->limit[i];
    return sm_march_along(&c->march, &c->contact, &g, start, h, c->motion.steps_per_period);
}

/* Seconds of a step of `duration` that pass before the contacts need marching. */
static double motion_starts(const sm_component *c, double duration) {
    double slowest = INFINITY;
    for (int j = 0; j < c->flow.table.modes; j++)
        slowest = fmin(slowest, c->inputs.frequency[j]);
    const double memory = c->motion.memory_periods * SM_TWO_PI / slowest;
    return duration > memory ? duration - memory : 0.0;
}

/* Integrates the slow flow over [0, duration], to the inputs `after`; y, its derivative dy, step
 * and the march are advanced. */
static sm_status integrate(sm_component *c, double duration, const sm_inputs *after, double *y,
                           double *dy, double *step) {
    const double marched_from = c->motion.wanted ? motion_starts(c, duration) : 0.0;
    double y_new[SM_UNKNOWNS], dy_new[SM_UNKNOWNS], error;
    sm_status status = SM_OK;
    if (c->rate_known)
        memcpy(dy, c->rate, sizeof c->rate);
    else
        status = sm_slow_flow_derivative(&c->flow, &c->inputs, &c->instant, y, dy);
    double elapsed = 0.0, h = *step > 0.0 ? *step : duration;
    int64_t tries = 0;
    while (status == SM_OK && elapsed < duration) {
        if (++tries > MAX_TRIES) return SM_STEP_TOO_SMALL;
        const double left = duration - elapsed;
        const int last = h >= left * (1.0 - 1e-12);
        const double tried = last ? left : h;
        const sm_inputs end =
            last ? *after : sm_inputs_after(&c->inputs, c->flow.table.modes, elapsed + tried);
        sm_status outcome =
            sm_slow_flow_try(&c->flow, &c->inputs, elapsed, tried, &end, c->tolerance,
                             &c->instant, y, dy, y_new, dy_new, &error);
        if (outcome == SM_OK && !isfinite(error)) outcome = SM_NOT_FINITE;
        if (outcome != SM_OK || error > 1.0) {
            /* a stage beyond the table, or an overflow: come closer to it, then say so */
            h = tried * (outcome != SM_OK ? 0.25 : fmax(0.2, 0.9 * pow(error, -0.2)));
            c->rejected++;
            if (h < 1e-13 * (duration + 1.0 / c->inputs.frequency[0]))
                return outcome != SM_OK ? outcome : SM_STEP_TOO_SMALL;
            continue;
        }
        c->accepted++;
        if (c->motion.wanted)
            status = march_segment(c, elapsed, tried, marched_from, y, dy, y_new, dy_new);
        memcpy(y, y_new, sizeof y_new);
        memcpy(dy, dy_new, sizeof dy_new);
        elapsed = last ? duration : elapsed + tried;
        const double grown = tried * (error > 1e-4 ? fmin(5.0, 0.9 * pow(error, -0.2)) : 5.0);
        h = last && grown < h ? h : grown; /* a step cut short by the call says little */
    }
    *step = h;
    return status;
}

/* The slow state `duration` later, as far as time and inputs tell. */
static slow_state later(const sm_component *c, double duration) {
    slow_state fresh = c->slow;
    sm_add(&fresh.time, duration);
    for (int j = 0; j < c->flow.table.modes; j++) {
        const double rate = c->inputs.frequency_rate[j];
        sm_add_angle(&fresh.angle[j], duration * (c->inputs.frequency[j] + 0.5 * rate * duration));
    }
    return fresh;
}

sm_status sm_component_step(sm_component *c, double duration) {
    if (!c) return SM_BAD_ARGUMENT;
    sm_status status = sm_check_positive(duration);
    if (status != SM_OK) return status;
    sm_inputs after = sm_inputs_after(&c->inputs, c->flow.table.modes, duration);
    status = sm_inputs_check(&after, c->flow.table.modes);
    if (status != SM_OK) return status;
    slow_state fresh = later(c, duration);
    for (int j = 0; j < SM_MODES; j++) after.angle[j] = fresh.angle[j].value;
    const size_t n = (size_t)c->contact.contacts;
    double y[SM_UNKNOWNS] = {0.0}, dy[SM_UNKNOWNS];
    memcpy(y, c->slow.amplitude, sizeof c->slow.amplitude);
    if (c->motion.wanted) sm_march_start(&c->march, c->contact_state, c->contact_state + n, c->contact_state + 2 * n);
    status = integrate(c, duration, &after, y, dy, &fresh.step);
    if (status != SM_OK) return status;
    memcpy(fresh.amplitude, y, sizeof fresh.amplitude);
    sm_add(&fresh.energy, y[SM_DISSIPATED]);
    if (!sm_all_finite((const double *)(const void *)&fresh, SLOW_STATE_COUNT) ||
        !sm_all_finite(dy, SM_UNKNOWNS))
        return SM_NOT_FINITE;

    c->slow = fresh;
    c->inputs = after;
    memcpy(c->rate, dy, sizeof c->rate);
    c->rate_known = 1;
    if (c->motion.wanted) {
        memcpy(c->contact_state, c->march.lane.x, n * sizeof(double));
        memcpy(c->contact_state + n, c->march.lane.v, n * sizeof(double));
        memcpy(c->contact_state + 2 * n, c->march.force, n * sizeof(double));
    }
    return SM_OK;
}

size_t sm_component_output_count(const sm_component *c) {
    if (!c) return 0;
    return SM_OUTPUTS_FIXED + (c->motion.wanted ? 3 * (size_t)c->contact.contacts
                                                      + (size_t)c->motion.elastic
                                                : 0);
}

sm_status sm_component_outputs(const sm_component *c, double *outputs) {
    if (!c || !outputs) return SM_BAD_ARGUMENT;
    double computed[SM_UNKNOWNS];
    const double *rate = c->rate_known ? c->rate : computed;
    const sm_status status =
        c->rate_known ? SM_OK : rate_at(c, &c->inputs, c->slow.amplitude, computed);
    if (status != SM_OK) return status;
    if (!sm_all_finite(rate, SM_UNKNOWNS)) return SM_NOT_FINITE;
    outputs[0] = c->slow.time.value;
    memcpy(outputs + 1, c->slow.amplitude, sizeof c->slow.amplitude);
    outputs[5] = c->slow.angle[0].value;
    outputs[6] = c->slow.angle[1].value;
    outputs[7] = rate[SM_PUT_IN];
    outputs[8] = rate[SM_DISSIPATED];
    outputs[9] = c->slow.energy.value;
    if (!c->motion.wanted) return SM_OK;
    const size_t n = (size_t)c->contact.contacts, modes = (size_t)c->flow.table.modes;
    memcpy(outputs + SM_OUTPUTS_FIXED, c->contact_state, 3 * n * sizeof(double));
    double q[SM_MODES] = {0.0};
    for (size_t j = 0; j < modes; j++) {
        const double angle = c->slow.angle[j].value;
        q[j] = 2.0 * (c->slow.amplitude[2 * j] * cos(angle)
                      - c->slow.amplitude[2 * j + 1] * sin(angle));
    }
    double *x = outputs + SM_OUTPUTS_FIXED + 3 * n;
    for (size_t k = 0; k < (size_t)c->motion.elastic; k++) {
        x[k] = 0.0;
        for (size_t j = 0; j < modes; j++) x[k] += c->motion.modes_out[k * modes + j] * q[j];
        for (size_t i = 0; i < n; i++)
            x[k] += c->motion.contacts_out[k * n + i] * c->contact_state[i];
    }
    return SM_OK;
}

sm_status sm_component_run(sm_component *c, size_t steps, const double *durations,
                           const sm_inputs *inputs, double *outputs, size_t *done) {
    if (!c || !durations || !inputs || !outputs || !done) return SM_BAD_ARGUMENT;
    const size_t width = sm_component_output_count(c);
    for (*done = 0; *done < steps; ++*done) {
        sm_status status = sm_component_set_inputs(c, &inputs[*done]);
        if (status == SM_OK) status = sm_component_step(c, durations[*done]);
        if (status == SM_OK) status = sm_component_outputs(c, outputs + *done * width);
        if (status != SM_OK) return status;
    }
    return SM_OK;
}

size_t sm_component_state_count(const sm_component *c) {
    return c ? SLOW_STATE_COUNT + INPUTS_COUNT + 3 * (size_t)c->contact.contacts : 0;
}

sm_status sm_component_get_state(const sm_component *c, double *state) {
    if (!c || !state) return SM_BAD_ARGUMENT;
    memcpy(state, &c->slow, sizeof c->slow);
    memcpy(state + SLOW_STATE_COUNT, &c->inputs, sizeof c->inputs);
    memcpy(state + SLOW_STATE_COUNT + INPUTS_COUNT, c->contact_state,
           3 * (size_t)c->contact.contacts * sizeof(double));
    return SM_OK;
}

sm_status sm_component_set_state(sm_component *c, const double *state) {
    if (!c || !state) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(state, sm_component_state_count(c))) return SM_NOT_FINITE;
    slow_state slow;
    sm_inputs inputs;
    memcpy(&slow, state, sizeof slow);
    memcpy(&inputs, state + SLOW_STATE_COUNT, sizeof inputs);
    sm_status status = check_inputs(c, &inputs);
    double rate[SM_UNKNOWNS];
    if (status == SM_OK) status = rate_at(c, &inputs, slow.amplitude, rate);
    if (status != SM_OK) return status;
    c->slow = slow;
    c->inputs = inputs;
    c->rate_known = 0;
    memcpy(c->contact_state, state + SLOW_STATE_COUNT + INPUTS_COUNT,
           3 * (size_t)c->contact.contacts * sizeof(double));
    return SM_OK;
}

void sm_component_work(const sm_component *c, uint64_t *accepted, uint64_t *rejected) {
    if (accepted) *accepted = c ? c->accepted : 0;
    if (rejected) *rejected = c ? c->rejected : 0;
}

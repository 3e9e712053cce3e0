/* The step-able component: inputs held or ramped over a step, slow flow, contact motion at the
 * communication point. It owns copies of everything it needs, in one block of memory. */
#include <stdlib.h>

#include "motion.h"
#include "slow_flow.h"

#define TWO_PI 6.283185307179586
#define TWO_PI_LOW 2.4492935982947064e-16 /* 2 pi - TWO_PI */

/* A sum that keeps what rounding would lose, so that many steps do not drift. */
typedef struct {
    double value, carry;
} exact_sum;

typedef struct {
    exact_sum time;            /* [s] */
    exact_sum energy;          /* dissipated at the contacts [J] */
    exact_sum angle[SM_MODES]; /* theta_j in [0, 2 pi) [rad] */
    double amplitude[2 * SM_MODES];
    double step;               /* next internal step, 0: not chosen yet [s] */
} slow_state;

#define SLOW_STATE_COUNT (sizeof(slow_state) / sizeof(double))

struct sm_component {
    sm_slow_flow flow;
    sm_contact contact;
    sm_motion motion;
    double tolerance;
    sm_inputs inputs;
    slow_state slow;
    double *contact_state;  /* x_c, v_c, f_c at the communication point, 3 N_c */
    sm_march march;
    uint64_t accepted, rejected;
};

static void add(exact_sum *sum, double term) {
    const double total = sum->value + term;
    const double lost = fabs(sum->value) >= fabs(term) ? (sum->value - total) + term
                                                       : (term - total) + sum->value;
    sum->value = total;
    sum->carry += lost;
    const double settled = sum->value + sum->carry;
    sum->carry -= settled - sum->value;
    sum->value = settled;
}

static void add_angle(exact_sum *angle, double term) {
    add(angle, term);
    const double turns = floor(angle->value / TWO_PI);
    if (turns != 0.0) {
        add(angle, -turns * TWO_PI);
        add(angle, -turns * TWO_PI_LOW);
    }
}

static int motion_is_valid(const sm_motion *motion) {
    if (!motion->wanted) return 1;
    if (motion->elastic < 0 || motion->elastic > 1000000) return 0;
    if (motion->elastic > 0 && (!motion->modes_out || !motion->contacts_out)) return 0;
    return motion->steps_per_period >= 4 && motion->steps_per_period <= 65536 &&
           motion->memory_periods >= 0.0 && isfinite(motion->memory_periods);
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
    if (!flow || !motion || !component || !(tolerance > 0.0 && tolerance < 1.0))
        return SM_BAD_ARGUMENT;
    sm_status status = sm_table_check(&flow->table);
    if (status == SM_OK) status = sm_contact_check(contact);
    if (status != SM_OK) return status;
    if (contact->modes != flow->table.modes || !motion_is_valid(motion)) return SM_BAD_ARGUMENT;
    const size_t modes = (size_t)flow->table.modes;
    for (size_t j = 0; j < modes; j++)
        if (!(flow->natural[j] > 0.0 && isfinite(flow->natural[j])) ||
            !(flow->damping[j] >= 0.0 && isfinite(flow->damping[j])))
            return SM_BAD_ARGUMENT;

    const size_t n = (size_t)contact->contacts;
    const size_t count_a = (size_t)flow->table.count_a;
    const size_t count_b = modes == 2 ? (size_t)flow->table.count_b : 0;
    const size_t values = count_a * (modes == 2 ? count_b : 1) * 8 * modes;
    const size_t elastic = motion->wanted ? (size_t)motion->elastic : 0;
    const size_t total = count_a + count_b + values + n + 2 * n * n + 2 * modes * n
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
    c->contact.limit = keep(&memory, contact->limit, n);
    c->contact.stiffness = keep(&memory, contact->stiffness, n * n);
    c->contact.damping = keep(&memory, contact->damping, n * n);
    c->contact.coupling = keep(&memory, contact->coupling, 2 * modes * n);
    if (elastic > 0) {
        c->motion.modes_out = keep(&memory, motion->modes_out, elastic * modes);
        c->motion.contacts_out = keep(&memory, motion->contacts_out, elastic * n);
    }
    for (size_t j = 0; j < modes; j++) c->inputs.frequency[j] = flow->natural[j];
    *component = c;
    return SM_OK;
}

void sm_component_free(sm_component *component) { free(component); }

sm_status sm_component_reset(sm_component *c, double time, const double *amplitude) {
    if (!c || !amplitude || !isfinite(time)) return SM_BAD_ARGUMENT;
    const slow_state zero = {.step = 0.0};
    slow_state fresh = zero;
    double modulus[SM_MODES], s[2 * SM_MODES];
    for (int j = 0; j < c->flow.table.modes; j++) {
        fresh.amplitude[2 * j] = amplitude[2 * j];
        fresh.amplitude[2 * j + 1] = amplitude[2 * j + 1];
        modulus[j] = hypot(amplitude[2 * j], amplitude[2 * j + 1]);
    }
    const sm_status status = sm_table_lookup(&c->flow.table, modulus, s);
    if (status != SM_OK) return status;
    fresh.time.value = time;
    c->slow = fresh;
    memset(c->contact_state, 0, 3 * (size_t)c->contact.contacts * sizeof(double));
    return SM_OK;
}

sm_status sm_component_set_inputs(sm_component *c, const sm_inputs *inputs) {
    if (!c || !inputs) return SM_BAD_ARGUMENT;
    for (int j = 0; j < c->flow.table.modes; j++) {
        if (!isfinite(inputs->force[j]) || !isfinite(inputs->force_rate[j]) ||
            !isfinite(inputs->frequency[j]) || !isfinite(inputs->frequency_rate[j]) ||
            !isfinite(inputs->phase[j]))
            return SM_NOT_FINITE;
        if (!(inputs->frequency[j] > 0.0)) return SM_BAD_ARGUMENT;
    }
    c->inputs = *inputs;
    return SM_OK;
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
    return sm_march_along(&c->march, &c->contact, &g, start, h, c->motion.steps_per_period);
}

/* Seconds of a step of `duration` that pass before the contacts need marching. */
static double motion_starts(const sm_component *c, double duration) {
    double slowest = INFINITY;
    for (int j = 0; j < c->flow.table.modes; j++)
        slowest = fmin(slowest, c->inputs.frequency[j]);
    const double memory = c->motion.memory_periods * TWO_PI / slowest;
    return duration > memory ? duration - memory : 0.0;
}

/* Integrates the slow flow over [0, duration]; y, step and the march are advanced. */
static sm_status integrate(sm_component *c, double duration, double *y, double *step) {
    const double marched_from = c->motion.wanted ? motion_starts(c, duration) : 0.0;
    double dy[SM_UNKNOWNS], y_new[SM_UNKNOWNS], dy_new[SM_UNKNOWNS], error;
    sm_status status = sm_slow_flow_derivative(&c->flow, &c->inputs, 0.0, y, dy);
    double elapsed = 0.0, h = *step > 0.0 ? *step : duration;
    while (status == SM_OK && elapsed < duration) {
        const double left = duration - elapsed;
        const int last = h >= left * (1.0 - 1e-12);
        const double tried = last ? left : h;
        const sm_status outcome =
            sm_slow_flow_try(&c->flow, &c->inputs, elapsed, tried, c->tolerance, y, dy, y_new,
                             dy_new, &error);
        if (outcome == SM_NOT_FINITE || (outcome == SM_OK && !isfinite(error)))
            return SM_NOT_FINITE;
        if (outcome != SM_OK || error > 1.0) {
            /* a stage beyond the table: come closer to its edge, then say so */
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
        const double grown = tried * (error > 0.0 ? fmin(5.0, 0.9 * pow(error, -0.2)) : 5.0);
        h = last && grown < h ? h : grown; /* a step cut short by the call says little */
    }
    *step = h;
    return status;
}

sm_status sm_component_step(sm_component *c, double duration) {
    if (!c || !(duration > 0.0) || !isfinite(duration)) return SM_BAD_ARGUMENT;
    for (int j = 0; j < c->flow.table.modes; j++)
        if (!(c->inputs.frequency[j] + c->inputs.frequency_rate[j] * duration > 0.0))
            return SM_BAD_ARGUMENT;
    const size_t n = (size_t)c->contact.contacts;
    double y[SM_UNKNOWNS] = {0.0}, step = c->slow.step;
    memcpy(y, c->slow.amplitude, sizeof c->slow.amplitude);
    if (c->motion.wanted) sm_march_start(&c->march, c->contact_state, c->contact_state + n);
    const sm_status status = integrate(c, duration, y, &step);
    if (status != SM_OK) return status;

    for (int k = 0; k < 2 * SM_MODES; k++)
        c->slow.amplitude[k] = fabs(y[k]) < 1e-200 ? 0.0 : y[k]; /* denormals would slow us down */
    c->slow.step = step;
    add(&c->slow.time, duration);
    add(&c->slow.energy, y[2 * SM_MODES]);
    for (int j = 0; j < c->flow.table.modes; j++) {
        const double rate = c->inputs.frequency_rate[j];
        add_angle(&c->slow.angle[j], duration * (c->inputs.frequency[j] + 0.5 * rate * duration));
        c->inputs.force[j] += c->inputs.force_rate[j] * duration;
        c->inputs.frequency[j] += rate * duration;
    }
    if (c->motion.wanted) {
        memcpy(c->contact_state, c->march.lane.x, n * sizeof(double));
        memcpy(c->contact_state + n, c->march.lane.v, n * sizeof(double));
        sm_march_force(&c->march, c->contact_state + 2 * n);
    }
    return SM_OK;
}

size_t sm_component_output_count(const sm_component *c) {
    return SM_OUTPUTS_FIXED + (c->motion.wanted ? 3 * (size_t)c->contact.contacts
                                                      + (size_t)c->motion.elastic
                                                : 0);
}

sm_status sm_component_outputs(const sm_component *c, double *outputs) {
    if (!c || !outputs) return SM_BAD_ARGUMENT;
    double rate[2 * SM_MODES], input_power, friction_power;
    const sm_status status = sm_slow_flow_rate(&c->flow, &c->inputs, 0.0, c->slow.amplitude, rate,
                                               &input_power, &friction_power);
    if (status != SM_OK) return status;
    outputs[0] = c->slow.time.value;
    memcpy(outputs + 1, c->slow.amplitude, sizeof c->slow.amplitude);
    outputs[5] = c->slow.angle[0].value;
    outputs[6] = c->slow.angle[1].value;
    outputs[7] = input_power;
    outputs[8] = friction_power;
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
    return SLOW_STATE_COUNT + sizeof(sm_inputs) / sizeof(double)
           + 3 * (size_t)c->contact.contacts;
}

sm_status sm_component_get_state(const sm_component *c, double *state) {
    if (!c || !state) return SM_BAD_ARGUMENT;
    memcpy(state, &c->slow, sizeof c->slow);
    memcpy(state + SLOW_STATE_COUNT, &c->inputs, sizeof c->inputs);
    memcpy(state + SLOW_STATE_COUNT + sizeof c->inputs / sizeof(double), c->contact_state,
           3 * (size_t)c->contact.contacts * sizeof(double));
    return SM_OK;
}

sm_status sm_component_set_state(sm_component *c, const double *state) {
    if (!c || !state) return SM_BAD_ARGUMENT;
    const size_t count = sm_component_state_count(c);
    for (size_t k = 0; k < count; k++)
        if (!isfinite(state[k])) return SM_NOT_FINITE;
    memcpy(&c->slow, state, sizeof c->slow);
    memcpy(&c->inputs, state + SLOW_STATE_COUNT, sizeof c->inputs);
    memcpy(c->contact_state, state + SLOW_STATE_COUNT + sizeof c->inputs / sizeof(double),
           3 * (size_t)c->contact.contacts * sizeof(double));
    return SM_OK;
}

void sm_component_work(const sm_component *c, uint64_t *accepted, uint64_t *rejected) {
    *accepted = c->accepted;
    *rejected = c->rejected;
}

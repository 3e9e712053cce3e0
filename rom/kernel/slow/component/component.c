/* The component: slow flow, eqs. (18), (19), and contact motion, eq. (12), under inputs that
 * change linearly over a step. A step adds free vibrations where forces are discontinuous
 * (discontinuity.c) and integrates the amplitude equations (dopri5.c) with step size control.
 * The contact motion (contact_output.c) is integrated when it is read. Python, the FMU and the
 * explorer call it. */
#include <stdlib.h>

#include "base/check.h"
#include "slow/component/contact_output.h"
#include "base/exact_sum.h"
#include "slow/discontinuity.h"
#include "slow/slow_flow.h"
#include "table/table.h"

/* The slow state, as doubles in the state of the component. */
typedef struct {
    sm_exact_sum time;            /* [s] */
    sm_exact_sum energy;          /* dissipated at the contacts [J] */
    sm_exact_sum angle[SM_MODES]; /* theta_j in [0, 2 pi) [rad] */
    double amplitude[2 * SM_MODES]; /* a_j [kg^1/2 m] */
    double step;                  /* next internal step, 0: not chosen yet [s] */
    sm_held_force last_force;     /* up to the present time */
} slow_state;

#define SLOW_STATE_COUNT (sizeof(slow_state) / sizeof(double))
#define MAX_TRIES 200000 /* internal steps of one call: very fast inputs would need far more */
#define STEP_ROUNDING 1e-12 /* relative difference of a step and the remaining time, by rounding */
/* Index of the contacts in the state of a component, after the slow state and the inputs. */
#define CONTACTS_FROM (SLOW_STATE_COUNT + sizeof(sm_inputs) / sizeof(double))

struct sm_component {
    sm_slow_flow flow;
    sm_contact_output contacts;
    double tolerance;
    sm_inputs inputs;
    slow_state slow;
    uint64_t accepted, rejected;
    int rate_known; /* 1: `rate` is the derivative of the unknowns at present */
    double rate[SM_UNKNOWNS];
    sm_instant instant;
};

sm_status sm_component_check(const sm_slow_flow *flow, const sm_contact *contact,
                             const sm_motion *motion) {
    if (!flow || !motion) return SM_BAD_ARGUMENT;
    sm_status status = sm_table_check(&flow->table);
    if (status == SM_OK) status = sm_slow_flow_check(flow);
    if (status == SM_OK) status = sm_contact_check(contact);
    if (status != SM_OK) return status;
    if (contact->modes != flow->table.modes) return SM_BAD_ARGUMENT;
    return sm_motion_check(motion, contact, &flow->table);
}

sm_status sm_component_checked_create(const sm_slow_flow *flow, const sm_contact *contact,
                                      const sm_motion *motion, double tolerance,
                                      sm_component **component) {
    if (!flow || !contact || !motion || !component) return SM_BAD_ARGUMENT;
    sm_status status = sm_slow_flow_check(flow);
    if (status == SM_OK) status = sm_check_positive(tolerance);
    if (status != SM_OK) return status;
    if (tolerance >= 1.0) return SM_BAD_ARGUMENT;
    const size_t header = sm_whole_lines(sm_doubles(sizeof(sm_component)));
    sm_block block = {NULL, 0};
    sm_component counted, *c = &counted;
    for (int counts = 1; counts >= 0; counts--) {
        if (!counts && !sm_allocate(&block)) return SM_NO_MEMORY;
        double *own = sm_take(&block, header);
        if (!counts) c = (void *)own;
        c->flow = *flow;
        sm_contact_output_place(&c->contacts, motion, contact, &block);
    }
    c->tolerance = tolerance;
    c->inputs.limit_scale = 1.0;
    for (int j = 0; j < contact->modes; j++) c->inputs.frequency[j] = flow->natural[j];
    *component = c;
    return SM_OK;
}

sm_status sm_component_create(const sm_slow_flow *flow, const sm_contact *contact,
                              const sm_motion *motion, double tolerance,
                              sm_component **component) {
    if (!component) return SM_BAD_ARGUMENT;
    const sm_status status = sm_component_check(flow, contact, motion);
    return status == SM_OK
               ? sm_component_checked_create(flow, contact, motion, tolerance, component)
               : status;
}

void sm_component_free(sm_component *component) { free(component); }

/* Copies the angles of the state, which are exact sums, to the inputs for the combination
 * resonances. */
static void align_angles(sm_component *c) {
    for (int j = 0; j < SM_MODES; j++) c->inputs.angle[j] = c->slow.angle[j].value;
}

/* Computes the derivative of the unknowns; returns SM_OK for finite amplitudes inside the table. */
static sm_status rate_at(const sm_component *c, const sm_inputs *inputs, const double *amplitude,
                         double *rate) {
    sm_instant instant = {.known = 0};
    if (!sm_all_finite(amplitude, 2 * (size_t)c->flow.table.modes)) return SM_NOT_FINITE;
    sm_instant_set(&instant, &c->flow, inputs);
    return sm_slow_flow_derivative(&c->flow, &instant, amplitude, rate);
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
    c->rate_known = 0; /* the angles have changed */
    sm_contact_output_reset(&c->contacts);
    return SM_OK;
}

sm_status sm_component_set_amplitude(sm_component *c, const double *amplitude) {
    if (!c || !amplitude) return SM_BAD_ARGUMENT;
    double rate[SM_UNKNOWNS];
    const sm_status status = rate_at(c, &c->inputs, amplitude, rate);
    if (status != SM_OK) return status;
    memcpy(c->slow.amplitude, amplitude, 2 * (size_t)c->flow.table.modes * sizeof(double));
    c->slow.step = 0.0;
    c->rate_known = 0;
    return SM_OK;
}

/* Checks the inputs; the limits can be scaled if friction is homogeneous. */
static sm_status check_inputs(const sm_component *c, const sm_inputs *inputs) {
    const sm_status status = sm_inputs_check(inputs, c->flow.table.modes);
    const int scaled = inputs->limit_scale != 1.0 || inputs->limit_scale_rate != 0.0;
    if (status != SM_OK || !scaled) return status;
    const sm_contact *contact = &c->contacts.contact;
    const int scales = contact->law == SM_ELASTIC ? sm_elastic_homogeneous(contact->elastic)
                                                  : contact->law == SM_COULOMB;
    return scales ? SM_OK : SM_BAD_ARGUMENT;
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

/* Factor of the first internal step [-]: from rest a = rate h at first, so that the relative error
 * of a step is of the order of (h |stiffness / mass|)^4. The tolerance is met with factors up to
 * 5. */
#define FIRST_STEP 4.0

/* Step size control of a method of fifth order: h_new = h SAFETY error^(-1/5), within limits. */
#define SAFETY 0.9
#define MIN_FACTOR 0.2
#define MAX_FACTOR 5.0
#define MAX_FACTOR_ERROR 1e-4 /* below it the factor is MAX_FACTOR: (0.9 / 5)^5 = 1.9e-4 */
#define FAILED_FACTOR 0.25    /* after a stage outside the table or an overflow */
/* Smallest step relative to the duration plus a radian of mode A [-]: of the order of rounding. */
#define SMALLEST_STEP 1e-13

/* Returns the first internal step at the present inputs [s], to which the instant is set. */
static double first_step(sm_component *c) {
    double fastest = 0.0;
    sm_instant_set(&c->instant, &c->flow, &c->inputs);
    for (int j = 0; j < c->flow.table.modes; j++)
        fastest = fmax(fastest, sm_cabs2(c->instant.spring[j]));
    return FIRST_STEP * sqrt(sqrt(c->tolerance) / fastest);
}

/* Integrates the slow flow from `now` over [0, duration], to the inputs `after`, in at most `most`
 * internal steps, accepted or not. `next_step` is the first internal step, 0 if it is to be chosen,
 * and becomes the step to continue with. */
static sm_status integrate(sm_component *c, double duration, int64_t most, const sm_inputs *after,
                           sm_flow_point *now, double *next_step) {
    sm_inputs begin = c->inputs;
    sm_instant_set(&c->instant, &c->flow, &c->inputs);
    sm_status status = SM_OK;
    if (c->rate_known)
        memcpy(now->dy, c->rate, sizeof now->dy);
    else
        status = sm_slow_flow_derivative(&c->flow, &c->instant, now->y, now->dy);
    double elapsed = 0.0, h = *next_step > 0.0 ? *next_step : fmin(duration, first_step(c));
    for (int64_t tries = 0; status == SM_OK && elapsed < duration;) {
        if (++tries > most) return SM_STEP_TOO_SMALL;
        const double left = duration - elapsed;
        const int last = h >= left * (1.0 - STEP_ROUNDING);
        sm_time_step step = {&c->flow, &c->inputs, *after, elapsed, last ? left : h, c->tolerance};
        if (!last) step.end = sm_inputs_after(&c->inputs, c->flow.table.modes, elapsed + step.h);
        sm_flow_point next;
        double error;
        sm_status outcome = sm_dopri5(&step, &c->instant, now, &next, &error);
        if (outcome == SM_OK && !isfinite(error)) outcome = SM_NOT_FINITE;
        if (outcome != SM_OK || error > 1.0) {
            /* after a stage outside the table, or an overflow: approach this time, then return the
             * status */
            h = step.h * (outcome != SM_OK ? FAILED_FACTOR
                                           : fmax(MIN_FACTOR, SAFETY * pow(error, -0.2)));
            c->rejected++;
            if (h < SMALLEST_STEP * (duration + 1.0 / c->inputs.frequency[0]))
                return outcome != SM_OK ? outcome : SM_STEP_TOO_SMALL;
            continue;
        }
        c->accepted++;
        if (c->contacts.motion.wanted)
            status = sm_contact_output_add(&c->contacts, &step, &begin, now, &next);
        begin = step.end;
        *now = next;
        elapsed = last ? duration : elapsed + step.h;
        const double factor = error > MAX_FACTOR_ERROR
                                  ? fmin(MAX_FACTOR, SAFETY * pow(error, -0.2)) : MAX_FACTOR;
        /* the last step may be short, and its error says little about longer ones */
        h = last && step.h * factor < h ? h : step.h * factor;
    }
    *next_step = h;
    return status;
}

/* Returns the slow state with time and angles `duration` later, and present amplitudes and
 * energy. */
static slow_state state_after(const sm_component *c, double duration) {
    slow_state fresh = c->slow;
    sm_add(&fresh.time, duration);
    for (int j = 0; j < c->flow.table.modes; j++) {
        const double rate = c->inputs.frequency_rate[j];
        sm_add_angle(&fresh.angle[j], duration * (c->inputs.frequency[j] + 0.5 * rate * duration));
    }
    return fresh;
}

/* Relative distance from the edge of the table, for rounding [-]. */
#define EDGE_ROUNDING 1e-12

/* Limits amplitudes to the edge of the table after a change of force, so that any force can be
 * followed by a smaller one. The error is at most the change of the amplitude, which relative to
 * the amplitude is about the damping ratio. */
static void limit_to_table(const sm_component *c, double *amplitude) {
    const sm_table *table = &c->flow.table;
    for (int j = 0; j < table->modes; j++) {
        const double *before = c->slow.amplitude + 2 * j, *node = j ? table->node_b : table->node_a;
        const double last = node[(j ? table->count_b : table->count_a) - 1];
        const double end = (1.0 - EDGE_ROUNDING) * last * c->inputs.limit_scale;
        const double size = hypot(amplitude[2 * j], amplitude[2 * j + 1]);
        if (size <= end || hypot(before[0], before[1]) > last * c->inputs.limit_scale) continue;
        amplitude[2 * j] *= end / size;
        amplitude[2 * j + 1] *= end / size;
    }
}

/* Advances by `duration` in at most `most` internal steps. On failure only the queue of the
 * contacts has changed. */
static sm_status try_advance(sm_component *c, double duration, int64_t most) {
    sm_inputs after = sm_inputs_after(&c->inputs, c->flow.table.modes, duration);
    sm_status status = sm_inputs_check(&after, c->flow.table.modes);
    if (status != SM_OK) return status;
    slow_state fresh = state_after(c, duration);
    for (int j = 0; j < SM_MODES; j++) after.angle[j] = fresh.angle[j].value;
    sm_flow_point now = {.y = {0.0}};
    memcpy(now.y, c->slow.amplitude, sizeof c->slow.amplitude);
    if (sm_force_discontinuity(&c->flow, &c->slow.last_force, &c->inputs, now.y)) {
        limit_to_table(c, now.y);
        c->rate_known = 0;
    }
    status = integrate(c, duration, most, &after, &now, &fresh.step);
    if (status != SM_OK) return status;
    memcpy(fresh.amplitude, now.y, sizeof fresh.amplitude);
    fresh.last_force = sm_hold_force(&after);
    sm_add(&fresh.energy, now.y[SM_DISSIPATED]);
    if (!sm_all_finite((const double *)(const void *)&fresh, SLOW_STATE_COUNT) ||
        !sm_all_finite(now.dy, SM_UNKNOWNS))
        return SM_NOT_FINITE;
    c->slow = fresh;
    c->inputs = after;
    memcpy(c->rate, now.dy, sizeof c->rate);
    c->rate_known = 1;
    return SM_OK;
}

/* Advances by `duration` in at most `most` internal steps. On failure nothing has changed. */
static sm_status advance(sm_component *c, double duration, int64_t most) {
    sm_status status = sm_check_positive(duration);
    if (status != SM_OK || !c->contacts.motion.wanted)
        return status == SM_OK ? try_advance(c, duration, most) : status;
    sm_contact_output_begin(&c->contacts);
    status = try_advance(c, duration, most);
    if (status != SM_OK) sm_contact_output_abandon(&c->contacts);
    return status;
}

sm_status sm_component_step(sm_component *c, double duration) {
    return c ? advance(c, duration, MAX_TRIES) : SM_BAD_ARGUMENT;
}

size_t sm_component_output_count(const sm_component *c) {
    if (!c) return 0;
    const sm_motion *motion = &c->contacts.motion;
    const size_t moving = 3 * (size_t)c->contacts.contact.contacts + (size_t)motion->elastic;
    return SM_OUTPUTS_FIXED + (motion->wanted ? moving : 0);
}

sm_status sm_component_slow_outputs(const sm_component *c, double *outputs) {
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
    return SM_OK;
}

sm_status sm_component_motion(sm_component *c, int elastic, double *motion) {
    if (!c || !motion || !c->contacts.motion.wanted) return SM_BAD_ARGUMENT;
    return sm_contact_output_read(&c->contacts, &c->flow, &c->inputs, c->slow.amplitude, elastic,
                                  motion);
}

sm_status sm_component_outputs(sm_component *c, double *outputs) {
    const sm_status status = sm_component_slow_outputs(c, outputs);
    if (status != SM_OK || !c->contacts.motion.wanted) return status;
    return sm_component_motion(c, 1, outputs + SM_OUTPUTS_FIXED);
}

sm_status sm_component_recent_motion(sm_component *c, const sm_inputs *inputs,
                                     const double *amplitude, const double *rate, int smooth,
                                     double *motion) {
    if (!c || !inputs || !amplitude || !rate || !motion) return SM_BAD_ARGUMENT;
    if (!c->contacts.motion.wanted) return SM_BAD_ARGUMENT;
    const size_t count = 2 * (size_t)c->flow.table.modes;
    if (!sm_all_finite(amplitude, count) || !sm_all_finite(rate, count)) return SM_NOT_FINITE;
    const sm_status status = check_inputs(c, inputs);
    if (status != SM_OK) return status;
    const sm_detail detail = smooth ? SM_UNHALVED : SM_TO_BE_READ;
    const sm_slow_point at = {amplitude, inputs};
    return sm_contact_output_recent(&c->contacts, &c->flow, &at, rate, detail, motion);
}

/* Writes the outputs after a step. If the motion cannot be computed, its outputs are NaN. */
static sm_status read_row(sm_component *c, double *row) {
    const sm_status status = sm_component_outputs(c, row);
    if (status == SM_OK) return status;
    for (size_t k = 0; k < sm_component_output_count(c); k++) row[k] = NAN;
    (void)sm_component_slow_outputs(c, row);
    return status;
}

sm_status sm_component_run(sm_component *c, size_t steps, const double *durations,
                           const sm_inputs *inputs, double *outputs, size_t *done) {
    if (!c || !durations || !inputs || !outputs || !done) return SM_BAD_ARGUMENT;
    const size_t width = sm_component_output_count(c);
    sm_status status = SM_OK;
    for (*done = 0; status == SM_OK && *done < steps;) {
        status = sm_component_set_inputs(c, &inputs[*done]);
        if (status == SM_OK) status = sm_component_step(c, durations[*done]);
        if (status != SM_OK) return status;
        status = read_row(c, outputs + *done * width);
        ++*done;
    }
    return status;
}

/* Shortest single internal step [rad] of mode A: shorter ones are made several at a time. */
#define SHORTEST_ADVANCE 1e-3

sm_status sm_component_advance(sm_component *c, double left, double *taken) {
    if (!c || !taken) return SM_BAD_ARGUMENT;
    const double least = SHORTEST_ADVANCE / c->inputs.frequency[0];
    sm_status status = sm_check_positive(left);
    if (status != SM_OK) return status;
    const double step = c->slow.step;
    for (double h = step > 0.0 ? step : first_step(c); h > least; h = c->slow.step) {
        *taken = h < left * (1.0 - STEP_ROUNDING) ? h : left;
        if (advance(c, *taken, 1) == SM_OK) return SM_OK;
        c->slow.step = FAILED_FACTOR * *taken; /* the error was too large, or a stage failed */
    }
    *taken = fmin(least, left);
    status = advance(c, *taken, MAX_TRIES);
    if (status != SM_OK) c->slow.step = step;
    return status;
}

sm_status sm_component_trace(sm_component *c, size_t steps, const double *durations,
                             const sm_inputs *inputs, sm_trace *t) {
    if (!c || !durations || !inputs || !t || !t->outputs) return SM_BAD_ARGUMENT;
    const size_t width = sm_component_output_count(c);
    sm_status status = SM_OK;
    for (t->count = 0; status == SM_OK && t->count < t->capacity && t->done < steps; t->count++) {
        const double left = durations[t->done] - t->elapsed;
        double taken;
        if (t->elapsed == 0.0) status = sm_component_set_inputs(c, &inputs[t->done]);
        if (status == SM_OK) status = sm_component_advance(c, left, &taken);
        if (status != SM_OK) return status;
        status = read_row(c, t->outputs + t->count * width);
        t->elapsed += taken;
        if (taken == left) {
            t->done++;
            t->elapsed = 0.0;
        }
    }
    return status;
}

size_t sm_component_state_count(const sm_component *c) {
    return c ? CONTACTS_FROM + sm_contact_output_state_count(&c->contacts) : 0;
}

sm_status sm_component_get_state(const sm_component *c, double *state) {
    if (!c || !state) return SM_BAD_ARGUMENT;
    memcpy(state, &c->slow, sizeof c->slow);
    memcpy(state + SLOW_STATE_COUNT, &c->inputs, sizeof c->inputs);
    sm_contact_output_get_state(&c->contacts, state + CONTACTS_FROM);
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
    if (status == SM_OK)
        status = sm_contact_output_check_state(&c->contacts, state + CONTACTS_FROM);
    double rate[SM_UNKNOWNS];
    if (status == SM_OK) status = rate_at(c, &inputs, slow.amplitude, rate);
    if (status != SM_OK) return status;
    c->slow = slow;
    c->inputs = inputs;
    c->rate_known = 0;
    sm_contact_output_set_state(&c->contacts, state + CONTACTS_FROM);
    return SM_OK;
}

void sm_component_work(const sm_component *c, uint64_t *accepted, uint64_t *rejected) {
    if (accepted) *accepted = c ? c->accepted : 0;
    if (rejected) *rejected = c ? c->rejected : 0;
}

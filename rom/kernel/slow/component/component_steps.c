/* Steps of a component. A step adds free vibrations where forces are discontinuous
 * (discontinuity.c) and integrates the amplitude equations (dopri5.c) with step size control. Each
 * internal step goes to the queue of the contact motion (contact_output.c). Python, the FMU and the
 * explorer call it. */
#include "base/check.h"
#include "slow/component/component.h"

/* Internal steps of one call: very fast inputs would need far more. */
#define MAX_TRIES 200000
#define ORDER 5.0      /* of the error estimate of dopri5.c */
#define MAX_FACTOR 5.0 /* of successive internal steps */
/* Shortest single internal step [rad] of mode A: shorter ones are made several at a time. */
#define SHORTEST_ADVANCE 1e-3

/* Returns the first internal step at the present inputs [s], to which the instant is set. From rest
 * a = rate h at first, so that the relative error of a step is of the order of
 * (h |stiffness / mass|)^4. */
static double first_step(sm_component *c) {
    double fastest = 0.0;
    sm_instant_set(&c->instant, &c->flow, &c->inputs);
    for (int j = 0; j < c->flow.table.modes; j++)
        fastest = fmax(fastest, sm_cabs2(c->instant.spring[j]));
    return sqrt(sqrt(c->tolerance) / fastest);
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
        const int last = h >= left * (1.0 - SM_ROUNDING_TOLERANCE);
        sm_time_step step = {&c->flow, &c->inputs, *after, elapsed, last ? left : h, c->tolerance};
        if (!last) step.end = sm_inputs_after(&c->inputs, c->flow.table.modes, elapsed + step.h);
        sm_flow_point next;
        double error;
        sm_status outcome = sm_dopri5(&step, &c->instant, now, &next, &error);
        if (outcome == SM_OK && !isfinite(error)) outcome = SM_NOT_FINITE;
        /* after a stage outside the table, or an overflow: approach this time, then return the
         * status */
        if (outcome != SM_OK) error = INFINITY;
        const double factor = sm_step_factor(error, ORDER, MAX_FACTOR);
        if (error > 1.0) {
            h = step.h * factor;
            c->rejected++;
            /* shorter steps change amplitudes by rounding only, next to the edge of the table too */
            if (h < 10.0 * SM_ROUNDING * (duration + 1.0 / c->inputs.frequency[0]))
                return outcome != SM_OK ? outcome : SM_STEP_TOO_SMALL;
            continue;
        }
        c->accepted++;
        if (c->contacts.motion.wanted)
            status = sm_contact_output_add(&c->contacts, &step, &begin, now, &next);
        begin = step.end;
        *now = next;
        elapsed = last ? duration : elapsed + step.h;
        /* the last step may be short, and its error says little about longer ones */
        h = last && step.h * factor < h ? h : step.h * factor;
    }
    *next_step = h;
    return status;
}

/* Returns the slow state with time and angles `duration` later, and present amplitudes and
 * energy. */
static sm_slow_state state_after(const sm_component *c, double duration) {
    sm_slow_state fresh = c->slow;
    sm_add(&fresh.time, duration);
    for (int j = 0; j < c->flow.table.modes; j++) {
        const double rate = c->inputs.frequency_rate[j];
        sm_add_angle(&fresh.angle[j], duration * (c->inputs.frequency[j] + 0.5 * rate * duration));
    }
    return fresh;
}

/* Limits amplitudes to the edge of the table after a change of force, so that any force can be
 * followed by a smaller one. The error is at most the change of the amplitude, which relative to
 * the amplitude is about the damping ratio. */
static void limit_to_table(const sm_component *c, double *amplitude) {
    const sm_table *table = &c->flow.table;
    for (int j = 0; j < table->modes; j++) {
        const double *before = c->slow.amplitude + 2 * j, *node = j ? table->node_b : table->node_a;
        const double last = node[(j ? table->count_b : table->count_a) - 1];
        const double end = (1.0 - SM_ROUNDING_TOLERANCE) * last * c->inputs.limit_scale;
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
    SM_TRY(sm_inputs_check(&after, c->flow.table.modes));
    sm_slow_state fresh = state_after(c, duration);
    for (int j = 0; j < SM_MODES; j++) after.angle[j] = fresh.angle[j].value;
    sm_flow_point now = {.y = {0.0}};
    memcpy(now.y, c->slow.amplitude, sizeof c->slow.amplitude);
    if (sm_force_discontinuity(&c->flow, &c->slow.last_force, &c->inputs, now.y)) {
        limit_to_table(c, now.y);
        c->rate_known = 0;
    }
    SM_TRY(integrate(c, duration, most, &after, &now, &fresh.step));
    memcpy(fresh.amplitude, now.y, sizeof fresh.amplitude);
    fresh.last_force = sm_force_of(&after);
    sm_add(&fresh.energy, now.y[SM_DISSIPATED]);
    if (!SM_FINITE(fresh) || !SM_FINITE(now.dy)) return SM_NOT_FINITE;
    c->slow = fresh;
    c->inputs = after;
    memcpy(c->rate, now.dy, sizeof c->rate);
    c->rate_known = 1;
    return SM_OK;
}

/* Advances by `duration` in at most `most` internal steps. On failure nothing has changed. */
static sm_status advance(sm_component *c, double duration, int64_t most) {
    SM_TRY(sm_check_positive(duration));
    if (!c->contacts.motion.wanted) return try_advance(c, duration, most);
    sm_contact_output_save(&c->contacts, 0);
    const sm_status status = try_advance(c, duration, most);
    if (status != SM_OK) sm_contact_output_save(&c->contacts, 1);
    return status;
}

sm_status sm_component_step(sm_component *c, double duration) {
    return c ? advance(c, duration, MAX_TRIES) : SM_BAD_ARGUMENT;
}

sm_status sm_component_advance(sm_component *c, double left, double *taken) {
    if (!c || !taken) return SM_BAD_ARGUMENT;
    const double least = SHORTEST_ADVANCE / c->inputs.frequency[0];
    SM_TRY(sm_check_positive(left));
    const double step = c->slow.step;
    for (double h = step > 0.0 ? step : first_step(c); h > least; h = c->slow.step) {
        *taken = h < left * (1.0 - SM_ROUNDING_TOLERANCE) ? h : left;
        if (advance(c, *taken, 1) == SM_OK) return SM_OK;
        c->slow.step = SM_SMALLEST_FACTOR * *taken; /* the error was too large, or a stage failed */
    }
    *taken = fmin(least, left);
    const sm_status status = advance(c, *taken, MAX_TRIES);
    if (status != SM_OK) c->slow.step = step;
    return status;
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
        SM_TRY(sm_component_set_inputs(c, &inputs[*done]));
        SM_TRY(sm_component_step(c, durations[*done]));
        status = read_row(c, outputs + *done * width);
        ++*done;
    }
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
        if (t->elapsed == 0.0) SM_TRY(sm_component_set_inputs(c, &inputs[t->done]));
        SM_TRY(sm_component_advance(c, left, &taken));
        status = read_row(c, t->outputs + t->count * width);
        t->elapsed += taken;
        if (taken == left) {
            t->done++;
            t->elapsed = 0.0;
        }
    }
    return status;
}

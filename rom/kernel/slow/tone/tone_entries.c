/* A step-able flow of several modes on one or two tones (docs/theory.md, "Several modes on one
 * tone"): its memory, discontinuities of its inputs, steps and state. rom/slow/tone/ and the FMU
 * call it; the equations are in tone_flow.c, their integration in tone_march.c, the outputs in
 * tone_outputs.c. */
#include <math.h>
#include <stdlib.h>

#include "base/check.h"
#include "base/cnumber.h"
#include "slow/inputs.h"
#include "slow/tone/tone_flow.h"

#define FARTHEST_BAND 1e6 /* band of a valid state: 2000 times the reference frequency */

/* ---- memory ---------------------------------------------------------------------------------- */

/* Places the arrays; the arrays of the state are first. */
static void place(sm_tone_flow *flow, sm_block *block) {
    const sm_tone *tone = &flow->tone;
    const size_t n = 2 * (size_t)tone->contacts * (size_t)tone->tones, from = block->taken;
    size_t M = 0, fast = 0, rows = 0;
    for (int t = 0; t < tone->tones; t++) {
        const size_t own = 2 * (size_t)tone->carrier[t].fast.count;
        M += 2 * (size_t)tone->carrier[t].slow.count;
        fast = own > fast ? own : fast;
        rows += 2 * sm_tone_rows(tone, t);
    }
    flow->amplitudes = M;
    flow->state = sm_take(block, SM_TONE_SCALARS);
    flow->amplitude = sm_take(block, M);
    flow->stage[0] = sm_take(block, M);
    SM_TAKE_EACH(block, n, &flow->deficit, &flow->drive);
    flow->state_count = block->taken - from;
    flow->now = (void *)flow->state;
    flow->before = sm_take(block, flow->state_count);
    flow->others = sm_take(block, n * ((size_t)tone->contacts + 1));
    flow->given = sm_take(block, n);
    SM_TAKE_EACH(block, M, &flow->next, &flow->end);
    for (int stage = 1; stage < SM_TONE_STAGES; stage++) flow->stage[stage] = sm_take(block, M);
    flow->weight = sm_take(block, SM_TONE_WEIGHTS * M);
    flow->fast = sm_take(block, fast);
    flow->output = sm_take(block, rows);
}

/* Sets the inputs at rest: the reference frequencies, without forces. */
static void set_at_rest(sm_tone_flow *flow) {
    flow->now->inputs.limit_scale = 1.0;
    for (int t = 0; t < flow->tone.tones; t++) {
        flow->now->inputs.frequency[t] = flow->tone.carrier[t].reference;
        sm_tone_enter_band(flow, t, 0.0);
    }
}

sm_status sm_tone_create(const sm_tone *tone, double tolerance, sm_tone_flow **flow) {
    if (!flow) return SM_BAD_ARGUMENT;
    SM_TRY(sm_tone_check(tone, tolerance));
    const size_t header = sm_whole_lines(sm_doubles(sizeof(sm_tone_flow)));
    sm_block block = {NULL, 0};
    sm_tone_flow counted, *made = &counted;
    for (int counts = 1; counts >= 0; counts--) {
        if (!counts && !sm_allocate(&block)) return SM_NO_MEMORY;
        double *own = sm_take(&block, header);
        if (!counts) made = (void *)own;
        made->tone = *tone;
        place(made, &block);
    }
    made->tolerance = tolerance;
    set_at_rest(made);
    *flow = made;
    return SM_OK;
}

void sm_tone_free(sm_tone_flow *flow) { free(flow); }

/* ---- inputs and steps ------------------------------------------------------------------------ */

/* Saves the state. */
static void save(sm_tone_flow *flow) {
    memcpy(flow->before, flow->state, flow->state_count * sizeof(double));
}

/* Restores the saved state. */
static void restore(sm_tone_flow *flow) {
    const sm_tone_state last = *flow->now;
    memcpy(flow->state, flow->before, flow->state_count * sizeof(double));
    for (int t = 0; t < flow->tone.tones; t++)
        if (flow->now->band[t] != last.band[t]) sm_tone_enter_band(flow, t, flow->now->band[t]);
}

/* Enters the bands of the tones; returns whether any of them is another one. */
static int enter_bands(sm_tone_flow *flow, const double band[SM_MODES]) {
    int changed = 0;
    for (int t = 0; t < flow->tone.tones; t++)
        if (band[t] != flow->now->band[t]) {
            sm_tone_enter_band(flow, t, band[t]);
            changed = 1;
        }
    return changed;
}

/* Adds `sign` times the part c exp(-i theta) of the slow modes to their amplitudes: the response
 * of the modes with conjugate poles. These are fast modes, so that c is steady at the present
 * force. */
static void add_conjugates(sm_tone_flow *flow, double sign) {
    const sm_inputs *in = &flow->now->inputs;
    double *amplitude = flow->amplitude;
    for (int t = 0; t < flow->tone.tones; t++) {
        const sm_tone_modes *slow = &flow->tone.carrier[t].slow;
        const int M = slow->count;
        const sm_complex turn = sm_unit(-2.0 * flow->now->angle[t].value - in->phase[t]);
        const sm_complex force = sm_cscale(turn, sign * in->force[t]);
        for (int m = 0; m < M; m++) {
            const sm_complex rate = sm_cx(slow->conjugate[m], slow->conjugate[M + m]);
            const sm_complex pole = sm_cx(-slow->pole[m], -in->frequency[t] - slow->pole[M + m]);
            const sm_complex part = sm_cdiv(sm_cmul(force, rate), pole);
            amplitude[m] += part.re;
            amplitude[M + m] += part.im;
        }
        amplitude += 2 * M;
    }
}

/* Sets inputs with a discontinuity: the displacement a exp(i theta) + c exp(-i theta) of each mode
 * is continuous. */
static sm_status set_discontinuous(sm_tone_flow *flow, const sm_inputs *inputs) {
    double band[SM_MODES] = {0.0};
    add_conjugates(flow, 1.0);
    flow->now->inputs = *inputs;
    add_conjugates(flow, -1.0);
    for (int t = 0; t < flow->tone.tones; t++)
        band[t] = sm_tone_band(&flow->tone, t, inputs->frequency[t]);
    enter_bands(flow, band);
    return sm_tone_load(flow, 0.0, flow->amplitude, flow->stage[0]);
}

/* Returns whether the values of the inputs differ, apart from their rates. */
static int is_discontinuous(const sm_tone *tone, const sm_inputs *a, const sm_inputs *b) {
    for (int t = 0; t < tone->tones; t++)
        if (a->force[t] != b->force[t] || a->frequency[t] != b->frequency[t]
            || a->phase[t] != b->phase[t])
            return 1;
    return a->limit_scale != b->limit_scale;
}

sm_status sm_tone_set_inputs(sm_tone_flow *flow, const sm_inputs *inputs) {
    if (!flow || !inputs) return SM_BAD_ARGUMENT;
    const int tones = flow->tone.tones;
    SM_TRY(sm_inputs_check(inputs, tones));
    sm_inputs fresh = sm_inputs_after(inputs, tones, 0.0);
    for (int t = 0; t < tones; t++) fresh.angle[t] = flow->now->angle[t].value;
    if (!is_discontinuous(&flow->tone, &flow->now->inputs, &fresh)) {
        flow->now->inputs = fresh;
        return SM_OK;
    }
    save(flow);
    sm_status status = set_discontinuous(flow, &fresh);
    if (status == SM_OK && !sm_all_finite(flow->state, flow->state_count)) status = SM_NOT_FINITE;
    if (status != SM_OK) restore(flow);
    return status;
}

/* Integrates over `duration`, one part for each band that a frequency passes. */
static sm_status advance(sm_tone_flow *flow, double duration, const sm_inputs *after) {
    const sm_tone *tone = &flow->tone;
    const sm_inputs in = flow->now->inputs;
    double band[SM_MODES] = {0.0}, last[SM_MODES] = {0.0}, from = 0.0;
    for (int t = 0; t < tone->tones; t++) {
        band[t] = sm_tone_band(tone, t, in.frequency[t]);
        last[t] = sm_tone_band(tone, t, after->frequency[t]);
    }
    for (;;) {
        double to = duration;
        int leaving = -1, way = 0; /* the first tone that leaves its band */
        for (int t = 0; t < tone->tones; t++) {
            if (band[t] == last[t]) continue;
            const int up = last[t] > band[t] ? 1 : -1;
            const double edge = sm_tone_edge(tone, t, band[t], up);
            const double until =
                fmin(fmax((edge - in.frequency[t]) / in.frequency_rate[t], from), duration);
            if (leaving >= 0 && until >= to) continue;
            to = until;
            leaving = t;
            way = up;
        }
        sm_status status = SM_OK;
        if (enter_bands(flow, band))
            status = sm_tone_load(flow, from, flow->amplitude, flow->stage[0]);
        if (status == SM_OK && to > from) status = sm_tone_march(flow, from, to);
        if (status != SM_OK || leaving < 0) return status;
        band[leaving] += way;
        from = to;
    }
}

sm_status sm_tone_step(sm_tone_flow *flow, double duration) {
    if (!flow) return SM_BAD_ARGUMENT;
    SM_TRY(sm_check_positive(duration));
    sm_tone_state *now = flow->now;
    const sm_inputs in = now->inputs;
    const int tones = flow->tone.tones;
    sm_inputs after = sm_inputs_after(&in, tones, duration);
    SM_TRY(sm_inputs_check(&after, tones));
    save(flow);
    sm_status status = advance(flow, duration, &after);
    if (status == SM_OK) {
        sm_add(&now->time, duration);
        for (int t = 0; t < tones; t++) {
            const double mean = in.frequency[t] + 0.5 * duration * in.frequency_rate[t];
            sm_add_angle(&now->angle[t], duration * mean);
            after.angle[t] = now->angle[t].value;
        }
        now->inputs = after;
        if (!sm_all_finite(flow->state, flow->state_count)) status = SM_NOT_FINITE;
    }
    if (status != SM_OK) restore(flow);
    return status;
}

sm_status sm_tone_reset(sm_tone_flow *flow, double time) {
    if (!flow) return SM_BAD_ARGUMENT;
    if (!isfinite(time)) return SM_NOT_FINITE;
    const sm_inputs inputs = flow->now->inputs;
    save(flow);
    memset(flow->state, 0, flow->state_count * sizeof(double));
    flow->now->time.value = time;
    set_at_rest(flow);
    const sm_status status = set_discontinuous(flow, &inputs);
    if (status != SM_OK) restore(flow);
    return status;
}

/* ---- state ----------------------------------------------------------------------------------- */

size_t sm_tone_state_count(const sm_tone_flow *flow) { return flow ? flow->state_count : 0; }

sm_status sm_tone_get_state(const sm_tone_flow *flow, double *state) {
    if (!flow || !state) return SM_BAD_ARGUMENT;
    memcpy(state, flow->state, flow->state_count * sizeof(double));
    return SM_OK;
}

sm_status sm_tone_set_state(sm_tone_flow *flow, const double *state) {
    if (!flow || !state) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(state, flow->state_count)) return SM_NOT_FINITE;
    sm_tone_state given;
    memcpy(&given, state, sizeof given);
    const int tones = flow->tone.tones;
    SM_TRY(sm_inputs_check(&given.inputs, tones));
    for (int t = 0; t < tones; t++)
        if (given.band[t] != round(given.band[t]) || fabs(given.band[t]) > FARTHEST_BAND)
            return SM_BAD_ARGUMENT;
    memcpy(flow->state, state, flow->state_count * sizeof(double));
    for (int t = 0; t < tones; t++) sm_tone_enter_band(flow, t, given.band[t]);
    return SM_OK;
}

void sm_tone_work(const sm_tone_flow *flow, uint64_t *accepted, uint64_t *rejected) {
    if (accepted) *accepted = flow ? flow->accepted : 0;
    if (rejected) *rejected = flow ? flow->rejected : 0;
}

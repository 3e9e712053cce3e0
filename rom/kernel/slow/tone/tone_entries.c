/* A tone that is stepped: its memory, jumps of its inputs, steps, outputs, state. */
#include <math.h>
#include <stdlib.h>

#include "base/check.h"
#include "base/cnumber.h"
#include "slow/inputs.h"
#include "slow/tone/tone_flow.h"

#define MAX_SIZE 16384 /* modes, contacts, nodes, outputs: counts of doubles fit in 32 bits */
#define POWERS 3
#define FARTHEST_BAND 1e6 /* of a state: farther ones are damage */

/* Rows of the outputs; 0 without them. */
static size_t rows_of(const sm_tone *tone) {
    return tone->output ? (size_t)tone->amplitudes + (size_t)tone->elastic + 1 : 0;
}

/* ---- checks ---------------------------------------------------------------------------------- */

static int is_size(int32_t count, int32_t least) { return count >= least && count <= MAX_SIZE; }

static sm_status check_arrays(size_t count, const double *const arrays[], const size_t sizes[]) {
    for (size_t i = 0; i < count; i++) {
        if (!arrays[i]) return SM_BAD_ARGUMENT;
        if (!sm_all_finite(arrays[i], sizes[i])) return SM_NOT_FINITE;
    }
    return SM_OK;
}

static sm_status check_modes(const sm_tone_modes *modes, size_t contacts, size_t rows) {
    const size_t M = 2 * (size_t)modes->count;
    const double *const arrays[] = {modes->pole,   modes->excitation, modes->conjugate,
                                    modes->motion, modes->projection, modes->output};
    const size_t sizes[] = {M, M, M, M * contacts, M * contacts, M * rows};
    return check_arrays(sizeof sizes / sizeof *sizes - (rows ? 0 : 1), arrays, sizes);
}

static sm_status check_numbers(const sm_tone *tone, double tolerance) {
    const double positive[] = {tone->onset, tone->spacing, tone->reference, tolerance};
    sm_status status = SM_OK;
    for (size_t i = 0; i < sizeof positive / sizeof *positive && status == SM_OK; i++)
        status = sm_check_positive(positive[i]);
    if (status == SM_OK) status = sm_check_not_negative(tone->contraction);
    return status == SM_OK && !isfinite(tone->first) ? SM_NOT_FINITE : status;
}

static sm_status check(const sm_tone *tone, double tolerance) {
    if (!tone) return SM_BAD_ARGUMENT;
    if (!is_size(tone->slow.count, 1) || !is_size(tone->fast.count, 1)
        || !is_size(tone->contacts, 1) || !is_size(tone->nodes, 2) || tone->kinds < 1
        || tone->contacts % tone->kinds != 0 || !is_size(tone->amplitudes, 0)
        || !is_size(tone->elastic, 0))
        return SM_BAD_ARGUMENT;
    const size_t n = (size_t)tone->contacts, rows = rows_of(tone);
    const double *const arrays[] = {tone->flexibility, tone->own, tone->stiffness, tone->secant,
                                    tone->output};
    const size_t sizes[] = {2 * n * (n + 1), 2 * n, n,
                            4 * (size_t)tone->nodes * (size_t)tone->kinds, 2 * rows * (n + 1)};
    sm_status status = check_arrays(sizeof sizes / sizeof *sizes - (rows ? 0 : 1), arrays, sizes);
    if (status == SM_OK) status = check_modes(&tone->slow, n, rows);
    if (status == SM_OK) status = check_modes(&tone->fast, n, rows);
    return status == SM_OK ? check_numbers(tone, tolerance) : status;
}

/* ---- memory ---------------------------------------------------------------------------------- */

static void place(sm_tone_flow *flow, sm_block *block) {
    const sm_tone *tone = &flow->tone;
    const size_t M = 2 * (size_t)tone->slow.count, n = 2 * (size_t)tone->contacts;
    const size_t from = block->taken;
    flow->state = sm_take(block, SM_TONE_SCALARS);
    flow->amplitude = sm_take(block, M);
    flow->stage[0] = sm_take(block, M);
    flow->deficit = sm_take(block, n);
    flow->drive = sm_take(block, n);
    flow->state_count = block->taken - from;
    flow->now = (void *)flow->state;
    flow->before = sm_take(block, flow->state_count);
    flow->others = sm_take(block, n * ((size_t)tone->contacts + 1));
    flow->given = sm_take(block, n);
    flow->next = sm_take(block, M);
    flow->end = sm_take(block, M);
    for (int stage = 1; stage < SM_TONE_STAGES; stage++) flow->stage[stage] = sm_take(block, M);
    flow->weight = sm_take(block, SM_TONE_WEIGHTS * M);
    flow->fast = sm_take(block, 2 * (size_t)tone->fast.count);
    flow->output = sm_take(block, 2 * rows_of(tone));
}

sm_status sm_tone_create(const sm_tone *tone, double tolerance, sm_tone_flow **flow) {
    if (!flow) return SM_BAD_ARGUMENT;
    const sm_status status = check(tone, tolerance);
    if (status != SM_OK) return status;
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
    made->now->inputs.frequency[0] = tone->reference;
    made->now->inputs.limit_scale = 1.0;
    sm_tone_enter_band(made, 0.0);
    *flow = made;
    return SM_OK;
}

void sm_tone_free(sm_tone_flow *flow) { free(flow); }

/* ---- inputs and steps ------------------------------------------------------------------------ */

static void keep(sm_tone_flow *flow) {
    memcpy(flow->before, flow->state, flow->state_count * sizeof(double));
}

/* Returns to the state that was kept. */
static void restore(sm_tone_flow *flow) {
    const double band = flow->now->band;
    memcpy(flow->state, flow->before, flow->state_count * sizeof(double));
    if (flow->now->band != band) sm_tone_enter_band(flow, flow->now->band);
}

/* Goes to another band, if it is one; the load follows. */
static sm_status go_to_band(sm_tone_flow *flow, double band, double elapsed) {
    if (band == flow->now->band) return SM_OK;
    sm_tone_enter_band(flow, band);
    return sm_tone_load(flow, elapsed, flow->amplitude, flow->stage[0]);
}

/* Adds `sign` times what slow modes move by exp(-i theta), seen as a part of their amplitudes: it
 * follows a force at once, as the conjugate modes are fast ones. */
static void add_conjugates(sm_tone_flow *flow, double sign) {
    const sm_tone_modes *slow = &flow->tone.slow;
    const sm_inputs *in = &flow->now->inputs;
    const int M = slow->count;
    const sm_complex turn = sm_unit(-2.0 * flow->now->angle.value - in->phase[0]);
    const sm_complex force = sm_cscale(turn, sign * in->force[0]);
    for (int m = 0; m < M; m++) {
        const sm_complex rate = sm_cx(slow->conjugate[m], slow->conjugate[M + m]);
        const sm_complex pole = sm_cx(-slow->pole[m], -in->frequency[0] - slow->pole[M + m]);
        const sm_complex part = sm_cdiv(sm_cmul(force, rate), pole);
        flow->amplitude[m] += part.re;
        flow->amplitude[M + m] += part.im;
    }
}

/* Takes inputs; the displacement a exp(i theta) + c exp(-i theta) of a mode is continuous. */
static sm_status jump(sm_tone_flow *flow, const sm_inputs *inputs) {
    add_conjugates(flow, 1.0);
    flow->now->inputs = *inputs;
    add_conjugates(flow, -1.0);
    const double band = sm_tone_band(&flow->tone, inputs->frequency[0]);
    if (band != flow->now->band) sm_tone_enter_band(flow, band);
    return sm_tone_load(flow, 0.0, flow->amplitude, flow->stage[0]);
}

/* Whether the values of the inputs differ, besides their rates. */
static int is_jump(const sm_inputs *a, const sm_inputs *b) {
    return a->force[0] != b->force[0] || a->frequency[0] != b->frequency[0]
           || a->phase[0] != b->phase[0] || a->limit_scale != b->limit_scale;
}

sm_status sm_tone_set_inputs(sm_tone_flow *flow, const sm_inputs *inputs) {
    if (!flow || !inputs) return SM_BAD_ARGUMENT;
    sm_status status = sm_inputs_check(inputs, 1);
    if (status != SM_OK) return status;
    sm_inputs fresh = sm_inputs_after(inputs, 1, 0.0);
    fresh.angle[0] = flow->now->angle.value;
    if (!is_jump(&flow->now->inputs, &fresh)) {
        flow->now->inputs = fresh;
        return SM_OK;
    }
    keep(flow);
    status = jump(flow, &fresh);
    if (status == SM_OK && !sm_all_finite(flow->state, flow->state_count)) status = SM_NOT_FINITE;
    if (status != SM_OK) restore(flow);
    return status;
}

/* Goes through the bands that the frequency passes in a step. */
static sm_status advance(sm_tone_flow *flow, double duration, const sm_inputs *after) {
    const sm_inputs in = flow->now->inputs;
    const double last = sm_tone_band(&flow->tone, after->frequency[0]);
    double band = sm_tone_band(&flow->tone, in.frequency[0]), from = 0.0;
    const int way = last >= band ? 1 : -1;
    for (;; band += way) {
        double to = duration;
        if (band != last) {
            const double edge = sm_tone_edge(&flow->tone, band, way);
            to = fmin(fmax((edge - in.frequency[0]) / in.frequency_rate[0], from), duration);
        }
        sm_status status = go_to_band(flow, band, from);
        if (status == SM_OK && to > from) status = sm_tone_march(flow, from, to);
        if (status != SM_OK || band == last) return status;
        from = to;
    }
}

sm_status sm_tone_step(sm_tone_flow *flow, double duration) {
    if (!flow) return SM_BAD_ARGUMENT;
    sm_status status = sm_check_positive(duration);
    if (status != SM_OK) return status;
    sm_tone_state *now = flow->now;
    const sm_inputs *in = &now->inputs;
    sm_inputs after = sm_inputs_after(in, 1, duration);
    if ((status = sm_inputs_check(&after, 1)) != SM_OK) return status;
    const double turned = duration * (in->frequency[0] + 0.5 * duration * in->frequency_rate[0]);
    keep(flow);
    status = advance(flow, duration, &after);
    if (status == SM_OK) {
        sm_add(&now->time, duration);
        sm_add_angle(&now->angle, turned);
        after.angle[0] = now->angle.value;
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
    keep(flow);
    memset(flow->state, 0, flow->state_count * sizeof(double));
    flow->now->time.value = time;
    flow->now->inputs.frequency[0] = flow->tone.reference;
    flow->now->inputs.limit_scale = 1.0;
    sm_tone_enter_band(flow, 0.0);
    const sm_status status = jump(flow, &inputs);
    if (status != SM_OK) restore(flow);
    return status;
}

/* ---- outputs --------------------------------------------------------------------------------- */

sm_status sm_tone_present(const sm_tone_flow *flow, sm_inputs *inputs, double *amplitude,
                          double *deficit) {
    if (!flow || !inputs || !amplitude || !deficit) return SM_BAD_ARGUMENT;
    *inputs = flow->now->inputs;
    memcpy(amplitude, flow->amplitude, 2 * (size_t)flow->tone.slow.count * sizeof(double));
    memcpy(deficit, flow->deficit, 2 * (size_t)flow->tone.contacts * sizeof(double));
    return SM_OK;
}

/* Outputs that change slowly: time, amplitudes, angle, powers. */
static size_t slow_count(const sm_tone *tone) {
    return 2 + 2 * (size_t)tone->amplitudes + POWERS;
}

size_t sm_tone_output_count(const sm_tone_flow *flow) {
    if (!flow || !flow->tone.output) return 0;
    const sm_tone *tone = &flow->tone;
    const size_t contacts = tone->contact_motion ? 3 * (size_t)tone->contacts : 0;
    return slow_count(tone) + contacts + (size_t)tone->elastic;
}

/* Harmonics of the outputs (2, K). */
static const double *harmonics(sm_tone_flow *flow) {
    const sm_tone *tone = &flow->tone;
    const sm_inputs *in = &flow->now->inputs;
    const sm_complex force = sm_cscale(sm_unit(in->phase[0]), in->force[0]);
    const double magnitude[2] = {force.re, force.im};
    const int rows = (int)rows_of(tone), n = tone->contacts, fast = tone->fast.count;
    memset(flow->fast, 0, 2 * (size_t)fast * sizeof(double));
    sm_tone_add_product(fast, 1, tone->fast.excitation, magnitude, flow->fast);
    sm_tone_add_product(fast, n, tone->fast.projection, flow->deficit, flow->fast);
    sm_tone_steady(&tone->fast, in->frequency[0], flow->fast);
    memset(flow->output, 0, 2 * (size_t)rows * sizeof(double));
    sm_tone_add_product(rows, tone->slow.count, tone->slow.output, flow->amplitude, flow->output);
    sm_tone_add_product(rows, fast, tone->fast.output, flow->fast, flow->output);
    sm_tone_add_product(rows, n, tone->output, flow->deficit, flow->output);
    sm_tone_add_product(rows, 1, tone->output + 2 * (size_t)rows * (size_t)n, magnitude,
                        flow->output);
    return flow->output;
}

/* 2 Re(c exp(i theta)) */
static double real_part(sm_complex c, sm_complex carrier) {
    return 2.0 * (c.re * carrier.re - c.im * carrier.im);
}

/* Writes displacement, velocity and force of all contacts, (3, n). */
static void write_contacts(const sm_tone_flow *flow, sm_complex carrier, double *out) {
    const sm_tone *tone = &flow->tone;
    const int n = tone->contacts;
    const sm_complex spun = sm_cscale(sm_cmul(sm_cx(0.0, 1.0), carrier),
                                      flow->now->inputs.frequency[0]);
    for (int j = 0; j < n; j++) {
        const sm_complex y = sm_cx(flow->deficit[j], flow->deficit[n + j]);
        const sm_complex own = sm_cmul(sm_cx(tone->own[j], tone->own[n + j]), y);
        const sm_complex x = sm_cadd(sm_cx(flow->drive[j], flow->drive[n + j]), own);
        out[j] = real_part(x, carrier);
        out[n + j] = real_part(x, spun);
        out[2 * n + j] = real_part(sm_csub(sm_cscale(x, tone->stiffness[j]), y), carrier);
    }
}

sm_status sm_tone_slow_outputs(sm_tone_flow *flow, double *outputs) {
    if (!flow || !outputs || !flow->tone.output) return SM_BAD_ARGUMENT;
    const sm_tone_state *now = flow->now;
    const sm_inputs *in = &now->inputs;
    const size_t rows = rows_of(&flow->tone), work = rows - 1;
    const double *z = harmonics(flow);
    *outputs++ = now->time.value;
    for (int k = 0; k < flow->tone.amplitudes; k++) {
        *outputs++ = z[k];
        *outputs++ = z[rows + (size_t)k];
    }
    *outputs++ = now->angle.value;
    const sm_complex against = sm_cscale(sm_unit(-in->phase[0]), in->force[0]);
    *outputs++ = -in->frequency[0] * sm_cmul(against, sm_cx(z[work], z[rows + work])).im;
    *outputs++ = now->power;
    *outputs = now->energy.value;
    return SM_OK;
}

sm_status sm_tone_outputs(sm_tone_flow *flow, double *outputs) {
    const sm_status status = sm_tone_slow_outputs(flow, outputs);
    if (status != SM_OK) return status;
    const sm_tone *tone = &flow->tone;
    const size_t rows = rows_of(tone), amplitudes = (size_t)tone->amplitudes;
    const sm_complex carrier = sm_unit(flow->now->angle.value);
    double *motion = outputs + slow_count(tone);
    if (tone->contact_motion) {
        write_contacts(flow, carrier, motion);
        motion += 3 * tone->contacts;
    }
    for (size_t k = amplitudes; k < amplitudes + (size_t)tone->elastic; k++)
        *motion++ = real_part(sm_cx(flow->output[k], flow->output[rows + k]), carrier);
    return SM_OK;
}

sm_status sm_tone_run(sm_tone_flow *flow, size_t steps, const double *durations,
                      const sm_inputs *inputs, double *outputs, size_t *done) {
    if (!flow || !durations || !inputs || !outputs || !done) return SM_BAD_ARGUMENT;
    const size_t width = sm_tone_output_count(flow);
    for (*done = 0; *done < steps; ++*done) {
        sm_status status = sm_tone_set_inputs(flow, &inputs[*done]);
        if (status == SM_OK) status = sm_tone_step(flow, durations[*done]);
        if (status == SM_OK) status = sm_tone_outputs(flow, outputs + *done * width);
        if (status != SM_OK) return status;
    }
    return SM_OK;
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
    const sm_status status = sm_inputs_check(&given.inputs, 1);
    if (status != SM_OK) return status;
    if (given.band != round(given.band) || fabs(given.band) > FARTHEST_BAND)
        return SM_BAD_ARGUMENT;
    memcpy(flow->state, state, flow->state_count * sizeof(double));
    sm_tone_enter_band(flow, given.band);
    return SM_OK;
}

void sm_tone_work(const sm_tone_flow *flow, uint64_t *accepted, uint64_t *rejected) {
    if (accepted) *accepted = flow ? flow->accepted : 0;
    if (rejected) *rejected = flow ? flow->rejected : 0;
}

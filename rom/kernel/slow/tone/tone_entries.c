/* A step-able flow of several modes on one tone (docs/theory.md, "Several modes on one tone"): its
 * memory, discontinuities of its inputs, steps, outputs and state. rom/slow/tone/ and the FMU call
 * it; the equations are in tone_flow.c, their integration in tone_march.c. */
#include <math.h>
#include <stdlib.h>

#include "base/check.h"
#include "base/cnumber.h"
#include "slow/inputs.h"
#include "slow/tone/tone_flow.h"

#define MAX_SIZE 16384 /* modes, contacts, nodes, outputs: counts of doubles fit in 32 bits */
#define POWERS 3       /* outputs: input power, dissipated power, dissipated energy */
#define FARTHEST_BAND 1e6 /* band of a valid state: 2000 times the reference frequency */

/* Returns the number of complex outputs K; 0 without outputs. */
static size_t rows_of(const sm_tone *tone) {
    return tone->output ? (size_t)tone->amplitudes + (size_t)tone->elastic + 1 : 0;
}

/* ---- checks ---------------------------------------------------------------------------------- */

/* Returns whether a number is within its limits. */
static int is_size(int32_t count, int32_t least) { return count >= least && count <= MAX_SIZE; }

/* Checks that arrays exist and are finite. */
static sm_status check_arrays(size_t count, const double *const arrays[], const size_t sizes[]) {
    for (size_t i = 0; i < count; i++) {
        if (!arrays[i]) return SM_BAD_ARGUMENT;
        if (!sm_all_finite(arrays[i], sizes[i])) return SM_NOT_FINITE;
    }
    return SM_OK;
}

/* Checks the arrays of modes; the last one, of outputs, only if there are any. */
static sm_status check_modes(const sm_tone_modes *modes, size_t contacts, size_t rows) {
    const size_t M = 2 * (size_t)modes->count;
    const double *const arrays[] = {modes->pole,   modes->excitation, modes->conjugate,
                                    modes->motion, modes->projection, modes->output};
    const size_t sizes[] = {M, M, M, M * contacts, M * contacts, M * rows};
    return check_arrays(sizeof sizes / sizeof *sizes - (rows ? 0 : 1), arrays, sizes);
}

/* Checks the scalars of a tone. */
static sm_status check_numbers(const sm_tone *tone, double tolerance) {
    const double positive[] = {tone->onset, tone->spacing, tone->reference, tolerance};
    sm_status status = SM_OK;
    for (size_t i = 0; i < sizeof positive / sizeof *positive && status == SM_OK; i++)
        status = sm_check_positive(positive[i]);
    if (status == SM_OK) status = sm_check_not_negative(tone->contraction);
    return status == SM_OK && !isfinite(tone->first) ? SM_NOT_FINITE : status;
}

/* Checks a tone. */
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

/* Places the arrays; the arrays of the state are first. */
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

/* Saves the state. */
static void save(sm_tone_flow *flow) {
    memcpy(flow->before, flow->state, flow->state_count * sizeof(double));
}

/* Restores the saved state. */
static void restore(sm_tone_flow *flow) {
    const double band = flow->now->band;
    memcpy(flow->state, flow->before, flow->state_count * sizeof(double));
    if (flow->now->band != band) sm_tone_enter_band(flow, flow->now->band);
}

/* Enters a band, unless it is the present one, and computes the load there. */
static sm_status change_band(sm_tone_flow *flow, double band, double elapsed) {
    if (band == flow->now->band) return SM_OK;
    sm_tone_enter_band(flow, band);
    return sm_tone_load(flow, elapsed, flow->amplitude, flow->stage[0]);
}

/* Adds `sign` times the part c exp(-i theta) of the slow modes to their amplitudes: the response
 * of the modes with conjugate poles. These are fast modes, so that c is steady at the present
 * force. */
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

/* Sets inputs with a discontinuity: the displacement a exp(i theta) + c exp(-i theta) of each mode
 * is continuous. */
static sm_status set_discontinuous(sm_tone_flow *flow, const sm_inputs *inputs) {
    add_conjugates(flow, 1.0);
    flow->now->inputs = *inputs;
    add_conjugates(flow, -1.0);
    const double band = sm_tone_band(&flow->tone, inputs->frequency[0]);
    if (band != flow->now->band) sm_tone_enter_band(flow, band);
    return sm_tone_load(flow, 0.0, flow->amplitude, flow->stage[0]);
}

/* Returns whether the values of the inputs differ, apart from their rates. */
static int is_discontinuous(const sm_inputs *a, const sm_inputs *b) {
    return a->force[0] != b->force[0] || a->frequency[0] != b->frequency[0]
           || a->phase[0] != b->phase[0] || a->limit_scale != b->limit_scale;
}

sm_status sm_tone_set_inputs(sm_tone_flow *flow, const sm_inputs *inputs) {
    if (!flow || !inputs) return SM_BAD_ARGUMENT;
    sm_status status = sm_inputs_check(inputs, 1);
    if (status != SM_OK) return status;
    sm_inputs fresh = sm_inputs_after(inputs, 1, 0.0);
    fresh.angle[0] = flow->now->angle.value;
    if (!is_discontinuous(&flow->now->inputs, &fresh)) {
        flow->now->inputs = fresh;
        return SM_OK;
    }
    save(flow);
    status = set_discontinuous(flow, &fresh);
    if (status == SM_OK && !sm_all_finite(flow->state, flow->state_count)) status = SM_NOT_FINITE;
    if (status != SM_OK) restore(flow);
    return status;
}

/* Integrates over `duration`, one part for each band that the frequency passes. */
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
        sm_status status = change_band(flow, band, from);
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
    save(flow);
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
    save(flow);
    memset(flow->state, 0, flow->state_count * sizeof(double));
    flow->now->time.value = time;
    flow->now->inputs.frequency[0] = flow->tone.reference;
    flow->now->inputs.limit_scale = 1.0;
    sm_tone_enter_band(flow, 0.0);
    const sm_status status = set_discontinuous(flow, &inputs);
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

/* Returns the number of slow outputs: time, amplitudes, angle, powers. */
static size_t slow_count(const sm_tone *tone) {
    return 2 + 2 * (size_t)tone->amplitudes + POWERS;
}

size_t sm_tone_output_count(const sm_tone_flow *flow) {
    if (!flow || !flow->tone.output) return 0;
    const sm_tone *tone = &flow->tone;
    const size_t contacts = tone->contact_motion ? 3 * (size_t)tone->contacts : 0;
    return slow_count(tone) + contacts + (size_t)tone->elastic;
}

/* Computes the complex amplitudes of the outputs (2, K). */
static const double *output_amplitudes(sm_tone_flow *flow) {
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

/* Returns 2 Re(c exp(i theta)). */
static double real_part(sm_complex c, sm_complex carrier) {
    return 2.0 * (c.re * carrier.re - c.im * carrier.im);
}

/* Writes displacement, velocity and force of all contacts, (3, n). */
static void write_contacts(const sm_tone_flow *flow, sm_complex carrier, double *out) {
    const sm_tone *tone = &flow->tone;
    const int n = tone->contacts;
    const sm_complex carrier_rate = sm_cscale(sm_cmul(sm_cx(0.0, 1.0), carrier),
                                      flow->now->inputs.frequency[0]);
    for (int j = 0; j < n; j++) {
        const sm_complex y = sm_cx(flow->deficit[j], flow->deficit[n + j]);
        const sm_complex own = sm_cmul(sm_cx(tone->own[j], tone->own[n + j]), y);
        const sm_complex x = sm_cadd(sm_cx(flow->drive[j], flow->drive[n + j]), own);
        out[j] = real_part(x, carrier);
        out[n + j] = real_part(x, carrier_rate);
        out[2 * n + j] = real_part(sm_csub(sm_cscale(x, tone->stiffness[j]), y), carrier);
    }
}

sm_status sm_tone_slow_outputs(sm_tone_flow *flow, double *outputs) {
    if (!flow || !outputs || !flow->tone.output) return SM_BAD_ARGUMENT;
    const sm_tone_state *now = flow->now;
    const sm_inputs *in = &now->inputs;
    const size_t rows = rows_of(&flow->tone), work = rows - 1;
    const double *z = output_amplitudes(flow);
    *outputs++ = now->time.value;
    for (int k = 0; k < flow->tone.amplitudes; k++) {
        *outputs++ = z[k];
        *outputs++ = z[rows + (size_t)k];
    }
    *outputs++ = now->angle.value;
    const sm_complex conjugate_force = sm_cscale(sm_unit(-in->phase[0]), in->force[0]);
    *outputs++ = -in->frequency[0] * sm_cmul(conjugate_force, sm_cx(z[work], z[rows + work])).im;
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

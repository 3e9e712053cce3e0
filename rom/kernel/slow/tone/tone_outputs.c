/* Outputs of a flow of several modes on one or two tones: amplitudes, powers, displacements and
 * contacts. The core's structure has them as harmonics that are linear in amplitudes, deficits and
 * forces. rom/slow/tone/ and the FMU call it. */
#include <math.h>

#include "base/check.h"
#include "base/cnumber.h"
#include "slow/tone/tone_flow.h"

#define POWERS 3 /* outputs: input power, dissipated power, dissipated energy */

sm_status sm_tone_present(const sm_tone_flow *flow, sm_inputs *inputs, double *amplitude,
                          double *deficit) {
    if (!flow || !inputs || !amplitude || !deficit) return SM_BAD_ARGUMENT;
    *inputs = flow->now->inputs;
    const size_t deficits = 2 * (size_t)flow->tone.contacts * (size_t)flow->tone.tones;
    memcpy(amplitude, flow->amplitude, flow->amplitudes * sizeof(double));
    memcpy(deficit, flow->deficit, deficits * sizeof(double));
    return SM_OK;
}

/* Returns the number of slow outputs: time, amplitudes, angles, powers. */
static size_t slow_count(const sm_tone *tone) {
    size_t count = 1 + (size_t)tone->tones + POWERS;
    for (int t = 0; t < tone->tones; t++) count += 2 * (size_t)tone->carrier[t].amplitudes;
    return count;
}

size_t sm_tone_output_count(const sm_tone_flow *flow) {
    if (!flow || !flow->tone.carrier[0].output) return 0;
    const sm_tone *tone = &flow->tone;
    const size_t contacts = tone->contact_motion ? 3 * (size_t)tone->contacts : 0;
    return slow_count(tone) + contacts + (size_t)tone->elastic;
}

/* Computes the complex amplitudes of the outputs at carrier t (2, K), from the slow modes (2, M). */
static void compute_outputs(sm_tone_flow *flow, int t, const double *amplitude, double *output) {
    const sm_tone_carrier *tone = &flow->tone.carrier[t];
    const sm_inputs *in = &flow->now->inputs;
    const sm_complex force = sm_cscale(sm_unit(in->phase[t]), in->force[t]);
    const double magnitude[2] = {force.re, force.im};
    const int rows = (int)sm_tone_rows(&flow->tone, t), n = flow->tone.contacts;
    const int fast = tone->fast.count;
    const double *deficit = flow->deficit + 2 * n * t;
    memset(flow->fast, 0, 2 * (size_t)fast * sizeof(double));
    sm_tone_add_product(fast, 1, tone->fast.excitation, magnitude, flow->fast);
    sm_tone_add_product(fast, n, tone->fast.projection, deficit, flow->fast);
    sm_tone_steady(&tone->fast, in->frequency[t], flow->fast);
    memset(output, 0, 2 * (size_t)rows * sizeof(double));
    sm_tone_add_product(rows, tone->slow.count, tone->slow.output, amplitude, output);
    sm_tone_add_product(rows, fast, tone->fast.output, flow->fast, output);
    sm_tone_add_product(rows, n, tone->output, deficit, output);
    sm_tone_add_product(rows, 1, tone->output + 2 * (size_t)rows * (size_t)n, magnitude, output);
}

/* Returns 2 Re(c exp(i theta)). */
static double real_part(sm_complex c, sm_complex carrier) {
    return 2.0 * (c.re * carrier.re - c.im * carrier.im);
}

/* Adds displacement, velocity and force of all contacts at carrier t, (3, n). */
static void add_contacts(const sm_tone_flow *flow, int t, sm_complex carrier, double *out) {
    const sm_tone *tone = &flow->tone;
    const int n = tone->contacts;
    const double *deficit = flow->deficit + 2 * n * t, *drive = flow->drive + 2 * n * t;
    const double *g = tone->carrier[t].own;
    const sm_complex carrier_rate = sm_cscale(sm_cmul(sm_cx(0.0, 1.0), carrier),
                                              flow->now->inputs.frequency[t]);
    for (int j = 0; j < n; j++) {
        const sm_complex y = sm_cx(deficit[j], deficit[n + j]);
        const sm_complex own = sm_cmul(sm_cx(g[j], g[n + j]), y);
        const sm_complex x = sm_cadd(sm_cx(drive[j], drive[n + j]), own);
        out[j] += real_part(x, carrier);
        out[n + j] += real_part(x, carrier_rate);
        out[2 * n + j] += real_part(sm_csub(sm_cscale(x, tone->stiffness[j]), y), carrier);
    }
}

sm_status sm_tone_slow_outputs(sm_tone_flow *flow, double *outputs) {
    if (!flow || !outputs || !flow->tone.carrier[0].output) return SM_BAD_ARGUMENT;
    const sm_tone_state *now = flow->now;
    const sm_inputs *in = &now->inputs;
    const double *amplitude = flow->amplitude;
    double *z = flow->output, power = 0.0;
    *outputs++ = now->time.value;
    for (int t = 0; t < flow->tone.tones; t++) {
        const sm_tone_carrier *carrier = &flow->tone.carrier[t];
        const size_t rows = sm_tone_rows(&flow->tone, t), work = rows - 1;
        compute_outputs(flow, t, amplitude, z);
        for (int k = 0; k < carrier->amplitudes; k++) {
            *outputs++ = z[k];
            *outputs++ = z[rows + (size_t)k];
        }
        const sm_complex conjugate_force = sm_cscale(sm_unit(-in->phase[t]), in->force[t]);
        power -= in->frequency[t] * sm_cmul(conjugate_force, sm_cx(z[work], z[rows + work])).im;
        amplitude += 2 * carrier->slow.count;
        z += 2 * rows;
    }
    for (int t = 0; t < flow->tone.tones; t++) *outputs++ = now->angle[t].value;
    *outputs++ = power;
    *outputs++ = now->power;
    *outputs = now->energy.value;
    return SM_OK;
}

sm_status sm_tone_outputs(sm_tone_flow *flow, double *outputs) {
    SM_TRY(sm_tone_slow_outputs(flow, outputs));
    const sm_tone *tone = &flow->tone;
    const size_t contacts = tone->contact_motion ? 3 * (size_t)tone->contacts : 0;
    const double *z = flow->output;
    double *motion = outputs + slow_count(tone), *elastic = motion + contacts;
    memset(motion, 0, (contacts + (size_t)tone->elastic) * sizeof(double));
    for (int t = 0; t < tone->tones; t++) {
        const size_t rows = sm_tone_rows(tone, t), first = (size_t)tone->carrier[t].amplitudes;
        const sm_complex carrier = sm_unit(flow->now->angle[t].value);
        if (tone->contact_motion) add_contacts(flow, t, carrier, motion);
        for (size_t k = 0; k < (size_t)tone->elastic; k++)
            elastic[k] += real_part(sm_cx(z[first + k], z[rows + first + k]), carrier);
        z += 2 * rows;
    }
    return SM_OK;
}

sm_status sm_tone_run(sm_tone_flow *flow, size_t steps, const double *durations,
                      const sm_inputs *inputs, double *outputs, size_t *done) {
    if (!flow || !durations || !inputs || !outputs || !done) return SM_BAD_ARGUMENT;
    const size_t width = sm_tone_output_count(flow);
    for (*done = 0; *done < steps; ++*done) {
        SM_TRY(sm_tone_set_inputs(flow, &inputs[*done]));
        SM_TRY(sm_tone_step(flow, durations[*done]));
        SM_TRY(sm_tone_outputs(flow, outputs + *done * width));
    }
    return SM_OK;
}

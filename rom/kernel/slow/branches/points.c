/* The slow flow at many points: its rates with everything, what balances in steady motion, and steady
 * states along a line of inputs as a curve. */
#include <math.h>
#include <string.h>

#include "base/check.h"
#include "slow/slow_flow.h"
#include "table/table.h"

sm_status sm_slow_flow_rates(const sm_slow_flow *flow, size_t points, const sm_inputs *inputs,
                             const double *amplitude, double *rate) {
    if (!flow || !inputs || !amplitude || !rate) return SM_BAD_ARGUMENT;
    const size_t unknowns = 2 * (size_t)flow->table.modes;
    sm_status worst = SM_OK;
    for (size_t p = 0; p < points; p++) {
        double powers[2], *at = rate + p * unknowns;
        const sm_status status =
            sm_slow_flow_rate(flow, inputs + p, 0.0, amplitude + p * unknowns, at, powers);
        if (status != SM_OK && status != SM_OUTSIDE_TABLE) return status;
        if (status == SM_OK) continue;
        worst = status;
        for (size_t k = 0; k < unknowns; k++) at[k] = NAN;
    }
    return worst;
}

static void put(const sm_modal *values, int modes, double *out) {
    for (int j = 0; j < modes; j++) {
        const sm_complex z = sm_of(values, j);
        out[2 * j] = z.re;
        out[2 * j + 1] = z.im;
    }
}

/* d rate / d amplitude (2 modes, 2 modes) of steady motion, a column for each real part and each
 * imaginary one. */
static void jacobian_at(const sm_slow_flow *flow, const sm_instant *instant,
                        const sm_flow_state *state, double *jacobian) {
    const int modes = flow->table.modes, unknowns = 2 * modes;
    const size_t fields = 2 * (size_t)(modes + flow->table.combinations + flow->table.power);
    const sm_factors *by = &instant->factor;
    for (int j = 0; j < modes; j++) {
        const sm_complex gain = sm_cmul(sm_of(&by->rate_ratio, j), sm_of(&state->effective.unit, j));
        double *re = jacobian + 2 * j * unknowns, *im = re + unknowns;
        for (int k = 0; k < modes; k++) {
            /* by how much the modulus grows and turns per amplitude that is real */
            const sm_complex moved = sm_cmul(sm_conj(sm_of(&state->effective.unit, k)),
                                             sm_of(&by->amplitude_ratio, k));
            const double *S = state->slopes + 2 * j, *slope = S + (size_t)(k + 1) * fields;
            const double modulus = state->effective.modulus[k];
            const sm_complex grown = sm_cmul(gain, sm_pair(slope));
            sm_complex turned = sm_cx(0.0, 0.0), spring = turned;
            if (j == k) {
                const double per = state->effective.per_modulus[k];
                const sm_complex part = modulus > 0.0 ? sm_cscale(sm_pair(S), per) : sm_pair(slope);
                turned = sm_cmul(gain, sm_cx(-part.im, part.re));
                spring = sm_of(&by->spring, j);
            }
            re[2 * k] = grown.re * moved.re + turned.re * moved.im - spring.re;
            im[2 * k] = grown.im * moved.re + turned.im * moved.im - spring.im;
            re[2 * k + 1] = turned.re * moved.re - grown.re * moved.im + spring.im;
            im[2 * k + 1] = turned.im * moved.re - grown.im * moved.im - spring.re;
        }
    }
}

/* Steady motion at amplitudes y (2 modes) and inputs that are checked: without a'', combination
 * resonances at their mean, 0. `sloped` as in sm_first_order. What `instant` remembers of another
 * point is only spared work. */
static sm_status steady_at(const sm_slow_flow *flow, const sm_inputs *inputs, int sloped,
                           const double *y, sm_instant *instant, sm_flow_state *state) {
    sm_instant_set(instant, flow, inputs);
    memset(instant->combination_on, 0, sizeof instant->combination_on);
    return sm_first_order(flow, instant, sloped, y, state);
}

/* The flow is checked. */
static sm_status balance_at(const sm_slow_flow *flow, const sm_inputs *inputs,
                            sm_instant *instant, const double *amplitude, double *balance,
                            double *jacobian) {
    const int modes = flow->table.modes;
    const sm_inputs now = sm_inputs_after(inputs, modes, 0.0);
    sm_status status = sm_inputs_check(&now, modes);
    if (status != SM_OK) return status;
    double y[2 * SM_MODES] = {0.0};
    for (int k = 0; k < 2 * modes; k++) y[k] = amplitude[k];
    if (!sm_all_finite(y, 2 * SM_MODES)) return SM_NOT_FINITE;
    sm_flow_state state;
    status = steady_at(flow, &now, jacobian != NULL, y, instant, &state);
    if (status != SM_OK) return status;
    const sm_modal *const parts[] = {&instant->now.mass, &instant->now.stiffness, &state.force,
                                     &state.rate};
    for (int k = 0; k < 4; k++) put(parts[k], modes, balance + 2 * k * modes);
    if (!sm_all_finite(balance, 8 * (size_t)modes)) return SM_NOT_FINITE;
    if (jacobian) jacobian_at(flow, instant, &state, jacobian);
    return SM_OK;
}

sm_status sm_slow_flow_balance(const sm_slow_flow *flow, size_t points, const sm_inputs *inputs,
                               const double *amplitude, double *balance, double *jacobian) {
    if (!flow || !inputs || !amplitude || !balance) return SM_BAD_ARGUMENT;
    sm_status worst = sm_slow_flow_check(flow);
    if (worst != SM_OK) return worst;
    sm_instant instant = {.known = 0};
    const size_t unknowns = 2 * (size_t)flow->table.modes;
    for (size_t p = 0; p < points; p++) {
        double *at = balance + 4 * p * unknowns;
        double *slopes = jacobian ? jacobian + p * unknowns * unknowns : NULL;
        const sm_status status = balance_at(
            flow, inputs + p, &instant, amplitude + p * unknowns, at, slopes);
        if (status != SM_OK && status != SM_OUTSIDE_TABLE) return status;
        if (status == SM_OK) continue;
        worst = status;
        for (size_t k = 0; k < 4 * unknowns; k++) at[k] = NAN;
        for (size_t k = 0; slopes && k < unknowns * unknowns; k++) slopes[k] = NAN;
    }
    return worst;
}

#define ALONG 0x1p-40 /* of the line: along the whole of it, a small amplitude would be taken as zero */

/* How they change with p; what does not is 0. */
static sm_inputs change_of(const sm_forced *forced) {
    const sm_inputs *from = &forced->inputs[0], *to = &forced->inputs[1];
    sm_inputs change = {.limit_scale = to->limit_scale - from->limit_scale};
    for (int j = 0; j < SM_MODES; j++) {
        change.force[j] = to->force[j] - from->force[j];
        change.frequency[j] = to->frequency[j] - from->frequency[j];
    }
    return change;
}

sm_inputs sm_forced_inputs(const sm_forced *forced, double p) {
    const sm_inputs change = change_of(forced);
    sm_inputs at = forced->inputs[0];
    for (int j = 0; j < SM_MODES; j++) {
        at.force[j] += p * change.force[j];
        at.frequency[j] += p * change.frequency[j];
    }
    at.limit_scale += p * change.limit_scale;
    return at;
}

/* d rate / dp, with amplitudes that keep their ratio to the limits. */
static void change_by_inputs(const sm_forced *forced, const sm_instant *instant,
                             const sm_flow_state *state, const double *z, sm_modal *rate) {
    const sm_slow_flow *flow = forced->flow;
    const double combination_angle[SM_COMBINATIONS] = {0.0};
    sm_inputs slowly = change_of(forced);
    sm_modal amplitude = {{0.0}, {0.0}};
    sm_coefficients now;
    sm_flow_change found;
    slowly.limit_scale *= ALONG;
    for (int j = 0; j < flow->table.modes; j++) {
        slowly.force[j] *= ALONG;
        slowly.frequency[j] *= ALONG;
        const double grows = slowly.limit_scale * forced->scale[j];
        sm_put(&amplitude, j, sm_cscale(sm_pair(z + 2 * j), grows));
    }
    sm_coefficients_change(flow, instant, &slowly, &now);
    const sm_direction along = {.amplitude = &amplitude,
                                .now = &now,
                                .combination_angle = combination_angle,
                                .limit_scale = slowly.limit_scale};
    sm_first_order_change(flow, instant, state, &along, &found);
    for (int j = 0; j < flow->table.modes; j++)
        sm_put(rate, j, sm_cscale(sm_of(&found.rate, j), 1.0 / ALONG));
}

/* sm_curve_rates of an sm_forced that is checked. */
static sm_status forced_rates(const void *of, const double *z, double *F, double *J) {
    const sm_forced *forced = of;
    const int modes = forced->flow->table.modes, k = 2 * modes;
    const sm_inputs inputs = sm_forced_inputs(forced, z[k]);
    sm_status status = sm_inputs_check(&inputs, modes);
    if (status != SM_OK) return status;
    double size[2 * SM_MODES], y[2 * SM_MODES] = {0.0}, jacobian[4 * SM_MODES * SM_MODES];
    for (int r = 0; r < k; r++) {
        size[r] = inputs.limit_scale * forced->scale[r / 2];
        y[r] = size[r] * z[r];
    }
    sm_instant instant = {.known = 0};
    sm_flow_state state;
    status = steady_at(forced->flow, &inputs, 1, y, &instant, &state);
    if (status != SM_OK) return status;
    sm_modal change;
    jacobian_at(forced->flow, &instant, &state, jacobian);
    change_by_inputs(forced, &instant, &state, z, &change);
    const double growth = change_of(forced).limit_scale / inputs.limit_scale;
    for (int r = 0; r < k; r++) {
        const sm_complex rate = sm_of(&state.rate, r / 2), by_p = sm_of(&change, r / 2);
        F[r] = (r % 2 ? rate.im : rate.re) / size[r];
        for (int c = 0; c < k; c++) J[r * (k + 1) + c] = jacobian[r * k + c] * size[c] / size[r];
        J[r * (k + 1) + k] = (r % 2 ? by_p.im : by_p.re) / size[r] - growth * F[r];
    }
    return sm_all_finite(F, (size_t)k) && sm_all_finite(J, (size_t)(k * (k + 1))) ? SM_OK
                                                                                  : SM_NOT_FINITE;
}

static sm_status check(const sm_forced *forced) {
    if (!forced || !forced->flow || !forced->inputs) return SM_BAD_ARGUMENT;
    sm_status status = sm_slow_flow_check(forced->flow);
    for (int j = 0; status == SM_OK && j < forced->flow->table.modes; j++)
        status = sm_check_positive(forced->scale[j]);
    return status;
}

sm_status sm_forced_curve(const sm_forced *forced, double largest_step, sm_curve *curve) {
    const sm_status status = curve ? check(forced) : SM_BAD_ARGUMENT;
    if (status != SM_OK) return status;
    curve->unknowns = 2 * forced->flow->table.modes;
    curve->largest_step = largest_step;
    curve->rates = forced_rates;
    curve->of = forced;
    curve->noise = 0.0;
    return SM_OK;
}

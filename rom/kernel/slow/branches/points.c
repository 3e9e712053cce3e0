/* The slow flow at many points: its rates with everything, and what balances in steady motion. */
#include <math.h>
#include <string.h>

#include "base/check.h"
#include "slow/branches/points.h"
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

void sm_steady_jacobian(const sm_slow_flow *flow, const sm_instant *instant,
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

sm_status sm_steady_point(const sm_slow_flow *flow, const sm_inputs *inputs, int sloped,
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
    status = sm_steady_point(flow, &now, jacobian != NULL, y, instant, &state);
    if (status != SM_OK) return status;
    const sm_modal *const parts[] = {&instant->now.mass, &instant->now.stiffness, &state.force,
                                     &state.rate};
    for (int k = 0; k < 4; k++) put(parts[k], modes, balance + 2 * k * modes);
    if (!sm_all_finite(balance, 8 * (size_t)modes)) return SM_NOT_FINITE;
    if (jacobian) sm_steady_jacobian(flow, instant, &state, jacobian);
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

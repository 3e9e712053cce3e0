/* Steady states of a slow flow, eqs. (22) to (25), whose inputs change along a line, as a solution
 * curve. The equations are F(y, p) = rate / (scale s) = 0 with y = a / (scale s): amplitudes
 * relative to the scale s of the friction limits, at a part p of the line. The continuation
 * (curve.c) evaluates F and its Jacobian; Python and the explorer create the curve. */
#include "slow/branches/forced.h"

#include "base/check.h"

/* Returns the change of the inputs with p: of forces, frequencies and the limit scale. */
static sm_inputs change_of(const sm_forced *forced) {
    const sm_inputs *from = &forced->inputs[0], *to = &forced->inputs[1];
    sm_inputs change = {.limit_scale = to->limit_scale - from->limit_scale};
    for (int j = 0; j < SM_MODES; j++) {
        change.force[j] = to->force[j] - from->force[j];
        change.frequency[j] = to->frequency[j] - from->frequency[j];
    }
    return change;
}

sm_inputs sm_forced_inputs(const sm_forced *forced, double part) {
    const sm_inputs change = change_of(forced);
    const double *slope = (const double *)(const void *)&change;
    sm_inputs at = forced->inputs[0];
    double *value = (double *)(void *)&at;
    for (size_t k = 0; k < SM_INPUT_DOUBLES; k++) value[k] += part * slope[k];
    return at;
}

/* Computes d rate / dp (modes) at constant y. */
static void rate_by_part(const sm_forced *forced, const sm_instant *instant,
                         const sm_flow_state *state, const double *y, sm_complex *rate) {
    const sm_slow_flow *flow = forced->flow;
    const sm_inputs change = change_of(forced);
    sm_coefficients d;
    sm_complex amplitude[SM_MODES], load[SM_MODES], w[SM_MODES];
    sm_coefficients_change(flow, instant, &change, &d);
    for (int j = 0; j < flow->table.modes; j++)
        amplitude[j] = sm_cscale(sm_pair(y + 2 * j), change.limit_scale * forced->scale[j]);
    sm_flow_change(flow, instant, state, amplitude, &d, load, w);
    for (int j = 0; j < flow->table.modes; j++) { /* mass rate + stiffness a = load */
        const sm_complex terms[] = {sm_cmul(d.stiffness[j], state->amplitude[j]),
                                    sm_cmul(d.mass[j], state->rate[j]),
                                    sm_cmul(instant->now.stiffness[j], amplitude[j])};
        for (int k = 0; k < 3; k++) load[j] = sm_csub(load[j], terms[k]);
        rate[j] = sm_cmul(load[j], instant->per_mass[j]);
    }
}

/* Computes F and its Jacobian at z = (y, p) for a checked sm_forced. */
static sm_status forced_rates(const void *of, const double *z, double *F, double *J) {
    const sm_forced *forced = of;
    const int modes = forced->flow->table.modes, k = 2 * modes;
    const sm_inputs inputs = sm_forced_inputs(forced, z[k]);
    SM_TRY(sm_inputs_check(&inputs, modes));
    double size[SM_AMPLITUDES], amplitude[SM_AMPLITUDES], jacobian[SM_AMPLITUDES * SM_AMPLITUDES];
    for (int r = 0; r < k; r++) {
        size[r] = inputs.limit_scale * forced->scale[r / 2];
        amplitude[r] = size[r] * z[r];
    }
    sm_instant instant = {.known = 0};
    sm_flow_state state;
    sm_complex by_part[SM_MODES];
    sm_instant_set(&instant, forced->flow, &inputs);
    SM_TRY(sm_flow_at(forced->flow, &instant, sm_steady_terms(forced->flow), amplitude, &state));
    sm_flow_jacobian(forced->flow, &instant, &state, jacobian);
    rate_by_part(forced, &instant, &state, z, by_part);
    const double growth = change_of(forced).limit_scale / inputs.limit_scale;
    for (int r = 0; r < k; r++) {
        const sm_complex rate = state.rate[r / 2], slope = by_part[r / 2];
        F[r] = (r % 2 ? rate.im : rate.re) / size[r];
        for (int c = 0; c < k; c++) J[r * (k + 1) + c] = jacobian[r * k + c] * size[c] / size[r];
        J[r * (k + 1) + k] = (r % 2 ? slope.im : slope.re) / size[r] - growth * F[r];
    }
    const int finite = sm_all_finite(F, (size_t)k) && sm_all_finite(J, (size_t)(k * (k + 1)));
    return finite ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_forced_curve(const sm_forced *forced, double largest_step, sm_curve *curve) {
    if (!curve || !forced || !forced->flow || !forced->inputs) return SM_BAD_ARGUMENT;
    const int modes = forced->flow->table.modes;
    SM_TRY(sm_slow_flow_check(forced->flow));
    for (int j = 0; j < modes; j++) SM_TRY(sm_check_positive(forced->scale[j]));
    *curve = (sm_curve){2 * modes, largest_step, forced_rates, forced, 0.0};
    return SM_OK;
}

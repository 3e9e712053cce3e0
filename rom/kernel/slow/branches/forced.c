/* Steady states of the slow flow along a line of inputs, as a curve. */
#include "base/check.h"
#include "slow/branches/points.h"
#include "slow/slow_flow.h"

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

static sm_inputs inputs_at(const sm_forced *forced, double p) {
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
    const sm_inputs inputs = inputs_at(forced, z[k]);
    sm_status status = sm_inputs_check(&inputs, modes);
    if (status != SM_OK) return status;
    double size[2 * SM_MODES], y[2 * SM_MODES] = {0.0}, jacobian[4 * SM_MODES * SM_MODES];
    for (int r = 0; r < k; r++) {
        size[r] = inputs.limit_scale * forced->scale[r / 2];
        y[r] = size[r] * z[r];
    }
    sm_instant instant = {.known = 0};
    sm_flow_state state;
    status = sm_steady_point(forced->flow, &inputs, 1, y, &instant, &state);
    if (status != SM_OK) return status;
    sm_modal change;
    sm_steady_jacobian(forced->flow, &instant, &state, jacobian);
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
    return SM_OK;
}

/* The slow flow: amplitude equations (18), (19) in the frame of the forcing.
 *
 * With a_j exp(i theta_j), theta_j' = Omega_j, the equation of mode j is
 *   mass a' + stiffness a = F exp(i ph) / 2 + S_j a / |a| [+ near resonances].
 * The exact equation has an a'' as well. With v(a) the rate without it, a'' is v' along the flow
 * to first order, so a' = v - v' / mass. The paper neglects it.
 */
#include "slow_flow.h"

#include "check.h"
#include "first_order.h"
#include "table.h"

#define MAX_ORDER 1000 /* of a near resonance */

static int near_is_valid(const sm_near *near, int modes) {
    const int most = modes == SM_MODES ? MAX_ORDER : 0;
    return near->mode >= 0 && near->mode < modes && near->n >= -MAX_ORDER &&
           near->n <= MAX_ORDER && near->m >= -most && near->m <= most;
}

sm_status sm_slow_flow_check(const sm_slow_flow *flow) {
    const int modes = flow->table.modes;
    if (modes < 1 || modes > SM_MODES || flow->table.near < 0 || flow->table.near > SM_NEAR)
        return SM_BAD_ARGUMENT;
    for (int j = 0; j < modes; j++) {
        sm_status status = sm_check_positive(flow->natural[j]);
        if (status == SM_OK) status = sm_check_not_negative(flow->damping[j]);
        if (status != SM_OK) return status;
        if (!sm_all_finite(flow->turn[j].c[0], sizeof flow->turn[j].c / sizeof(double)) ||
            !sm_all_finite(flow->shift[j], 2) ||
            !sm_all_finite(flow->across[j][0], sizeof flow->across[j] / sizeof(double)))
            return SM_NOT_FINITE;
    }
    for (int k = 0; k < flow->table.near; k++)
        if (!near_is_valid(&flow->near[k], modes)) return SM_BAD_ARGUMENT;
    return SM_OK;
}

double sm_friction_power(const sm_slow_flow *flow, const sm_instant *instant,
                         const sm_flow_state *state) {
    double power = 0.0;
    for (int j = 0; j < flow->table.modes; j++)
        power -= 2.0 * instant->inputs.frequency[j]
                 * sm_cmul(sm_conj(state->mode[j].amplitude), state->mode[j].force).im;
    if (!flow->table.power) return power;
    const double scale = instant->inputs.limit_scale;
    power += scale * scale * state->slopes[2 * (flow->table.modes + flow->table.near)];
    return power < 0.0 ? 0.0 : power;
}

/* Mean of F cos(theta + ph) q', q' = 2 Re((a' + i Omega a) exp(i theta)). */
static double input_power(const sm_instant *instant, int j, sm_complex a, sm_complex rate) {
    const double Omega = instant->inputs.frequency[j];
    const sm_complex velocity = sm_cx(rate.re - Omega * a.im, rate.im + Omega * a.re);
    return sm_cmul(sm_conj(instant->now[j].excitation), velocity).re;
}

sm_status sm_slow_flow_derivative(const sm_slow_flow *flow, const sm_inputs *now,
                                  sm_instant *instant, const double *y, double *dy) {
    sm_flow_state state;
    sm_instant_set(instant, flow, now);
    const sm_status status = sm_first_order(flow, instant, y, &state);
    if (status != SM_OK) return status;
    sm_flow_change change;
    if (!flow->paper) change = sm_change_along_flow(flow, instant, &state);
    for (int u = 0; u < SM_UNKNOWNS; u++) dy[u] = 0.0;
    dy[SM_DISSIPATED] = sm_friction_power(flow, instant, &state);
    for (int j = 0; j < flow->table.modes; j++) {
        const sm_mode_state *mode = &state.mode[j];
        const sm_complex rate =
            flow->paper ? mode->rate
                        : sm_csub(mode->rate, sm_cmul(change.rate[j], instant->per_mass[j]));
        dy[2 * j] = rate.re;
        dy[2 * j + 1] = rate.im;
        dy[SM_PUT_IN] += input_power(instant, j, mode->amplitude, rate);
    }
    return SM_OK;
}

sm_status sm_slow_flow_check_at(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                                sm_inputs *now) {
    sm_status status = sm_slow_flow_check(flow);
    if (status == SM_OK) status = sm_table_check_shape(&flow->table);
    if (status != SM_OK) return status;
    if (!isfinite(elapsed)) return SM_NOT_FINITE;
    *now = sm_inputs_after(inputs, flow->table.modes, elapsed);
    return sm_inputs_check(now, flow->table.modes);
}

sm_status sm_slow_flow_rate(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                            const double *amplitude, double *rate, double *input_power,
                            double *friction_power) {
    if (!flow || !inputs || !amplitude || !rate || !input_power || !friction_power)
        return SM_BAD_ARGUMENT;
    sm_inputs now;
    sm_status status = sm_slow_flow_check_at(flow, inputs, elapsed, &now);
    if (status != SM_OK) return status;
    const int modes = flow->table.modes;
    double y[SM_UNKNOWNS] = {0.0}, dy[SM_UNKNOWNS];
    sm_instant instant = {.known = 0};
    for (int k = 0; k < 2 * modes; k++) y[k] = amplitude[k];
    status = sm_slow_flow_derivative(flow, &now, &instant, y, dy);
    if (status != SM_OK) return status;
    if (!sm_all_finite(dy, SM_UNKNOWNS)) return SM_NOT_FINITE;
    for (int k = 0; k < 2 * modes; k++) rate[k] = dy[k];
    *input_power = dy[SM_PUT_IN];
    *friction_power = dy[SM_DISSIPATED];
    return SM_OK;
}

/* The slow flow, checked: what callers from outside get. */
#include "slow/slow_flow.h"

#include "base/check.h"
#include "table/table.h"

#define MAX_ORDER 1000 /* of a combination resonance */

static int combination_is_valid(const sm_combination *combination, int modes) {
    const int most = modes == SM_MODES ? MAX_ORDER : 0;
    return combination->mode >= 0 && combination->mode < modes && combination->n >= -MAX_ORDER &&
           combination->n <= MAX_ORDER && combination->m >= -most && combination->m <= most;
}

sm_status sm_slow_flow_check(const sm_slow_flow *flow) {
    const int modes = flow->table.modes;
    if (modes < 1 || modes > SM_MODES || flow->table.combinations < 0
        || flow->table.combinations > SM_COMBINATIONS)
        return SM_BAD_ARGUMENT;
    for (int j = 0; j < modes; j++) {
        const sm_status status = sm_check_positive(flow->natural[j]);
        if (status != SM_OK) return status;
        if (!isfinite(flow->damping[j]) /* < 0 of a self-excited mode */
            || !sm_all_finite(flow->coupling_ratio[j].c[0],
                           sizeof flow->coupling_ratio[j].c / sizeof(double))
            || !sm_all_finite(flow->off_resonance[j], 2)
            || !sm_all_finite(flow->cross_response[j][0],
                              sizeof flow->cross_response[j] / sizeof(double)))
            return SM_NOT_FINITE;
    }
    for (int k = 0; k < flow->table.combinations; k++)
        if (!combination_is_valid(&flow->combination[k], modes)) return SM_BAD_ARGUMENT;
    return sm_table_check_shape(&flow->table);
}

sm_status sm_slow_flow_check_at(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                                sm_inputs *now) {
    const sm_status status = sm_slow_flow_check(flow);
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

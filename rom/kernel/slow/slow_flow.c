/* The slow flow, checked: what callers from outside get. */
#include "slow/slow_flow.h"

#include <math.h>

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
            || !sm_all_finite(flow->coupling_ratio[j][0],
                           sizeof flow->coupling_ratio[j] / sizeof(double))
            || !sm_all_finite(flow->off_resonance[j], 2)
            || !sm_all_finite(flow->cross_response[j][0],
                              sizeof flow->cross_response[j] / sizeof(double))
            || !sm_all_finite(flow->other_modes[j][0],
                              sizeof flow->other_modes[j] / sizeof(double)))
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
                            const double *amplitude, double *rate, double *powers) {
    if (!flow || !inputs || !amplitude || !rate || !powers) return SM_BAD_ARGUMENT;
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
    powers[0] = dy[SM_PUT_IN];
    powers[1] = dy[SM_DISSIPATED];
    return SM_OK;
}

/* ---- derivatives along a direction in amplitudes and inputs ---------------------------------
 *
 * The rates contain the derivative of the table along the flow, so their exact derivative would
 * need its second derivatives. A central difference of the rates is used instead. */

/* Distance of the two points relative to the ranges of amplitudes and inputs. The error of the
 * difference is FAR^2 by its order and 1e-16 / FAR by rounding. */
#define FAR 1e-5

/* A point and a direction through it. */
typedef struct {
    const sm_slow_flow *flow;
    sm_inputs at, along;
    double y[2 * SM_MODES], dy[2 * SM_MODES];
} straight_line;

static sm_status derivative_at(const straight_line *line, double distance, double *derivative) {
    sm_inputs inputs = line->at;
    double *value = (double *)(void *)&inputs, y[SM_UNKNOWNS] = {0.0};
    const double *change = (const double *)(const void *)&line->along;
    for (size_t k = 0; k < sizeof inputs / sizeof *value; k++) value[k] += distance * change[k];
    for (int k = 0; k < 2 * SM_MODES; k++) y[k] = line->y[k] + distance * line->dy[k];
    sm_instant instant = {.known = 0};
    return sm_slow_flow_derivative(line->flow, &inputs, &instant, y, derivative);
}

/* Distance along the line over which nothing changes by more than FAR of its range; of rates, in
 * the time of one radian of the mode. */
static double short_distance(const straight_line *line) {
    const sm_table *table = &line->flow->table;
    const sm_inputs *at = &line->at, *along = &line->along;
    const double range[SM_MODES] = {table->node_a[table->count_a - 1],
                                    table->modes == SM_MODES ? table->node_b[table->count_b - 1]
                                                             : 1.0};
    double size = 0.0;
    for (int j = 0; j < table->modes; j++) {
        const double natural = line->flow->natural[j], elastic = natural * natural * range[j];
        const double sizes[] = {hypot(line->dy[2 * j], line->dy[2 * j + 1]) / range[j],
                                hypot(along->force[j], along->force_rate[j] / natural) / elastic,
                                hypot(along->frequency[j], along->frequency_rate[j] / natural)
                                    / at->frequency[j],
                                hypot(along->phase[j], along->phase_rate[j] / natural),
                                hypot(along->limit_scale, along->limit_scale_rate / natural)
                                    / at->limit_scale,
                                fabs(along->angle[j])};
        for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) size = fmax(size, sizes[k]);
    }
    return size > 0.0 ? FAR / size : 1.0;
}

/* Central difference; one-sided at the edge of the table. */
static sm_status change_along(const straight_line *line, double change[SM_UNKNOWNS]) {
    double here[SM_UNKNOWNS], ahead[SM_UNKNOWNS], behind[SM_UNKNOWNS];
    const double distance = short_distance(line);
    const sm_status status = derivative_at(line, 0.0, here);
    if (status != SM_OK) return status;
    const sm_status forth = derivative_at(line, distance, ahead);
    const sm_status back = derivative_at(line, -distance, behind);
    if (forth != SM_OK && back != SM_OK) return forth;
    const double *to = forth == SM_OK ? ahead : here, *from = back == SM_OK ? behind : here;
    const double length = distance * ((forth == SM_OK) + (back == SM_OK));
    for (int k = 0; k < SM_UNKNOWNS; k++) change[k] = (to[k] - from[k]) / length;
    return SM_OK;
}

sm_status sm_slow_flow_directional(const sm_slow_flow *flow, const sm_slow_point *at,
                                   const sm_slow_point *along, double *d_rate, double *d_powers) {
    if (!flow || !at || !along || !d_rate || !d_powers) return SM_BAD_ARGUMENT;
    if (!at->inputs || !at->amplitude || !along->inputs || !along->amplitude)
        return SM_BAD_ARGUMENT;
    straight_line line = {.flow = flow};
    sm_status status = sm_slow_flow_check_at(flow, at->inputs, 0.0, &line.at);
    if (status != SM_OK) return status;
    const int modes = flow->table.modes;
    line.along = sm_inputs_after(along->inputs, modes, 0.0);
    for (int k = 0; k < 2 * modes; k++) {
        line.y[k] = at->amplitude[k];
        line.dy[k] = along->amplitude[k];
    }
    double change[SM_UNKNOWNS];
    status = change_along(&line, change);
    if (status != SM_OK) return status;
    if (!sm_all_finite(change, SM_UNKNOWNS)) return SM_NOT_FINITE;
    for (int k = 0; k < 2 * modes; k++) d_rate[k] = change[k];
    d_powers[0] = change[SM_PUT_IN];
    d_powers[1] = change[SM_DISSIPATED];
    return SM_OK;
}

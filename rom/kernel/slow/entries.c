/* The slow flow, eqs. (18), (19), at given points, with checks of the arguments: rates with
 * all terms, the terms that balance in steady motion with their Jacobian, and directional
 * derivatives of the rates. Python, the FMU and the explorer call it; the equations are in
 * slow_flow.c. */
#include <math.h>
#include <string.h>

#include "base/check.h"
#include "slow/slow_flow.h"
#include "table/table.h"

/* Returns whether mode and orders of a combination resonance are valid. Relative to its mode it has
 * an order that is larger by 1. */
static int combination_is_valid(const sm_combination *c, int modes) {
    const int most = SM_HIGHEST_ORDER - 1, most_m = modes == SM_MODES ? most : 0;
    return c->mode >= 0 && c->mode < modes && c->n >= -most && c->n <= most && c->m >= -most_m
           && c->m <= most_m;
}

sm_status sm_slow_flow_check(const sm_slow_flow *flow) {
    SM_TRY(sm_table_check_shape(&flow->table));
    SM_TRY(sm_check_not_negative(flow->ratio));
    const int modes = flow->table.modes;
    for (int j = 0; j < modes; j++) {
        SM_TRY(sm_check_positive(flow->natural[j]));
        if (!isfinite(flow->damping[j]) || !isfinite(flow->spin[j])
            || !SM_FINITE(flow->coupling_ratio[j]) || !SM_FINITE(flow->off_resonance[j])
            || !SM_FINITE(flow->cross_response[j]) || !SM_FINITE(flow->other_modes[j])
            || !SM_FINITE(flow->hardening[j]))
            return SM_NOT_FINITE;
    }
    for (int k = 0; k < flow->table.combinations; k++)
        if (!combination_is_valid(&flow->combination[k], modes)) return SM_BAD_ARGUMENT;
    return SM_OK;
}

/* Checks amplitudes (modes, 2) and inputs, `elapsed` seconds after their start, and sets the
 * instant. */
static sm_status set_point(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                           const double *amplitude, sm_instant *instant) {
    const int modes = flow->table.modes;
    const sm_inputs now = sm_inputs_after(inputs, modes, elapsed);
    SM_TRY(sm_inputs_check(&now, modes));
    if (!sm_all_finite(amplitude, 2 * (size_t)modes)) return SM_NOT_FINITE;
    sm_instant_set(instant, flow, &now);
    return SM_OK;
}

sm_status sm_slow_flow_rate(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                            const double *amplitude, double *rate, double *powers) {
    if (!flow || !inputs || !amplitude || !rate || !powers) return SM_BAD_ARGUMENT;
    double dy[SM_UNKNOWNS];
    sm_instant instant = {.known = 0};
    SM_TRY(sm_slow_flow_check(flow));
    SM_TRY(set_point(flow, inputs, elapsed, amplitude, &instant));
    SM_TRY(sm_slow_flow_derivative(flow, &instant, amplitude, dy));
    if (!SM_FINITE(dy)) return SM_NOT_FINITE;
    memcpy(rate, dy, 2 * (size_t)flow->table.modes * sizeof *rate);
    powers[0] = dy[SM_PUT_IN];
    powers[1] = dy[SM_DISSIPATED];
    return SM_OK;
}

/* Sets all values to NaN. */
static void fill_with_nan(double *values, size_t count) {
    for (size_t k = 0; k < count; k++) values[k] = NAN;
}

sm_status sm_slow_flow_rates(const sm_slow_flow *flow, size_t points, const sm_inputs *inputs,
                             const double *amplitude, double *rate) {
    if (!flow || !inputs || !amplitude || !rate) return SM_BAD_ARGUMENT;
    const size_t unknowns = 2 * (size_t)flow->table.modes;
    sm_status worst = SM_OK;
    for (size_t p = 0; p < points; p++, amplitude += unknowns, rate += unknowns) {
        double powers[2];
        const sm_status status =
            sm_slow_flow_rate(flow, inputs + p, 0.0, amplitude, rate, powers);
        if (status != SM_OK && status != SM_OUTSIDE_TABLE) return status;
        if (status == SM_OUTSIDE_TABLE) fill_with_nan(rate, unknowns);
        worst = status == SM_OK ? worst : status;
    }
    return worst;
}

/* ---- steady motion ----------------------------------------------------------------------- */

sm_status sm_slow_flow_balance(const sm_slow_flow *flow, size_t points, const sm_inputs *inputs,
                               const double *amplitude, double *balance, double *jacobian) {
    if (!flow || !inputs || !amplitude || !balance) return SM_BAD_ARGUMENT;
    SM_TRY(sm_slow_flow_check(flow));
    sm_status worst = SM_OK;
    sm_instant instant = {.known = 0};
    const size_t unknowns = 2 * (size_t)flow->table.modes, size = unknowns * sizeof(double);
    for (size_t p = 0; p < points; p++, amplitude += unknowns, balance += 4 * unknowns) {
        double *slopes = jacobian ? jacobian + p * unknowns * unknowns : NULL;
        sm_flow_state state;
        sm_status status = set_point(flow, inputs + p, 0.0, amplitude, &instant);
        if (status == SM_OK)
            status = sm_flow_at(flow, &instant, sm_steady_terms(flow), amplitude, &state);
        if (status != SM_OK && status != SM_OUTSIDE_TABLE) return status;
        if (status == SM_OUTSIDE_TABLE) {
            worst = status;
            fill_with_nan(balance, 4 * unknowns);
            fill_with_nan(slopes, slopes ? unknowns * unknowns : 0);
            continue;
        }
        sm_complex stiffness[SM_MODES];
        for (int j = 0; j < flow->table.modes; j++)
            stiffness[j] = sm_cadd(instant.now.stiffness[j], sm_cx(state.hardening[j], 0.0));
        const sm_complex *const parts[] = {instant.now.mass, stiffness, state.reaction,
                                           state.rate};
        for (size_t k = 0; k < 4; k++) memcpy(balance + k * unknowns, parts[k], size);
        if (!sm_all_finite(balance, 4 * unknowns)) return SM_NOT_FINITE;
        if (slopes) sm_flow_jacobian(flow, &instant, &state, slopes);
    }
    return worst;
}

/* ---- derivatives along a direction in amplitudes and inputs ---------------------------------
 *
 * The rates contain the derivative of the table along the flow, so their exact derivative would
 * need its second derivatives. A central difference of the rates is used instead. */

/* Distance of the points of the central difference, relative to the ranges of amplitudes and
 * inputs [-]. The truncation error is of the order of its square, 1e-10, and the rounding error of
 * the order of 1e-16 / 1e-5 = 1e-11. */
#define RELATIVE_DISTANCE 1e-5

/* Returns the distance along the direction over which nothing changes by more than
 * RELATIVE_DISTANCE of its range; the range of a rate of change is per radian of the mode. */
static double distance_along(const sm_slow_flow *flow, const sm_slow_point *at,
                             const sm_slow_point *along) {
    const sm_table *table = &flow->table;
    const sm_inputs *in = at->inputs, *d = along->inputs;
    double size = 0.0;
    for (int j = 0; j < table->modes; j++) {
        const double range = j == 0 ? table->node_a[table->count_a - 1]
                                    : table->node_b[table->count_b - 1];
        const double omega = flow->natural[j], force = omega * omega * range;
        const double sizes[] = {hypot(along->amplitude[2 * j], along->amplitude[2 * j + 1]) / range,
                                hypot(d->force[j], d->force_rate[j] / omega) / force,
                                hypot(d->frequency[j], d->frequency_rate[j] / omega)
                                    / in->frequency[j],
                                hypot(d->phase[j], d->phase_rate[j] / omega),
                                hypot(d->limit_scale, d->limit_scale_rate / omega)
                                    / in->limit_scale,
                                fabs(d->angle[j])};
        for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) size = fmax(size, sizes[k]);
    }
    return size > 0.0 ? RELATIVE_DISTANCE / size : 1.0;
}

/* Computes rates and powers, (2 modes + 2), at a distance along the direction. */
static sm_status rate_along(const sm_slow_flow *flow, const sm_slow_point *at,
                            const sm_slow_point *along, double distance, double *result) {
    const size_t unknowns = 2 * (size_t)flow->table.modes;
    const double *change = (const double *)(const void *)along->inputs;
    sm_inputs inputs = *at->inputs;
    double *value = (double *)(void *)&inputs, amplitude[SM_AMPLITUDES];
    for (size_t k = 0; k < SM_INPUT_DOUBLES; k++) value[k] += distance * change[k];
    for (size_t k = 0; k < unknowns; k++)
        amplitude[k] = at->amplitude[k] + distance * along->amplitude[k];
    return sm_slow_flow_rate(flow, &inputs, 0.0, amplitude, result, result + unknowns);
}

sm_status sm_slow_flow_directional(const sm_slow_flow *flow, const sm_slow_point *at,
                                   const sm_slow_point *along, double *d_rate, double *d_powers) {
    if (!flow || !at || !along || !d_rate || !d_powers) return SM_BAD_ARGUMENT;
    if (!at->inputs || !at->amplitude || !along->inputs || !along->amplitude)
        return SM_BAD_ARGUMENT;
    double here[SM_UNKNOWNS], ahead[SM_UNKNOWNS], behind[SM_UNKNOWNS];
    SM_TRY(sm_slow_flow_check(flow));
    SM_TRY(rate_along(flow, at, at, 0.0, here));
    /* at the edge of the table the difference is one-sided */
    const size_t unknowns = 2 * (size_t)flow->table.modes;
    const double distance = distance_along(flow, at, along);
    const sm_status forth = rate_along(flow, at, along, distance, ahead);
    const sm_status back = rate_along(flow, at, along, -distance, behind);
    if (forth != SM_OK && back != SM_OK) return forth;
    const double *to = forth == SM_OK ? ahead : here, *from = back == SM_OK ? behind : here;
    const double length = distance * ((forth == SM_OK) + (back == SM_OK));
    for (size_t k = 0; k < unknowns + 2; k++) ahead[k] = (to[k] - from[k]) / length;
    if (!sm_all_finite(ahead, unknowns + 2)) return SM_NOT_FINITE;
    memcpy(d_rate, ahead, unknowns * sizeof *d_rate);
    memcpy(d_powers, ahead + unknowns, 2 * sizeof *d_powers);
    return SM_OK;
}

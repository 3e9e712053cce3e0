#include "first_order.h"

#include <math.h>

#include "table.h"

static sm_complex pair(const double *values) { return sm_cx(values[0], values[1]); }

/* i factor z */
static sm_complex times_i(sm_complex z, double factor) {
    return sm_cx(-factor * z.im, factor * z.re);
}

void sm_feel(const sm_slow_flow *flow, const sm_instant *instant, const double *y,
             sm_mode_state mode[SM_MODES]) {
    mode[1] = (sm_mode_state){.modulus = 0.0}; /* with one mode */
    for (int j = 0; j < flow->table.modes; j++) {
        mode[j].amplitude = pair(y + 2 * j);
        mode[j].moved = sm_cadd(mode[j].amplitude,
                                sm_cmul(pair(flow->shift[j]), instant->now[j].excitation));
        const sm_complex felt = sm_cmul(instant->now[j].turn, mode[j].moved);
        const double modulus = sqrt(sm_cabs2(felt));
        mode[j].modulus = modulus * instant->per_scale;
        /* S a / |a| tends to 0 with a */
        mode[j].unit = modulus > 0.0 ? sm_cscale(felt, 1.0 / modulus) : sm_cx(0.0, 0.0);
    }
}

/* exp(i (n t_A + m t_B - theta_j)), t_j = theta_j + arg a_j. */
static sm_complex near_unit(const sm_near *near, sm_complex wave, sm_complex unit_a,
                            sm_complex unit_b) {
    return sm_cmul(wave, sm_cmul(sm_unit_power(unit_a, near->n), sm_unit_power(unit_b, near->m)));
}

/* Forces of the contacts on the modes, and the rates that they lead to. */
static void answer(const sm_slow_flow *flow, const sm_instant *instant, sm_flow_state *state) {
    const int modes = flow->table.modes;
    sm_mode_state *mode = state->mode;
    for (int j = 0; j < modes; j++)
        mode[j].pull = sm_cmul(pair(state->slopes + 2 * j), mode[j].unit);
    for (int k = 0; k < flow->table.near; k++) {
        const sm_near *near = &flow->near[k];
        sm_complex *pull = &mode[near->mode].pull;
        state->near_unit[k] =
            near_unit(near, instant->near_wave[k], mode[0].unit, mode[1].unit);
        state->near_pull[k] =
            sm_cmul(pair(state->slopes + 2 * (modes + k)), state->near_unit[k]);
        *pull = sm_cadd(*pull, state->near_pull[k]);
    }
    for (int j = 0; j < modes; j++) {
        const sm_coefficients *now = &instant->now[j];
        mode[j].force = sm_cscale(sm_cmul(now->turn, mode[j].pull), instant->inputs.limit_scale);
        const sm_complex force = sm_cadd(sm_cscale(now->excitation, 0.5), mode[j].force);
        mode[j].rate = sm_cmul(sm_csub(force, sm_cmul(now->stiffness, mode[j].amplitude)),
                               instant->per_mass[j]);
    }
}

sm_status sm_first_order(const sm_slow_flow *flow, sm_instant *instant, const double *y,
                         sm_flow_state *state) {
    sm_feel(flow, instant, y, state->mode);
    const double modulus[SM_MODES] = {state->mode[0].modulus, state->mode[1].modulus};
    const sm_status status =
        sm_table_slopes_from(&flow->table, modulus, instant->cell, state->slopes);
    if (status == SM_OK) answer(flow, instant, state);
    return status;
}

#define AT_REST 1e-4 /* radians in which the flow covers an amplitude that counts as none */

/* How what the contacts feel changes. */
typedef struct {
    double modulus, angle;
    sm_complex unit;
    int from_rest;
} felt_change;

/* From rest an amplitude moves straight away: its unit, without a meaning there, is that of the
 * motion. `felt` is relative to the scale of the limits, which itself changes by `scale`. */
static felt_change change_of_felt(const sm_mode_state *mode, double frequency, sm_complex felt,
                                  double scale) {
    const double radians = mode->modulus * frequency, speed2 = sm_cabs2(felt);
    if (radians * radians <= AT_REST * AT_REST * speed2 && speed2 > 0.0) {
        const double speed = sqrt(speed2);
        return (felt_change){speed, 0.0, sm_cscale(felt, 1.0 / speed), 1};
    }
    const sm_complex along = sm_cmul(sm_conj(mode->unit), felt);
    const double angle = mode->modulus > 0.0 ? along.im / mode->modulus : 0.0;
    return (felt_change){along.re - mode->modulus * scale, angle, mode->unit, 0};
}

static sm_complex change_of_column(const double *slopes, size_t fields, int column,
                                   const felt_change *d) {
    const double *in_a = slopes + fields + 2 * column, *in_b = in_a + fields;
    return sm_cx(in_a[0] * d[0].modulus + in_b[0] * d[1].modulus,
                 in_a[1] * d[0].modulus + in_b[1] * d[1].modulus);
}

static void change_of_pulls(const sm_slow_flow *flow, const sm_instant *instant,
                            const sm_flow_state *state, const double *near_angle,
                            const felt_change *d, sm_complex *pull) {
    const int modes = flow->table.modes;
    const double *slopes = state->slopes;
    const size_t fields = 2 * (size_t)(modes + flow->table.near + flow->table.power);
    for (int j = 0; j < modes; j++) {
        const sm_complex grown = change_of_column(slopes, fields, j, d);
        const sm_complex turned = times_i(pair(slopes + 2 * j), d[j].angle);
        pull[j] = sm_cmul(sm_cadd(grown, turned), d[j].unit);
    }
    for (int k = 0; k < flow->table.near; k++) {
        const sm_near *near = &flow->near[k];
        const sm_complex unit =
            d[0].from_rest || d[1].from_rest
                ? near_unit(near, instant->near_wave[k], d[0].unit, d[1].unit)
                : state->near_unit[k];
        const sm_complex grown = change_of_column(slopes, fields, modes + k, d);
        const double angle = near->n * d[0].angle + near->m * d[1].angle + near_angle[k];
        pull[near->mode] = sm_cadd(pull[near->mode],
                                   sm_cadd(sm_cmul(grown, unit),
                                           times_i(state->near_pull[k], angle)));
    }
}

sm_flow_change sm_first_order_change(const sm_slow_flow *flow, const sm_instant *instant,
                                     const sm_flow_state *state, const sm_direction *along) {
    const int modes = flow->table.modes;
    const double scale = along->limit_scale * instant->per_scale; /* relative change */
    felt_change felt[SM_MODES] = {{0.0, 0.0, {0.0, 0.0}, 0}};
    sm_complex pull[SM_MODES];
    sm_flow_change change = {.difference = 0.0};
    for (int j = 0; j < modes; j++) {
        const sm_complex moved =
            sm_cadd(along->amplitude[j],
                    sm_cmul(pair(flow->shift[j]), along->now[j].excitation));
        const sm_complex turned = sm_cadd(sm_cmul(along->now[j].turn, state->mode[j].moved),
                                          sm_cmul(instant->now[j].turn, moved));
        felt[j] = change_of_felt(&state->mode[j], instant->inputs.frequency[j],
                                 sm_cscale(turned, instant->per_scale), scale);
    }
    change_of_pulls(flow, instant, state, along->near_angle, felt, pull);
    for (int j = 0; j < modes; j++) {
        const sm_mode_state *mode = &state->mode[j];
        const sm_coefficients *now = &instant->now[j], *d = &along->now[j];
        const sm_complex pulled =
            sm_cadd(sm_cmul(d->turn, mode->pull), sm_cmul(now->turn, pull[j]));
        change.force[j] = sm_cadd(sm_cscale(pulled, instant->inputs.limit_scale),
                                  sm_cscale(mode->force, scale));
        const sm_complex drive = sm_cadd(sm_cscale(d->excitation, 0.5), change.force[j]);
        const sm_complex elastic = sm_cadd(sm_cmul(d->stiffness, mode->amplitude),
                                           sm_cmul(now->stiffness, along->amplitude[j]));
        const sm_complex inertial = sm_cmul(d->mass, mode->rate);
        change.rate[j] = sm_cmul(sm_csub(drive, sm_cadd(elastic, inertial)), instant->per_mass[j]);
    }
    if (flow->table.power) {
        const size_t fields = 2 * (size_t)(modes + flow->table.near + 1);
        change.difference =
            change_of_column(state->slopes, fields, modes + flow->table.near, felt).re;
    }
    return change;
}

sm_flow_change sm_change_along_flow(const sm_slow_flow *flow, const sm_instant *instant,
                                    const sm_flow_state *state) {
    const sm_direction along = {.amplitude = {state->mode[0].rate, state->mode[1].rate},
                                .now = instant->rate,
                                .near_angle = instant->near_rate,
                                .limit_scale = instant->inputs.limit_scale_rate};
    return sm_first_order_change(flow, instant, state, &along);
}

/* The slow flow: amplitude equations (18), (19) in the frame of the forcing.
 *
 * With a_j exp(i theta_j), theta_j' = Omega_j, the equation of mode j is
 *   mass a' + stiffness a = F exp(i ph) / 2 + S_j a / |a| [+ near resonances].
 * The exact equation has an a'' as well. With v(a) the rate without it, a'' is v' along the flow
 * to first order, so a' = v - v' / mass. The paper neglects it.
 */
#include "first_order.h"

#include <math.h>

#include "lanes.h"
#include "slow_flow.h"
#include "table.h"

SM_INLINE sm_complex pair(const double *values) { return sm_cx(values[0], values[1]); }

/* i factor z */
SM_INLINE sm_complex times_i(sm_complex z, double factor) {
    return sm_cx(-factor * z.im, factor * z.re);
}

SM_INLINE void feel(const sm_instant *instant, int modes, const double *y, sm_mode_state *mode) {
    if (modes < SM_MODES) mode[1] = (sm_mode_state){.modulus = 0.0};
    for (int j = 0; j < modes; j++) {
        const sm_factors *by = &instant->factor[j];
        const sm_complex a = pair(y + 2 * j);
        const sm_complex felt = sm_cadd(sm_cmul(by->feel, a), by->felt_force);
        const double modulus = sqrt(sm_cabs2(felt));
        mode[j].amplitude = a;
        mode[j].modulus = modulus;
        /* S a / |a| tends to 0 with a */
        mode[j].per_modulus = modulus > 0.0 ? 1.0 / modulus : 0.0;
        mode[j].unit = sm_cscale(felt, mode[j].per_modulus);
    }
}

void sm_feel(const sm_slow_flow *flow, const sm_instant *instant, const double *y,
             sm_mode_state mode[SM_MODES]) {
    feel(instant, flow->table.modes, y, mode);
}

/* exp(i (n t_A + m t_B - theta_j)), t_j = theta_j + arg a_j. */
SM_INLINE sm_complex near_unit(const sm_near *near, sm_complex wave,
                               const sm_complex unit[SM_MODES]) {
    return sm_cmul(wave,
                   sm_cmul(sm_unit_power(unit[0], near->n), sm_unit_power(unit[1], near->m)));
}

/* Those of all near resonances. Where angles are equal or opposite, less t_j of their mode, one
 * follows from the other; not at rest, where the units are no units. */
SM_INLINE void near_units(const sm_slow_flow *flow, const sm_instant *instant, int at_rest,
                          const sm_complex unit[SM_MODES], sm_complex *of_near) {
    const sm_near *near = flow->near;
    for (int k = 0; k < flow->table.near; k++) {
        const int like_first = at_rest ? 0 : instant->like_first[k];
        if (like_first == 0) {
            of_near[k] = near_unit(&near[k], instant->near_wave[k], unit);
            continue;
        }
        const sm_complex loop = sm_cmul(of_near[0], sm_conj(unit[near[0].mode]));
        of_near[k] = sm_cmul(like_first > 0 ? loop : sm_conj(loop), unit[near[k].mode]);
    }
}

/* Forces of the contacts on the modes, and the rates that they lead to. */
SM_INLINE void answer(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                      sm_flow_state *state) {
    sm_mode_state *mode = state->mode;
    for (int j = 0; j < modes; j++)
        mode[j].pull = sm_cmul(pair(state->slopes + 2 * j), mode[j].unit);
    for (int k = 0; k < flow->table.near; k++) {
        sm_complex *pull = &mode[flow->near[k].mode].pull;
        state->near_pull[k] =
            sm_cmul(pair(state->slopes + 2 * (modes + k)), state->near_unit[k]);
        *pull = sm_cadd(*pull, state->near_pull[k]);
    }
    for (int j = 0; j < modes; j++) {
        const sm_factors *by = &instant->factor[j];
        const sm_complex linear = sm_csub(by->drive, sm_cmul(by->spring, mode[j].amplitude));
        mode[j].force = sm_cmul(by->grip, mode[j].pull);
        mode[j].rate = sm_cadd(linear, sm_cmul(by->push, mode[j].pull));
    }
}

/* With slopes of the first `sloped` columns of the table. */
SM_INLINE sm_status first_order(const sm_slow_flow *flow, sm_instant *instant, int modes,
                                size_t sloped, const double *y, sm_flow_state *state) {
    feel(instant, modes, y, state->mode);
    const double modulus[SM_MODES] = {state->mode[0].modulus, state->mode[1].modulus};
    const sm_complex unit[SM_MODES] = {state->mode[0].unit, state->mode[1].unit};
    near_units(flow, instant, modulus[0] == 0.0 || modulus[1] == 0.0, unit, state->near_unit);
    const sm_status status =
        sm_table_slopes_from(&flow->table, modulus, sloped, instant->cell, state->slopes);
    if (status == SM_OK) answer(flow, instant, modes, state);
    return status;
}

sm_status sm_first_order(const sm_slow_flow *flow, sm_instant *instant, const double *y,
                         sm_flow_state *state) {
    const sm_table *table = &flow->table;
    const size_t columns = 2 * (size_t)(table->modes + table->near + table->power);
    return first_order(flow, instant, table->modes, columns, y, state);
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
SM_INLINE felt_change change_of_felt(const sm_mode_state *mode, double frequency, sm_complex felt,
                                     double scale) {
    const double radians = mode->modulus * frequency, speed2 = sm_cabs2(felt);
    if (radians * radians <= AT_REST * AT_REST * speed2 && speed2 > 0.0) {
        const double speed = sqrt(speed2);
        return (felt_change){speed, 0.0, sm_cscale(felt, 1.0 / speed), 1};
    }
    const sm_complex along = sm_cmul(sm_conj(mode->unit), felt);
    return (felt_change){along.re - mode->modulus * scale, along.im * mode->per_modulus,
                         mode->unit, 0};
}

SM_INLINE sm_complex change_of_column(const double *slopes, size_t fields, int column,
                                      const felt_change *d) {
    const double *in_a = slopes + fields + 2 * column, *in_b = in_a + fields;
    return sm_cx(in_a[0] * d[0].modulus + in_b[0] * d[1].modulus,
                 in_a[1] * d[0].modulus + in_b[1] * d[1].modulus);
}

SM_INLINE void change_of_pulls(const sm_slow_flow *flow, const sm_instant *instant,
                               const sm_flow_state *state, int modes,
                               const double *near_angle, const felt_change *d,
                               sm_complex *pull) {
    const double *slopes = state->slopes;
    const size_t fields = 2 * (size_t)(modes + flow->table.near + flow->table.power);
    for (int j = 0; j < modes; j++) {
        const sm_complex grown = change_of_column(slopes, fields, j, d);
        const sm_complex turned = times_i(pair(slopes + 2 * j), d[j].angle);
        pull[j] = sm_cmul(sm_cadd(grown, turned), d[j].unit);
    }
    for (int k = 0; k < flow->table.near; k++) {
        const sm_near *near = &flow->near[k];
        const sm_complex moving[SM_MODES] = {d[0].unit, d[1].unit};
        const sm_complex unit = d[0].from_rest || d[1].from_rest
                                    ? near_unit(near, instant->near_wave[k], moving)
                                    : state->near_unit[k];
        const sm_complex grown = change_of_column(slopes, fields, modes + k, d);
        const double angle = near->n * d[0].angle + near->m * d[1].angle + near_angle[k];
        pull[near->mode] = sm_cadd(pull[near->mode],
                                   sm_cadd(sm_cmul(grown, unit),
                                           times_i(state->near_pull[k], angle)));
    }
}

/* `modes` and `moving` are literals: whether more than the angles of the inputs changes. */
SM_INLINE sm_flow_change change_along(const sm_slow_flow *flow, const sm_instant *instant,
                                      const sm_flow_state *state, const sm_direction *along,
                                      int modes, int moving) {
    const double scale = moving ? along->limit_scale * instant->per_scale : 0.0; /* relative */
    felt_change felt[SM_MODES] = {{0.0, 0.0, {0.0, 0.0}, 0}};
    sm_complex pull[SM_MODES];
    sm_flow_change change = {.difference = 0.0};
    for (int j = 0; j < modes; j++) {
        const sm_mode_state *mode = &state->mode[j];
        sm_complex turned = sm_cmul(instant->factor[j].feel, along->amplitude[j]);
        if (moving) {
            const sm_coefficients *d = &along->now[j];
            const sm_complex shift = pair(flow->shift[j]);
            const sm_complex moved =
                sm_cadd(mode->amplitude, sm_cmul(shift, instant->now[j].excitation));
            const sm_complex driven = sm_cadd(
                sm_cmul(d->turn, moved),
                sm_cmul(instant->now[j].turn, sm_cmul(shift, d->excitation)));
            turned = sm_cadd(turned, sm_cscale(driven, instant->per_scale));
        }
        felt[j] = change_of_felt(mode, instant->inputs.frequency[j], turned, scale);
    }
    change_of_pulls(flow, instant, state, modes, along->near_angle, felt, pull);
    for (int j = 0; j < modes; j++) {
        const sm_mode_state *mode = &state->mode[j];
        const sm_factors *by = &instant->factor[j];
        change.force[j] = sm_cmul(by->grip, pull[j]);
        change.rate[j] = sm_csub(sm_cmul(by->push, pull[j]),
                                 sm_cmul(by->spring, along->amplitude[j]));
        if (!moving) continue;
        const sm_coefficients *d = &along->now[j];
        const sm_complex regripped =
            sm_cadd(sm_cscale(sm_cmul(d->turn, mode->pull), instant->inputs.limit_scale),
                    sm_cscale(mode->force, scale));
        const sm_complex drive = sm_cadd(sm_cscale(d->excitation, 0.5), regripped);
        const sm_complex rest = sm_cadd(sm_cmul(d->stiffness, mode->amplitude),
                                        sm_cmul(d->mass, mode->rate));
        change.force[j] = sm_cadd(change.force[j], regripped);
        change.rate[j] =
            sm_cadd(change.rate[j], sm_cmul(sm_csub(drive, rest), instant->per_mass[j]));
    }
    if (flow->table.power) {
        const size_t fields = 2 * (size_t)(modes + flow->table.near + 1);
        change.difference =
            change_of_column(state->slopes, fields, modes + flow->table.near, felt).re;
    }
    return change;
}

sm_flow_change sm_first_order_change(const sm_slow_flow *flow, const sm_instant *instant,
                                     const sm_flow_state *state, const sm_direction *along) {
    return change_along(flow, instant, state, along, flow->table.modes, 1);
}

SM_INLINE sm_flow_change along_flow(const sm_slow_flow *flow, const sm_instant *instant,
                                    const sm_flow_state *state, int modes, int moving) {
    const sm_direction along = {.amplitude = {state->mode[0].rate, state->mode[1].rate},
                                .now = moving ? instant->rate : NULL,
                                .near_angle = instant->near_rate,
                                .limit_scale = instant->inputs.limit_scale_rate};
    return change_along(flow, instant, state, &along, modes, moving);
}

sm_flow_change sm_change_along_flow(const sm_slow_flow *flow, const sm_instant *instant,
                                    const sm_flow_state *state) {
    return along_flow(flow, instant, state, flow->table.modes, 1);
}

SM_INLINE double friction_power(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                                const sm_flow_state *state) {
    double power = 0.0;
    for (int j = 0; j < modes; j++)
        power -= 2.0 * instant->inputs.frequency[j]
                 * sm_cmul(sm_conj(state->mode[j].amplitude), state->mode[j].force).im;
    if (!flow->table.power) return power;
    const double scale = instant->inputs.limit_scale;
    power += scale * scale * state->slopes[2 * (modes + flow->table.near)];
    return power < 0.0 ? 0.0 : power;
}

double sm_friction_power(const sm_slow_flow *flow, const sm_instant *instant,
                         const sm_flow_state *state) {
    return friction_power(flow, instant, flow->table.modes, state);
}

/* Mean of F cos(theta + ph) q', q' = 2 Re((a' + i Omega a) exp(i theta)). */
SM_INLINE double input_power(const sm_instant *instant, int j, sm_complex a, sm_complex rate) {
    const double Omega = instant->inputs.frequency[j];
    const sm_complex velocity = sm_cx(rate.re - Omega * a.im, rate.im + Omega * a.re);
    return sm_cmul(sm_conj(instant->now[j].excitation), velocity).re;
}

/* `modes` and `moving` are literals, as in `change_along`. */
SM_INLINE sm_status derivative(const sm_slow_flow *flow, sm_instant *instant, int modes,
                               int moving, const double *y, double *dy) {
    sm_flow_state state;
    const size_t forces = 2 * (size_t)(modes + flow->table.near); /* no slopes of powers needed */
    const sm_status status = first_order(flow, instant, modes, forces, y, &state);
    if (status != SM_OK) return status;
    sm_flow_change change;
    if (!flow->paper) change = along_flow(flow, instant, &state, modes, moving);
    if (modes < SM_MODES) dy[2] = dy[3] = 0.0;
    dy[SM_DISSIPATED] = friction_power(flow, instant, modes, &state);
    dy[SM_PUT_IN] = 0.0;
    for (int j = 0; j < modes; j++) {
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

SM_HOT_ONE sm_status sm_slow_flow_derivative_at(const sm_slow_flow *flow, sm_instant *instant,
                                                const double *y, double *dy) {
    if (flow->table.modes == 1)
        return instant->held ? derivative(flow, instant, 1, 0, y, dy)
                             : derivative(flow, instant, 1, 1, y, dy);
    return instant->held ? derivative(flow, instant, SM_MODES, 0, y, dy)
                         : derivative(flow, instant, SM_MODES, 1, y, dy);
}

sm_status sm_slow_flow_derivative(const sm_slow_flow *flow, const sm_inputs *now,
                                  sm_instant *instant, const double *y, double *dy) {
    sm_instant_set(instant, flow, now);
    return sm_slow_flow_derivative_at(flow, instant, y, dy);
}

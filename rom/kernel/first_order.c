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

/* `modes` is a literal, here and below. */
SM_INLINE void feel(const sm_instant *instant, int modes, const double *y, sm_felt *felt) {
    const sm_factors *by = &instant->factor;
    if (modes < SM_MODES) *felt = (sm_felt){.modulus = {0.0}};
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex a = pair(y + 2 * j);
        const sm_complex z = sm_cadd(sm_cmul(sm_of(&by->feel, j), a), sm_of(&by->felt_force, j));
        const double modulus = sqrt(sm_cabs2(z));
        /* S a / |a| tends to 0 with a */
        const double per_modulus = modulus > 0.0 ? 1.0 / modulus : 0.0;
        sm_put(&felt->amplitude, j, a);
        sm_put(&felt->unit, j, sm_cscale(z, per_modulus));
        felt->modulus[j] = modulus;
        felt->per_modulus[j] = per_modulus;
    }
}

void sm_feel(const sm_slow_flow *flow, const sm_instant *instant, const double *y, sm_felt *felt) {
    if (flow->table.modes == 1)
        feel(instant, 1, y, felt);
    else
        feel(instant, SM_MODES, y, felt);
}

/* exp(i (n t_A + m t_B - theta_j)), t_j = theta_j + arg a_j. */
SM_INLINE sm_complex near_unit(const sm_near *near, sm_complex wave, const sm_modal *unit) {
    return sm_cmul(wave, sm_cmul(sm_unit_power(sm_of(unit, 0), near->n),
                                 sm_unit_power(sm_of(unit, 1), near->m)));
}

/* Those of all near resonances. Where angles are equal or opposite, less t_j of their mode, one
 * follows from the other; not at rest, where the units are no units. */
SM_INLINE void near_units(const sm_slow_flow *flow, const sm_instant *instant,
                          const sm_felt *felt, sm_complex *of_near) {
    const int at_rest = felt->modulus[0] == 0.0 || felt->modulus[1] == 0.0;
    const sm_near *near = flow->near;
    for (int k = 0; k < flow->table.near; k++) {
        const int like_first = at_rest ? 0 : instant->like_first[k];
        if (like_first == 0) {
            of_near[k] = near_unit(&near[k], instant->near_wave[k], &felt->unit);
            continue;
        }
        const sm_complex loop = sm_cmul(of_near[0], sm_conj(sm_of(&felt->unit, near[0].mode)));
        const sm_complex turned = sm_cx(loop.re, like_first * loop.im);
        of_near[k] = sm_cmul(turned, sm_of(&felt->unit, near[k].mode));
    }
}

/* Forces of the contacts on the modes, and the rates that they lead to. */
SM_INLINE void answer(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                      sm_flow_state *state) {
    const sm_factors *by = &instant->factor;
    const double *S = state->slopes, *T = S + 2 * modes;
    sm_modal near = {{0.0}, {0.0}};
    for (int k = 0; k < flow->table.near; k++) {
        const sm_complex pull = sm_cmul(pair(T + 2 * k), state->near_unit[k]);
        state->near_pull[k] = pull;
        SM_SIMD
        for (int j = 0; j < modes; j++) {
            near.re[j] += instant->near_on[k][j] * pull.re;
            near.im[j] += instant->near_on[k][j] * pull.im;
        }
    }
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex a = sm_of(&state->felt.amplitude, j), unit = sm_of(&state->felt.unit, j);
        const sm_complex pull = sm_cadd(sm_cmul(pair(S + 2 * j), unit), sm_of(&near, j));
        const sm_complex linear =
            sm_csub(sm_of(&by->drive, j), sm_cmul(sm_of(&by->spring, j), a));
        sm_put(&state->pull, j, pull);
        sm_put(&state->force, j, sm_cmul(sm_of(&by->grip, j), pull));
        sm_put(&state->rate, j, sm_cadd(linear, sm_cmul(sm_of(&by->push, j), pull)));
    }
}

/* With slopes of the first `sloped` columns of the table. */
SM_INLINE sm_status first_order(const sm_slow_flow *flow, sm_instant *instant, int modes,
                                size_t sloped, const double *y, sm_flow_state *state) {
    feel(instant, modes, y, &state->felt);
    near_units(flow, instant, &state->felt, state->near_unit);
    const sm_status status =
        sm_table_slopes_from(&flow->table, state->felt.modulus, sloped, instant->cell, state->slopes);
    if (status == SM_OK) answer(flow, instant, modes, state);
    return status;
}

sm_status sm_first_order(const sm_slow_flow *flow, sm_instant *instant, const double *y,
                         sm_flow_state *state) {
    const sm_table *table = &flow->table;
    const size_t columns = 2 * (size_t)(table->modes + table->near + table->power);
    return table->modes == 1 ? first_order(flow, instant, 1, columns, y, state)
                             : first_order(flow, instant, SM_MODES, columns, y, state);
}

#define AT_REST 1e-4 /* radians in which the flow covers an amplitude that counts as none */

/* How what the contacts feel changes. */
typedef struct {
    double modulus[SM_MODES], angle[SM_MODES];
    sm_modal unit;
    int from_rest; /* 1: a mode of those */
} felt_change;

/* From rest an amplitude moves straight away: its unit, without a meaning there, is that of the
 * motion. `turned`: how what is felt changes relative to the scale of the limits, which itself
 * changes by `scale`. */
SM_INLINE void change_of_felt(const sm_instant *instant, const sm_felt *felt, int modes,
                              const sm_modal *turned, double scale, felt_change *d) {
    double radians2[SM_MODES], speed2[SM_MODES];
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex unit = sm_of(&felt->unit, j), z = sm_of(turned, j);
        const sm_complex along = sm_cmul(sm_conj(unit), z);
        const double radians = felt->modulus[j] * instant->inputs.frequency[j];
        radians2[j] = radians * radians;
        speed2[j] = AT_REST * AT_REST * sm_cabs2(z);
        d->modulus[j] = along.re - felt->modulus[j] * scale;
        d->angle[j] = along.im * felt->per_modulus[j];
        sm_put(&d->unit, j, unit);
    }
    d->from_rest = 0;
    for (int j = 0; j < modes; j++) {
        if (radians2[j] > speed2[j] || speed2[j] == 0.0) continue;
        const sm_complex z = sm_of(turned, j);
        d->modulus[j] = sqrt(sm_cabs2(z));
        d->angle[j] = 0.0;
        sm_put(&d->unit, j, sm_cscale(z, 1.0 / d->modulus[j]));
        d->from_rest = 1;
    }
}

SM_INLINE sm_complex change_of_column(const double *slopes, size_t fields, int modes, int column,
                                      const felt_change *d) {
    const double *in_a = slopes + fields + 2 * column, *in_b = in_a + fields;
    if (modes == 1) return sm_cscale(pair(in_a), d->modulus[0]);
    return sm_cadd(sm_cscale(pair(in_a), d->modulus[0]), sm_cscale(pair(in_b), d->modulus[1]));
}

SM_INLINE void change_of_pulls(const sm_slow_flow *flow, const sm_instant *instant,
                               const sm_flow_state *state, int modes, const double *near_angle,
                               const felt_change *d, sm_modal *pull) {
    const double *slopes = state->slopes;
    const size_t fields = 2 * (size_t)(modes + flow->table.near + flow->table.power);
    sm_modal by_near = {{0.0}, {0.0}};
    for (int k = 0; k < flow->table.near; k++) {
        const sm_near *near = &flow->near[k];
        sm_complex unit = state->near_unit[k];
        double angle = near->n * d->angle[0] + near_angle[k];
        if (modes == SM_MODES) angle += near->m * d->angle[1];
        if (d->from_rest) unit = near_unit(near, instant->near_wave[k], &d->unit);
        const sm_complex grown = change_of_column(slopes, fields, modes, modes + k, d);
        const sm_complex change =
            sm_cadd(sm_cmul(grown, unit), times_i(state->near_pull[k], angle));
        SM_SIMD
        for (int j = 0; j < modes; j++) {
            by_near.re[j] += instant->near_on[k][j] * change.re;
            by_near.im[j] += instant->near_on[k][j] * change.im;
        }
    }
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex grown = change_of_column(slopes, fields, modes, j, d);
        const sm_complex turned = times_i(pair(slopes + 2 * j), d->angle[j]);
        sm_put(pull, j, sm_cadd(sm_cmul(sm_cadd(grown, turned), sm_of(&d->unit, j)),
                                sm_of(&by_near, j)));
    }
}

/* `moving` is a literal too: whether more than the angles of the inputs changes. */
SM_INLINE void change_along(const sm_slow_flow *flow, const sm_instant *instant,
                            const sm_flow_state *state, const sm_direction *along, int modes,
                            int moving, sm_flow_change *change) {
    const sm_factors *by = &instant->factor;
    const sm_coefficients *now = &instant->now, *d = along->now;
    const double scale = moving ? along->limit_scale * instant->per_scale : 0.0; /* relative */
    sm_modal turned, pull;
    felt_change felt;
    if (modes < SM_MODES) felt = (felt_change){.modulus = {0.0}};
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        sm_complex z = sm_cmul(sm_of(&by->feel, j), sm_of(along->amplitude, j));
        if (moving) {
            const sm_complex shift = pair(flow->shift[j]);
            const sm_complex moved = sm_cadd(sm_of(&state->felt.amplitude, j),
                                             sm_cmul(shift, sm_of(&now->excitation, j)));
            const sm_complex driven =
                sm_cadd(sm_cmul(sm_of(&d->turn, j), moved),
                        sm_cmul(sm_of(&now->turn, j),
                                sm_cmul(shift, sm_of(&d->excitation, j))));
            z = sm_cadd(z, sm_cscale(driven, instant->per_scale));
        }
        sm_put(&turned, j, z);
    }
    change_of_felt(instant, &state->felt, modes, &turned, scale, &felt);
    change_of_pulls(flow, instant, state, modes, along->near_angle, &felt, &pull);
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex pulled = sm_of(&pull, j);
        sm_complex force = sm_cmul(sm_of(&by->grip, j), pulled);
        sm_complex rate = sm_csub(sm_cmul(sm_of(&by->push, j), pulled),
                                  sm_cmul(sm_of(&by->spring, j), sm_of(along->amplitude, j)));
        if (moving) {
            const sm_complex regripped =
                sm_cadd(sm_cscale(sm_cmul(sm_of(&d->turn, j), sm_of(&state->pull, j)),
                                  instant->inputs.limit_scale),
                        sm_cscale(sm_of(&state->force, j), scale));
            const sm_complex drive =
                sm_cadd(sm_cscale(sm_of(&d->excitation, j), 0.5), regripped);
            const sm_complex rest =
                sm_cadd(sm_cmul(sm_of(&d->stiffness, j), sm_of(&state->felt.amplitude, j)),
                        sm_cmul(sm_of(&d->mass, j), sm_of(&state->rate, j)));
            force = sm_cadd(force, regripped);
            rate = sm_cadd(rate, sm_cmul(sm_csub(drive, rest), sm_of(&instant->per_mass, j)));
        }
        sm_put(&change->force, j, force);
        sm_put(&change->rate, j, rate);
    }
    change->difference = 0.0;
    if (flow->table.power) {
        const size_t fields = 2 * (size_t)(modes + flow->table.near + 1);
        change->difference =
            change_of_column(state->slopes, fields, modes, modes + flow->table.near, &felt).re;
    }
}

void sm_first_order_change(const sm_slow_flow *flow, const sm_instant *instant,
                           const sm_flow_state *state, const sm_direction *along,
                           sm_flow_change *change) {
    if (flow->table.modes == 1)
        change_along(flow, instant, state, along, 1, 1, change);
    else
        change_along(flow, instant, state, along, SM_MODES, 1, change);
}

SM_INLINE void along_flow(const sm_slow_flow *flow, const sm_instant *instant,
                          const sm_flow_state *state, int modes, int moving,
                          sm_flow_change *change) {
    const sm_direction along = {.amplitude = &state->rate,
                                .now = &instant->rate,
                                .near_angle = instant->near_rate,
                                .limit_scale = instant->inputs.limit_scale_rate};
    change_along(flow, instant, state, &along, modes, moving, change);
}

void sm_change_along_flow(const sm_slow_flow *flow, const sm_instant *instant,
                          const sm_flow_state *state, sm_flow_change *change) {
    if (flow->table.modes == 1)
        along_flow(flow, instant, state, 1, 1, change);
    else
        along_flow(flow, instant, state, SM_MODES, 1, change);
}

SM_INLINE double friction_power(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                                const sm_flow_state *state) {
    double leaves[SM_MODES] = {0.0};
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex a = sm_of(&state->felt.amplitude, j), force = sm_of(&state->force, j);
        leaves[j] = -2.0 * instant->inputs.frequency[j] * sm_cmul(sm_conj(a), force).im;
    }
    double power = leaves[0] + leaves[1];
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
SM_INLINE double input_power(double Omega, sm_complex excitation, sm_complex a, sm_complex rate) {
    const sm_complex velocity = sm_cx(rate.re - Omega * a.im, rate.im + Omega * a.re);
    return sm_cmul(sm_conj(excitation), velocity).re;
}

SM_INLINE sm_status derivative(const sm_slow_flow *flow, sm_instant *instant, int modes,
                               int moving, const double *y, double *dy) {
    sm_flow_state state;
    const size_t forces = 2 * (size_t)(modes + flow->table.near); /* no slopes of powers needed */
    const sm_status status = first_order(flow, instant, modes, forces, y, &state);
    if (status != SM_OK) return status;
    sm_flow_change change; /* of a', which the paper neglects */
    if (flow->paper)
        change = (sm_flow_change){.difference = 0.0};
    else
        along_flow(flow, instant, &state, modes, moving, &change);
    double put_in[SM_MODES] = {0.0};
    if (modes < SM_MODES) dy[2] = dy[3] = 0.0;
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex bend = sm_cmul(sm_of(&change.rate, j), sm_of(&instant->per_mass, j));
        const sm_complex rate = sm_csub(sm_of(&state.rate, j), bend);
        dy[2 * j] = rate.re;
        dy[2 * j + 1] = rate.im;
        put_in[j] = input_power(instant->inputs.frequency[j], sm_of(&instant->now.excitation, j),
                                sm_of(&state.felt.amplitude, j), rate);
    }
    dy[SM_DISSIPATED] = friction_power(flow, instant, modes, &state);
    dy[SM_PUT_IN] = put_in[0] + put_in[1];
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

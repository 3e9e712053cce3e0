/* The slow flow: amplitude equations (18), (19) in the frame of the forcing.
 *
 * With a_j exp(i theta_j), theta_j' = Omega_j, the equation of mode j is
 *   mass a' + stiffness a = F exp(i ph) / 2 + S_j a / |a| [+ near resonances].
 * The exact equation has an a'' as well. With v(a) the rate without it, a'' is v' along the flow
 * to first order, so a' = v - v' / mass. The paper neglects it. To the same order friction lags
 * behind what it is in steady motion, by lag_jk d|a_k|/dt: a contact that sticks holds what the last
 * reversal left, as large as the amplitude was then.
 */
#include "slow/first_order.h"

#include <math.h>

#include "base/lanes.h"
#include "slow/combination.h"
#include "slow/slow_flow.h"
#include "table/table.h"

SM_INLINE sm_complex pair(const double *values) { return sm_cx(values[0], values[1]); }

/* i factor z */
SM_INLINE sm_complex times_i(sm_complex z, double factor) {
    return sm_cx(-factor * z.im, factor * z.re);
}

#define AT_REST 1e-300 /* square of a modulus: less is near the denormals, and none */

/* `modes` is a literal, here and below. */
SM_INLINE void feel(const sm_instant *instant, int modes, const double *y, sm_felt *felt) {
    const sm_factors *by = &instant->factor;
    if (modes < SM_MODES) *felt = (sm_felt){.modulus = {0.0}};
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex a = pair(y + 2 * j);
        const sm_complex z = sm_cadd(sm_cmul(sm_of(&by->feel, j), a), sm_of(&by->felt_force, j));
        const double square = sm_cabs2(z), modulus = square < AT_REST ? 0.0 : sqrt(square);
        /* as 1 / modulus, but root and division side by side */
        const double per_modulus = square < AT_REST ? 0.0 : modulus * (1.0 / square);
        const sm_complex unit = sm_cscale(z, per_modulus);
        sm_put(&felt->amplitude, j, a);
        sm_put(&felt->unit, j, sm_cx(square < AT_REST ? 1.0 : unit.re, unit.im));
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

/* Forces of the contacts on the modes, and the rates that they lead to. */
SM_INLINE void answer(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                      sm_flow_state *state) {
    const sm_factors *by = &instant->factor;
    const double *S = state->slopes, *T = S + 2 * modes;
    sm_modal strength;
    SM_SIMD
    for (int j = 0; j < modes; j++) sm_put(&strength, j, pair(S + 2 * j));
    for (int k = 0; k < flow->table.near; k++)
        sm_add_near(instant, k, modes, sm_cmul(pair(T + 2 * k), state->near_turn[k]), &strength);
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex a = sm_of(&state->felt.amplitude, j), unit = sm_of(&state->felt.unit, j);
        const sm_complex pull = sm_cmul(sm_of(&strength, j), unit);
        /* what the strength is multiplied by does not wait for it to be looked up */
        const sm_complex lever = sm_cmul(sm_of(&by->push, j), unit);
        const sm_complex linear =
            sm_csub(sm_of(&by->drive, j), sm_cmul(sm_of(&by->spring, j), a));
        sm_put(&state->pull, j, pull);
        sm_put(&state->force, j, sm_cmul(sm_of(&by->grip, j), pull));
        sm_put(&state->rate, j, sm_cadd(linear, sm_cmul(lever, sm_of(&strength, j))));
    }
}

/* With slopes of the first `sloped` columns of the table. */
SM_INLINE sm_status first_order(const sm_slow_flow *flow, sm_instant *instant, int modes,
                                size_t sloped, const double *y, sm_flow_state *state) {
    feel(instant, modes, y, &state->felt);
    sm_near_turns(flow, instant, &state->felt.unit, state->felt.modulus, state->near_turn);
    const sm_status status = sm_table_slopes_from(&flow->table, state->felt.modulus, sloped,
                                                  instant->cell, state->slopes, state->lag);
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

#define SETS_OFF 1e-4 /* radians in which the flow covers an amplitude that counts as none */

/* How what the contacts feel changes. */
typedef struct {
    double modulus[SM_MODES], angle[SM_MODES];
    sm_modal unit;
    int from_rest; /* 1: a mode of those */
} felt_change;

/* Along a direction in amplitudes, and inputs that by themselves change what is felt by `driven`
 * relative to the scale of the limits, and that scale by `scale`. From rest an amplitude moves
 * straight away: its unit, without a meaning there, is that of the motion. */
SM_INLINE void change_of_felt(const sm_instant *instant, const sm_felt *felt, int modes,
                              const sm_modal *amplitude, const sm_modal *driven, double scale,
                              felt_change *d) {
    double radians2[SM_MODES], speed2[SM_MODES];
    sm_modal moved;
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex unit = sm_of(&felt->unit, j), feel = sm_of(&instant->factor.feel, j);
        const sm_complex z = sm_cadd(sm_cmul(feel, sm_of(amplitude, j)), sm_of(driven, j));
        const sm_complex along =
            sm_cadd(sm_cmul(sm_cmul(sm_conj(unit), feel), sm_of(amplitude, j)),
                    sm_cmul(sm_conj(unit), sm_of(driven, j)));
        sm_put(&moved, j, z);
        const double radians = felt->modulus[j] * instant->inputs.frequency[j];
        radians2[j] = radians * radians;
        speed2[j] = SETS_OFF * SETS_OFF * sm_cabs2(z);
        d->modulus[j] = along.re - felt->modulus[j] * scale;
        d->angle[j] = along.im * felt->per_modulus[j];
        sm_put(&d->unit, j, unit);
    }
    d->from_rest = 0;
    for (int j = 0; j < modes; j++) {
        if (radians2[j] > speed2[j] || speed2[j] == 0.0) continue;
        const sm_complex z = sm_of(&moved, j);
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

/* How the strengths of the pulls change: what they are relative to the units of the modes. */
SM_INLINE void change_of_strengths(const sm_slow_flow *flow, const sm_instant *instant,
                                   const sm_flow_state *state, int modes,
                                   const double *near_angle, const felt_change *d,
                                   sm_modal *strength) {
    const double *S = state->slopes, *T = S + 2 * modes;
    const size_t fields = 2 * (size_t)(modes + flow->table.near + flow->table.power);
    const sm_complex *turn = state->near_turn;
    sm_complex soon[SM_NEAR];
    if (d->from_rest) {
        const double *modulus = state->felt.modulus;
        const double moved[SM_MODES] = {modulus[0] + d->modulus[0], modulus[1] + d->modulus[1]};
        sm_near_turns(flow, instant, &d->unit, moved, soon);
        turn = soon;
    }
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex grown = change_of_column(S, fields, modes, j, d);
        sm_put(strength, j, sm_cadd(grown, times_i(pair(S + 2 * j), d->angle[j])));
    }
    for (int k = 0; k < flow->table.near; k++) {
        const double *order = instant->near_order[k];
        double angle = order[0] * d->angle[0] + near_angle[k];
        if (modes == SM_MODES) angle += order[1] * d->angle[1];
        const sm_complex grown = change_of_column(S, fields, modes, modes + k, d);
        const sm_complex turned = times_i(pair(T + 2 * k), angle);
        sm_add_near(instant, k, modes, sm_cmul(sm_cadd(grown, turned), turn[k]), strength);
    }
}

/* All but the difference of powers. `moving` is a literal too: whether more than the angles of the
 * inputs changes. */
SM_INLINE void change_along(const sm_slow_flow *flow, const sm_instant *instant,
                            const sm_flow_state *state, const sm_direction *along, int modes,
                            int moving, felt_change *felt, sm_flow_change *change) {
    const sm_factors *by = &instant->factor;
    const sm_coefficients *now = &instant->now, *d = along->now;
    const double scale = moving ? along->limit_scale * instant->per_scale : 0.0; /* relative */
    sm_modal driven = {{0.0}, {0.0}}, strength;
    if (modes < SM_MODES) *felt = (felt_change){.modulus = {0.0}};
    if (moving) {
        SM_SIMD
        for (int j = 0; j < modes; j++) {
            const sm_complex shift = pair(flow->shift[j]);
            const sm_complex moved = sm_cadd(sm_of(&state->felt.amplitude, j),
                                             sm_cmul(shift, sm_of(&now->excitation, j)));
            const sm_complex change = sm_cadd(
                sm_cmul(sm_of(&d->turn, j), moved),
                sm_cmul(sm_of(&now->turn, j), sm_cmul(shift, sm_of(&d->excitation, j))));
            sm_put(&driven, j, sm_cscale(change, instant->per_scale));
        }
    }
    change_of_felt(instant, &state->felt, modes, along->amplitude, &driven, scale, felt);
    change_of_strengths(flow, instant, state, modes, along->near_angle, felt, &strength);
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex unit = sm_of(&felt->unit, j), stronger = sm_of(&strength, j);
        const sm_complex lever = sm_cmul(sm_of(&by->push, j), unit);
        sm_complex force = sm_cmul(sm_of(&by->grip, j), sm_cmul(stronger, unit));
        sm_complex rate = sm_csub(sm_cmul(lever, stronger),
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
}

/* Force of friction less that in steady motion, where what the contacts feel changes so. */
SM_INLINE void lag_behind(const sm_slow_flow *flow, const sm_instant *instant,
                          const sm_flow_state *state, int modes, const felt_change *felt,
                          sm_modal *lag) {
    if (!flow->table.lag || flow->paper) {
        *lag = (sm_modal){{0.0}, {0.0}};
        return;
    }
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const double *by = state->lag + 2 * j * modes;
        sm_complex behind = sm_cscale(pair(by), felt->modulus[0]);
        if (modes == SM_MODES)
            behind = sm_cadd(behind, sm_cscale(pair(by + 2), felt->modulus[1]));
        const sm_complex lever = sm_cmul(sm_of(&instant->factor.grip, j), sm_of(&felt->unit, j));
        sm_put(lag, j, sm_cmul(lever, behind));
    }
}

void sm_first_order_change(const sm_slow_flow *flow, const sm_instant *instant,
                           const sm_flow_state *state, const sm_direction *along,
                           sm_flow_change *change) {
    const int modes = flow->table.modes, column = modes + flow->table.near;
    const size_t fields = 2 * (size_t)(column + flow->table.power);
    felt_change felt;
    if (modes == 1)
        change_along(flow, instant, state, along, 1, 1, &felt, change);
    else
        change_along(flow, instant, state, along, SM_MODES, 1, &felt, change);
    change->difference =
        flow->table.power ? change_of_column(state->slopes, fields, modes, column, &felt).re : 0.0;
}

SM_INLINE void along_flow(const sm_slow_flow *flow, const sm_instant *instant,
                          const sm_flow_state *state, int modes, int moving,
                          sm_flow_change *change) {
    const sm_direction along = {.amplitude = &state->rate,
                                .now = &instant->rate,
                                .near_angle = instant->near_rate,
                                .limit_scale = instant->inputs.limit_scale_rate};
    felt_change felt;
    change_along(flow, instant, state, &along, modes, moving, &felt, change);
    lag_behind(flow, instant, state, modes, &felt, &change->lag);
}

void sm_change_along_flow(const sm_slow_flow *flow, const sm_instant *instant,
                          const sm_flow_state *state, sm_flow_change *change) {
    if (flow->table.modes == 1)
        along_flow(flow, instant, state, 1, 1, change);
    else
        along_flow(flow, instant, state, SM_MODES, 1, change);
}

SM_INLINE double friction_power(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                                const sm_flow_state *state, const sm_modal *lag) {
    double leaves[SM_MODES] = {0.0};
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex a = sm_of(&state->felt.amplitude, j);
        const sm_complex force = sm_cadd(sm_of(&state->force, j), sm_of(lag, j));
        leaves[j] = -2.0 * instant->inputs.frequency[j] * sm_cmul(sm_conj(a), force).im;
    }
    double power = leaves[0] + leaves[1];
    if (!flow->table.power) return power;
    const double scale = instant->inputs.limit_scale;
    power += scale * scale * state->slopes[2 * (modes + flow->table.near)];
    return power < 0.0 ? 0.0 : power;
}

double sm_friction_power(const sm_slow_flow *flow, const sm_instant *instant,
                         const sm_flow_state *state, const sm_modal *lag) {
    return friction_power(flow, instant, flow->table.modes, state, lag);
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
    sm_flow_change change; /* a'' and the lag, which the paper neglects */
    if (flow->paper)
        change = (sm_flow_change){.difference = 0.0};
    else
        along_flow(flow, instant, &state, modes, moving, &change);
    double put_in[SM_MODES] = {0.0};
    if (modes < SM_MODES) dy[2] = dy[3] = 0.0;
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex less = sm_csub(sm_of(&change.rate, j), sm_of(&change.lag, j));
        const sm_complex rate = sm_csub(sm_of(&state.rate, j),
                                        sm_cmul(less, sm_of(&instant->per_mass, j)));
        dy[2 * j] = rate.re;
        dy[2 * j + 1] = rate.im;
        put_in[j] = input_power(instant->inputs.frequency[j], sm_of(&instant->now.excitation, j),
                                sm_of(&state.felt.amplitude, j), rate);
    }
    dy[SM_DISSIPATED] = friction_power(flow, instant, modes, &state, &change.lag);
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

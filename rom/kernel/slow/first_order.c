/* The slow flow: amplitude equations (18), (19) in the frame of the forcing.
 *
 * With a_j exp(i theta_j), theta_j' = Omega_j, the equation of mode j is
 *   (d/dt + mass) (d/dt - slow) a = F exp(i ph) / 2 + S_j a / |a| [+ combination resonances] = G,
 * a'' and all. With stiffness = -mass slow it is mass a' + stiffness a = G where G does not change.
 * With v(a) the rate by that, v - slow a is G / mass, and to first order in how it changes along the
 * flow a' = v - (v - slow a)' / mass. The paper neglects that. To the same order friction is
 * behind what it is in steady motion, by correction_jk d|a_k|/dt: a contact that sticks holds what
 * the last reversal left, as large as the amplitude was then.
 */
#include "slow/first_order.h"

#include <math.h>

#include "base/lanes.h"
#include "slow/slow_flow.h"
#include "table/table.h"

/* i factor z */
SM_INLINE sm_complex times_i(sm_complex z, double factor) {
    return sm_cx(-factor * z.im, factor * z.re);
}

#define AT_REST 1e-300 /* square of a modulus: less is near the denormals, and none */

/* `modes` is a literal, here and below. */
SM_INLINE void effective_at(const sm_instant *instant, int modes, const double *y,
                               sm_effective *effective) {
    const sm_factors *by = &instant->factor;
    if (modes < SM_MODES) *effective = (sm_effective){.modulus = {0.0}};
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex a = sm_pair(y + 2 * j);
        const sm_complex z =
            sm_cadd(sm_cmul(sm_of(&by->amplitude_ratio, j), a), sm_of(&by->off_resonance, j));
        const double square = sm_cabs2(z), modulus = square < AT_REST ? 0.0 : sqrt(square);
        /* as 1 / modulus, but root and division side by side */
        const double per_modulus = square < AT_REST ? 0.0 : modulus * (1.0 / square);
        const sm_complex unit = sm_cscale(z, per_modulus);
        sm_put(&effective->amplitude, j, a);
        sm_put(&effective->unit, j, sm_cx(square < AT_REST ? 1.0 : unit.re, unit.im));
        effective->modulus[j] = modulus;
        effective->per_modulus[j] = per_modulus;
    }
}

void sm_effective_at(const sm_slow_flow *flow, const sm_instant *instant, const double *y,
                     sm_effective *effective) {
    if (flow->table.modes == 1)
        effective_at(instant, 1, y, effective);
    else
        effective_at(instant, SM_MODES, y, effective);
}

/* Forces of the contacts on the modes, and the rates that they lead to. */
SM_INLINE void reactions_and_rates(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                                   sm_flow_state *state) {
    const sm_factors *by = &instant->factor;
    const double *S = state->slopes, *T = S + 2 * modes;
    sm_modal strength;
    SM_SIMD
    for (int j = 0; j < modes; j++) sm_put(&strength, j, sm_pair(S + 2 * j));
    for (int k = 0; k < flow->table.combinations; k++)
        sm_add_combination(instant, k, modes,
                           sm_cmul(sm_pair(T + 2 * k), state->combination_phasor[k]), &strength);
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex a = sm_of(&state->effective.amplitude, j),
                         unit = sm_of(&state->effective.unit, j);
        const sm_complex reaction = sm_cmul(sm_of(&strength, j), unit);
        /* what the strength is multiplied by does not wait for it to be looked up */
        const sm_complex gain = sm_cmul(sm_of(&by->rate_ratio, j), unit);
        const sm_complex linear =
            sm_csub(sm_of(&by->forcing, j), sm_cmul(sm_of(&by->spring, j), a));
        sm_put(&state->reaction, j, reaction);
        sm_put(&state->force, j, sm_cmul(sm_of(&by->force_ratio, j), reaction));
        sm_put(&state->rate, j, sm_cadd(linear, sm_cmul(gain, sm_of(&strength, j))));
    }
}

/* S_j at the forcing frequencies, to first order in their distance from the table's carriers. */
static void detune(const sm_slow_flow *flow, const sm_instant *instant, int modes, int sloped,
                   sm_flow_state *state) {
    const size_t fields = 2 * (size_t)(modes + flow->table.combinations + flow->table.power);
    const size_t own = 2 * (size_t)(modes * modes);
    const double *detuning = instant->now.detuning;
    sm_table_detuning(&flow->table, state->effective.modulus, sloped, instant->cell,
                      state->detuning);
    for (size_t part = 0; part < (sloped ? 3 : 1); part++)
        for (int j = 0; j < modes; j++)
            for (int k = 0; k < modes; k++)
                for (int re_im = 0; re_im < 2; re_im++)
                    state->slopes[part * fields + (size_t)(2 * j + re_im)] +=
                        detuning[k]
                        * state->detuning[part * own + (size_t)(2 * (j * modes + k) + re_im)];
}

/* With slopes of the first `sloped` columns of the table. */
SM_INLINE sm_status first_order(const sm_slow_flow *flow, sm_instant *instant, int modes,
                                size_t sloped, const double *y, sm_flow_state *state) {
    effective_at(instant, modes, y, &state->effective);
    sm_combination_phasors(flow, instant, &state->effective.unit, state->effective.modulus,
                           state->combination_phasor);
    const sm_status status =
        sm_table_slopes_from(&flow->table, state->effective.modulus, sloped, instant->cell,
                             state->slopes, state->rate_correction);
    if (status != SM_OK) return status;
    if (flow->table.detuning) detune(flow, instant, modes, sloped > 0, state);
    reactions_and_rates(flow, instant, modes, state);
    return SM_OK;
}

sm_status sm_first_order(const sm_slow_flow *flow, sm_instant *instant, int sloped,
                         const double *y, sm_flow_state *state) {
    const sm_table *table = &flow->table;
    const size_t columns =
        sloped ? 2 * (size_t)(table->modes + table->combinations + table->power) : 0;
    return table->modes == 1 ? first_order(flow, instant, 1, columns, y, state)
                             : first_order(flow, instant, SM_MODES, columns, y, state);
}

#define SETS_OFF 1e-4 /* radians in which the flow covers an amplitude that is taken as zero */

/* How the effective amplitudes change. */
typedef struct {
    double modulus[SM_MODES], angle[SM_MODES];
    sm_modal unit;
    int from_rest; /* 1: a mode of those */
} effective_change;

/* Along a direction in amplitudes and inputs. `by_inputs`: change of the effective amplitude by the
 * inputs alone, relative to the scale of the limits; `scale`: relative change of that scale. From
 * rest an amplitude moves straight, and its unit is the direction of the motion. */
SM_INLINE void change_of_effective(const sm_instant *instant, const sm_effective *effective,
                                   int modes, const sm_modal *amplitude, const sm_modal *by_inputs,
                                   double scale, effective_change *d) {
    double radians2[SM_MODES], speed2[SM_MODES];
    sm_modal moved;
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex unit = sm_of(&effective->unit, j),
                         amplitude_ratio = sm_of(&instant->factor.amplitude_ratio, j);
        const sm_complex z =
            sm_cadd(sm_cmul(amplitude_ratio, sm_of(amplitude, j)), sm_of(by_inputs, j));
        const sm_complex along =
            sm_cadd(sm_cmul(sm_cmul(sm_conj(unit), amplitude_ratio), sm_of(amplitude, j)),
                    sm_cmul(sm_conj(unit), sm_of(by_inputs, j)));
        sm_put(&moved, j, z);
        const double radians = effective->modulus[j] * instant->inputs.frequency[j];
        radians2[j] = radians * radians;
        speed2[j] = SETS_OFF * SETS_OFF * sm_cabs2(z);
        d->modulus[j] = along.re - effective->modulus[j] * scale;
        d->angle[j] = along.im * effective->per_modulus[j];
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
                                      const effective_change *d) {
    const double *in_a = slopes + fields + 2 * column, *in_b = in_a + fields;
    if (modes == 1) return sm_cscale(sm_pair(in_a), d->modulus[0]);
    return sm_cadd(sm_cscale(sm_pair(in_a), d->modulus[0]), sm_cscale(sm_pair(in_b), d->modulus[1]));
}

/* How the strengths of the reactions change: what they are relative to the units of the modes. */
SM_INLINE void change_of_strengths(const sm_slow_flow *flow, const sm_instant *instant,
                                   const sm_flow_state *state, int modes,
                                   const double *combination_angle, const double *detuning,
                                   const effective_change *d, sm_modal *strength) {
    const double *S = state->slopes, *T = S + 2 * modes;
    const size_t fields = 2 * (size_t)(modes + flow->table.combinations + flow->table.power);
    const sm_complex *phasor = state->combination_phasor;
    sm_complex soon[SM_COMBINATIONS];
    if (d->from_rest) {
        const double *modulus = state->effective.modulus;
        const double moved[SM_MODES] = {modulus[0] + d->modulus[0], modulus[1] + d->modulus[1]};
        sm_combination_phasors(flow, instant, &d->unit, moved, soon);
        phasor = soon;
    }
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex grown = change_of_column(S, fields, modes, j, d);
        sm_put(strength, j, sm_cadd(grown, times_i(sm_pair(S + 2 * j), d->angle[j])));
    }
    if (flow->table.detuning)
        for (int j = 0; j < modes; j++)
            for (int k = 0; k < modes; k++) {
                const sm_complex slope = sm_pair(state->detuning + 2 * (j * modes + k));
                sm_put(strength, j, sm_cadd(sm_of(strength, j), sm_cscale(slope, detuning[k])));
            }
    for (int k = 0; k < flow->table.combinations; k++) {
        const double *order = instant->combination_order[k];
        double angle = order[0] * d->angle[0] + combination_angle[k];
        if (modes == SM_MODES) angle += order[1] * d->angle[1];
        const sm_complex grown = change_of_column(S, fields, modes, modes + k, d);
        const sm_complex rotated = times_i(sm_pair(T + 2 * k), angle);
        sm_add_combination(instant, k, modes, sm_cmul(sm_cadd(grown, rotated), phasor[k]),
                           strength);
    }
}

/* `moving` is a literal too: whether more than the angles of the inputs changes. */
SM_INLINE void change_along(const sm_slow_flow *flow, const sm_instant *instant,
                            const sm_flow_state *state, const sm_direction *along, int modes,
                            int moving, effective_change *effective, sm_flow_change *change) {
    const sm_factors *by = &instant->factor;
    const sm_coefficients *now = &instant->now, *d = along->now;
    const double scale = moving ? along->limit_scale * instant->per_scale : 0.0; /* relative */
    sm_modal by_inputs = {{0.0}, {0.0}}, strength;
    if (modes < SM_MODES) *effective = (effective_change){.modulus = {0.0}};
    if (moving) {
        SM_SIMD
        for (int j = 0; j < modes; j++) {
            const sm_complex off_resonance = sm_pair(flow->off_resonance[j]);
            const sm_complex moved = sm_cadd(sm_of(&state->effective.amplitude, j),
                                             sm_cmul(off_resonance, sm_of(&now->excitation, j)));
            const sm_complex change =
                sm_cadd(sm_cmul(sm_of(&d->coupling_ratio, j), moved),
                        sm_cmul(sm_of(&now->coupling_ratio, j),
                                sm_cmul(off_resonance, sm_of(&d->excitation, j))));
            sm_put(&by_inputs, j, sm_cscale(change, instant->per_scale));
        }
    }
    change_of_effective(instant, &state->effective, modes, along->amplitude, &by_inputs, scale,
                        effective);
    change_of_strengths(flow, instant, state, modes, along->combination_angle, d->detuning,
                        effective, &strength);
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const sm_complex unit = sm_of(&effective->unit, j), stronger = sm_of(&strength, j);
        const sm_complex gain = sm_cmul(sm_of(&by->rate_ratio, j), unit);
        sm_complex force = sm_cmul(sm_of(&by->force_ratio, j), sm_cmul(stronger, unit));
        sm_complex rate = sm_csub(sm_cmul(gain, stronger),
                                  sm_cmul(sm_of(&by->spring, j), sm_of(along->amplitude, j)));
        if (moving) {
            const sm_complex rescaled =
                sm_cadd(sm_cscale(sm_cmul(sm_of(&d->coupling_ratio, j), sm_of(&state->reaction, j)),
                                  instant->inputs.limit_scale),
                        sm_cscale(sm_of(&state->force, j), scale));
            const sm_complex forcing =
                sm_cadd(sm_cscale(sm_of(&d->excitation, j), 0.5), rescaled);
            const sm_complex rest =
                sm_cadd(sm_cmul(sm_of(&d->stiffness, j), sm_of(&state->effective.amplitude, j)),
                        sm_cmul(sm_of(&d->mass, j), sm_of(&state->rate, j)));
            force = sm_cadd(force, rescaled);
            rate = sm_cadd(rate, sm_cmul(sm_csub(forcing, rest), sm_of(&instant->per_mass, j)));
        }
        sm_put(&change->force, j, force);
        sm_put(&change->rate, j, rate);
    }
}

/* Friction force minus the friction force of steady motion, while the effective amplitudes change:
 * by the growth of their moduli, and by their rotation. With rotating amplitudes the contacts move
 * at Omega_j + d arg(a_j)/dt. */
SM_INLINE void correct_for_rate(const sm_slow_flow *flow, const sm_instant *instant,
                                const sm_flow_state *state, int modes,
                                const effective_change *effective, sm_modal *rate_correction) {
    const sm_table *table = &flow->table;
    *rate_correction = (sm_modal){{0.0}, {0.0}};
    if (flow->paper) return;
    double rotation[SM_MODES] = {0.0};
    if (table->detuning)
        for (int k = 0; k < modes; k++)
            rotation[k] =
                sm_detuning(flow, k, instant->inputs.frequency[k] + effective->angle[k])
                - instant->now.detuning[k];
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        sm_complex behind = sm_cx(0.0, 0.0);
        for (int k = 0; k < modes; k++) {
            const int at = 2 * (j * modes + k);
            if (table->rate_correction)
                behind = sm_cadd(behind, sm_cscale(sm_pair(state->rate_correction + at),
                                                   effective->modulus[k]));
            if (table->detuning)
                behind = sm_cadd(behind, sm_cscale(sm_pair(state->detuning + at), rotation[k]));
        }
        const sm_complex gain =
            sm_cmul(sm_of(&instant->factor.force_ratio, j), sm_of(&effective->unit, j));
        sm_put(rate_correction, j, sm_cmul(gain, behind));
    }
}

void sm_first_order_change(const sm_slow_flow *flow, const sm_instant *instant,
                           const sm_flow_state *state, const sm_direction *along,
                           sm_flow_change *change) {
    effective_change effective;
    if (flow->table.modes == 1)
        change_along(flow, instant, state, along, 1, 1, &effective, change);
    else
        change_along(flow, instant, state, along, SM_MODES, 1, &effective, change);
}

SM_INLINE void along_flow(const sm_slow_flow *flow, const sm_instant *instant,
                          const sm_flow_state *state, int modes, int moving,
                          sm_flow_change *change) {
    const sm_direction along = {.amplitude = &state->rate,
                                .now = &instant->rate,
                                .combination_angle = instant->combination_rate,
                                .limit_scale = instant->inputs.limit_scale_rate};
    effective_change effective;
    change_along(flow, instant, state, &along, modes, moving, &effective, change);
    SM_SIMD
    for (int j = 0; j < modes; j++) { /* of v - slow a: spring is -slow */
        const sm_complex slow = sm_cmul(sm_of(&instant->factor.spring, j), sm_of(&state->rate, j));
        sm_complex rate = sm_cadd(sm_of(&change->rate, j), slow);
        if (moving)
            rate = sm_cadd(rate, times_i(sm_of(&state->effective.amplitude, j),
                                         instant->inputs.frequency_rate[j]));
        sm_put(&change->rate, j, rate);
    }
    correct_for_rate(flow, instant, state, modes, &effective, &change->rate_correction);
}

/* Power from the forces to the contacts besides their shift of the amplitudes. The table has it for
 * forces G_j that hold the amplitudes steady, G_j (1 + 2 off_resonance D) = 2 (D (a + shift) - force)
 * with D the stiffness. It is proportional to the force: sum |F| Re(conj(F) G) / sum |F| |G|^2 is the
 * factor, 1 in a steady state and 0 without a force. At most 1: G vanishes at some amplitudes. */
SM_INLINE double forces_power(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                              const sm_modal *shifted, const sm_modal *force, double tabulated) {
    double along = 0.0, steady = 0.0;
    for (int j = 0; j < modes; j++) {
        const sm_complex F = sm_of(&instant->now.excitation, j),
                         D = sm_of(&instant->now.stiffness, j);
        const sm_complex ratio = sm_cscale(sm_cmul(sm_pair(flow->off_resonance[j]), D), 2.0);
        const sm_complex held = sm_csub(sm_cmul(D, sm_of(shifted, j)), sm_of(force, j));
        const sm_complex G = sm_cdiv(sm_cscale(held, 2.0), sm_cx(1.0 + ratio.re, ratio.im));
        const double size = sqrt(sm_cabs2(F));
        along += size * sm_cmul(sm_conj(F), G).re;
        steady += size * sm_cabs2(G);
    }
    if (fabs(along) >= steady) return along > 0.0 ? tabulated : along < 0.0 ? -tabulated : 0.0;
    return tabulated * along / steady;
}

/* Mean of F cos(theta + ph) q', q' = 2 Re((a' + i Omega x) exp(i theta)). */
SM_INLINE double input_power(double Omega, sm_complex excitation, sm_complex x, sm_complex rate) {
    const sm_complex velocity = sm_cx(rate.re - Omega * x.im, rate.im + Omega * x.re);
    return sm_cmul(sm_conj(excitation), velocity).re;
}

SM_INLINE sm_status derivative(const sm_slow_flow *flow, sm_instant *instant, int modes,
                               int moving, const double *y, double *dy) {
    sm_flow_state state;
    const size_t forces =
        2 * (size_t)(modes + flow->table.combinations); /* no slopes of powers needed */
    const sm_status status = first_order(flow, instant, modes, forces, y, &state);
    if (status != SM_OK) return status;
    sm_flow_change change; /* a'' and the rate correction, which the paper neglects */
    if (flow->paper)
        change = (sm_flow_change){.rate = {{0.0}, {0.0}}};
    else
        along_flow(flow, instant, &state, modes, moving, &change);
    double put_in[SM_MODES] = {0.0}, leaves[SM_MODES] = {0.0};
    sm_modal force, shifted; /* of the contacts on the modes; amplitudes with their shift */
    if (modes < SM_MODES) dy[2] = dy[3] = 0.0;
    SM_SIMD
    for (int j = 0; j < modes; j++) {
        const double Omega = instant->inputs.frequency[j];
        const sm_complex less = sm_csub(sm_of(&change.rate, j), sm_of(&change.rate_correction, j));
        const sm_complex rate = sm_csub(sm_of(&state.rate, j),
                                        sm_cmul(less, sm_of(&instant->per_mass, j)));
        const sm_complex a = sm_of(&state.effective.amplitude, j),
                         excitation = sm_of(&instant->now.excitation, j),
                         off_resonance = sm_pair(flow->off_resonance[j]);
        const sm_complex f = sm_cadd(sm_of(&state.force, j), sm_of(&change.rate_correction, j));
        const sm_complex moved = sm_cadd(a, sm_cmul(off_resonance, excitation));
        dy[2 * j] = rate.re;
        dy[2 * j + 1] = rate.im;
        sm_put(&force, j, f);
        sm_put(&shifted, j, moved);
        /* the loaded DOFs: by reciprocity of the shift, the contact forces move them too */
        const sm_complex by_contacts = sm_cscale(sm_cmul(off_resonance, f), 2.0);
        const sm_complex by_others =
            sm_cadd(sm_cmul(sm_pair(flow->other_modes[j][0]), excitation),
                    sm_cmul(sm_pair(flow->other_modes[j][1]), a));
        const sm_complex x = sm_cadd(a, sm_cadd(by_contacts, by_others));
        put_in[j] = input_power(Omega, excitation, x, rate);
        /* the modes, and the forces by the shift, transfer this mean power to the contacts */
        leaves[j] = -2.0 * Omega * sm_cmul(sm_conj(moved), f).im;
    }
    dy[SM_PUT_IN] = put_in[0] + put_in[1];
    dy[SM_DISSIPATED] = leaves[0] + leaves[1];
    if (flow->table.power) {
        const double square = instant->inputs.limit_scale * instant->inputs.limit_scale;
        const double *powers = state.slopes + 2 * (modes + flow->table.combinations);
        const double by_forces =
            forces_power(flow, instant, modes, &shifted, &force, square * powers[1]);
        dy[SM_PUT_IN] += by_forces;
        dy[SM_DISSIPATED] = fmax(dy[SM_DISSIPATED] + square * powers[0] + by_forces, 0.0);
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

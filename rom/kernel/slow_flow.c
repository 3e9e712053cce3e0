/* The slow flow: amplitude equations (18), (19) in the frame of the forcing.
 *
 * With a_j exp(i theta_j), theta_j' = Omega_j, the equation of mode j is
 *   mass a' + stiffness a = F exp(i ph) / 2 + S_j a / |a|.
 * Carrier at the forcing (consistent formulation):
 *   mass = 2 i Omega + damping,  stiffness = omega^2 - Omega^2 + i (damping Omega + Omega');
 * carrier at the natural frequency, detuning to first order (the paper's):
 *   mass = 2 i omega,            stiffness = 2 omega (omega - Omega) + i damping omega.
 */
#include "slow_flow.h"

#include "check.h"

sm_status sm_inputs_check(const sm_inputs *inputs, int modes) {
    for (int j = 0; j < modes; j++) {
        const double values[] = {inputs->force[j], inputs->force_rate[j],
                                 inputs->frequency_rate[j], inputs->phase[j],
                                 inputs->phase_rate[j]};
        if (!sm_all_finite(values, sizeof values / sizeof *values)) return SM_NOT_FINITE;
        const sm_status status = sm_check_positive(inputs->frequency[j]);
        if (status != SM_OK) return status;
    }
    return SM_OK;
}

sm_inputs sm_inputs_after(const sm_inputs *inputs, int modes, double elapsed) {
    sm_inputs after = {.force = {0.0}};
    for (int j = 0; j < modes; j++) {
        after.force[j] = inputs->force[j] + inputs->force_rate[j] * elapsed;
        after.force_rate[j] = inputs->force_rate[j];
        after.frequency[j] = inputs->frequency[j] + inputs->frequency_rate[j] * elapsed;
        after.frequency_rate[j] = inputs->frequency_rate[j];
        after.phase[j] = inputs->phase[j] + inputs->phase_rate[j] * elapsed;
        after.phase_rate[j] = inputs->phase_rate[j];
    }
    return after;
}

/* S_j at the amplitudes in y; |a_j| into modulus. */
static sm_status friction_term(const sm_slow_flow *flow, const double *y, double *modulus,
                               double *s) {
    for (int j = 0; j < flow->table.modes; j++)
        modulus[j] = sqrt(y[2 * j] * y[2 * j] + y[2 * j + 1] * y[2 * j + 1]);
    return sm_table_lookup(&flow->table, modulus, s);
}

static void mode_rate(const sm_slow_flow *flow, const sm_inputs *in, int j, double elapsed,
                      const double *a, const double *s, double modulus, double *rate) {
    const double natural = flow->natural[j], damping = flow->damping[j];
    const double frequency = in->frequency[j] + in->frequency_rate[j] * elapsed;
    const double force = 0.5 * (in->force[j] + in->force_rate[j] * elapsed);
    const double phase = in->phase[j] + in->phase_rate[j] * elapsed;
    double mass_re, mass_im, stiff_re, stiff_im;
    if (flow->paper) {
        mass_re = 0.0;
        mass_im = 2.0 * natural;
        stiff_re = 2.0 * natural * (natural - frequency);
        stiff_im = damping * natural;
    } else {
        mass_re = damping;
        mass_im = 2.0 * frequency;
        stiff_re = (natural - frequency) * (natural + frequency);
        stiff_im = damping * frequency + in->frequency_rate[j];
    }
    /* S a / |a| tends to 0 with a */
    const double unit_re = modulus > 0.0 ? a[0] / modulus : 0.0;
    const double unit_im = modulus > 0.0 ? a[1] / modulus : 0.0;
    const double re = force * cos(phase) + s[0] * unit_re - s[1] * unit_im
                      - (stiff_re * a[0] - stiff_im * a[1]);
    const double im = force * sin(phase) + s[0] * unit_im + s[1] * unit_re
                      - (stiff_re * a[1] + stiff_im * a[0]);
    const double norm = 1.0 / (mass_re * mass_re + mass_im * mass_im);
    rate[0] = (re * mass_re + im * mass_im) * norm;
    rate[1] = (im * mass_re - re * mass_im) * norm;
}

/* Mean power that leaves the modes at the contacts: -2 sum_j Omega_j |a_j| Im S_j. */
static double contact_power(const sm_slow_flow *flow, const sm_inputs *in, double elapsed,
                            const double *modulus, const double *s) {
    double power = 0.0;
    for (int j = 0; j < flow->table.modes; j++) {
        const double frequency = in->frequency[j] + in->frequency_rate[j] * elapsed;
        power -= 2.0 * frequency * modulus[j] * s[2 * j + 1];
    }
    return power;
}

sm_status sm_slow_flow_derivative(const sm_slow_flow *flow, const sm_inputs *inputs,
                                  double elapsed, const double *y, double *dy) {
    double modulus[SM_MODES], s[2 * SM_MODES];
    const sm_status status = friction_term(flow, y, modulus, s);
    if (status != SM_OK) return status;
    for (int j = 0; j < SM_MODES; j++) {
        if (j < flow->table.modes)
            mode_rate(flow, inputs, j, elapsed, y + 2 * j, s + 2 * j, modulus[j], dy + 2 * j);
        else
            dy[2 * j] = dy[2 * j + 1] = 0.0;
    }
    dy[2 * SM_MODES] = contact_power(flow, inputs, elapsed, modulus, s);
    return SM_OK;
}

sm_status sm_slow_flow_rate(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                            const double *amplitude, double *rate, double *input_power,
                            double *friction_power) {
    if (!flow || !inputs || !amplitude || !rate || !input_power || !friction_power)
        return SM_BAD_ARGUMENT;
    const int modes = flow->table.modes;
    if (modes < 1 || modes > SM_MODES) return SM_BAD_ARGUMENT;
    if (!isfinite(elapsed)) return SM_NOT_FINITE;
    const sm_inputs now = sm_inputs_after(inputs, modes, elapsed);
    sm_status status = sm_inputs_check(&now, modes);
    if (status != SM_OK) return status;
    double y[SM_UNKNOWNS] = {0.0}, dy[SM_UNKNOWNS];
    for (int k = 0; k < 2 * modes; k++) y[k] = amplitude[k];
    status = sm_slow_flow_derivative(flow, &now, 0.0, y, dy);
    if (status != SM_OK) return status;
    double power = 0.0;
    for (int j = 0; j < modes; j++) {
        /* mean of F cos(theta + ph) q', q' = 2 Re((a' + i Omega a) exp(i theta)) */
        const double v_re = dy[2 * j] - now.frequency[j] * y[2 * j + 1];
        const double v_im = dy[2 * j + 1] + now.frequency[j] * y[2 * j];
        power += now.force[j] * (cos(now.phase[j]) * v_re + sin(now.phase[j]) * v_im);
    }
    if (!isfinite(power) || !sm_all_finite(dy, SM_UNKNOWNS)) return SM_NOT_FINITE;
    for (int k = 0; k < 2 * modes; k++) rate[k] = dy[k];
    *input_power = power;
    *friction_power = dy[2 * SM_MODES];
    return SM_OK;
}

/* Dormand and Prince 1980, the 5(4) pair with first-same-as-last. */
static const double NODE[7] = {0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0};
static const double WEIGHT[7][6] = {
    {0.0},
    {0.2},
    {3.0 / 40.0, 9.0 / 40.0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
    {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}};
static const double ERROR[7] = {71.0 / 57600.0,      0.0,          -71.0 / 16695.0, 71.0 / 1920.0,
                                -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};

sm_status sm_slow_flow_try(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                           double h, double tolerance, const double *y, const double *dy,
                           double *y_new, double *dy_new, double *error) {
    double k[7][SM_UNKNOWNS];
    for (int u = 0; u < SM_UNKNOWNS; u++) k[0][u] = dy[u];
    for (int stage = 1; stage < 7; stage++) {
        for (int u = 0; u < SM_UNKNOWNS; u++) {
            double sum = 0.0;
            for (int p = 0; p < stage; p++) sum += WEIGHT[stage][p] * k[p][u];
            y_new[u] = y[u] + h * sum;
        }
        const sm_status status =
            sm_slow_flow_derivative(flow, inputs, elapsed + NODE[stage] * h, y_new, k[stage]);
        if (status != SM_OK) return status;
    }
    *error = 0.0;
    const double range[SM_MODES] = {
        flow->table.node_a[flow->table.count_a - 1],
        flow->table.modes == SM_MODES ? flow->table.node_b[flow->table.count_b - 1] : 0.0};
    for (int j = 0; j < flow->table.modes; j++) {
        double squared = 0.0;
        for (int u = 2 * j; u < 2 * j + 2; u++) {
            double e = 0.0;
            for (int p = 0; p < 7; p++) e += ERROR[p] * k[p][u];
            squared += h * h * e * e;
        }
        const double modulus = sqrt(y_new[2 * j] * y_new[2 * j] + y_new[2 * j + 1] * y_new[2 * j + 1]);
        const double scale = tolerance * (modulus + 1e-3 * range[j]);
        const double relative = sqrt(squared) / scale;
        *error = relative > *error ? relative : *error;
    }
    for (int u = 0; u < SM_UNKNOWNS; u++) dy_new[u] = k[6][u];
    return SM_OK;
}

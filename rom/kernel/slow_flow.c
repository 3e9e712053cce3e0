/* The slow flow: amplitude equations (18), (19) in the frame of the forcing.
 *
 * With a_j exp(i theta_j), theta_j' = Omega_j, the equation of mode j is
 *   mass a' + stiffness a = F exp(i ph) / 2 + S_j a / |a| [+ near resonances].
 * Carrier at the forcing (consistent formulation):
 *   mass = 2 i Omega + damping,  stiffness = omega^2 - Omega^2 + i (damping Omega + Omega');
 * carrier at the natural frequency, detuning to first order (the paper's):
 *   mass = 2 i omega,            stiffness = 2 omega (omega - Omega) + i damping omega.
 */
#include "slow_flow.h"

#include "check.h"
#include "cnumber.h"

#define SHORT_STEP 1e-4 /* radians of mode A, and part of the table's range, at most */

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
            !sm_all_finite(flow->shift[j], 2))
            return SM_NOT_FINITE;
    }
    for (int k = 0; k < flow->table.near; k++)
        if (!near_is_valid(&flow->near[k], modes)) return SM_BAD_ARGUMENT;
    return SM_OK;
}

sm_status sm_inputs_check(const sm_inputs *inputs, int modes) {
    for (int j = 0; j < modes; j++) {
        const double values[] = {inputs->force[j], inputs->force_rate[j],
                                 inputs->frequency_rate[j], inputs->phase[j],
                                 inputs->phase_rate[j], inputs->angle[j]};
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
        after.angle[j] = inputs->angle[j]
                         + elapsed * (inputs->frequency[j]
                                      + 0.5 * inputs->frequency_rate[j] * elapsed);
    }
    return after;
}

/* What the contacts feel of a mode, and what they answer. */
typedef struct {
    sm_complex excitation; /* F exp(i ph) */
    sm_complex turn;   /* L_j(Omega_j) / L_j(carrier) */
    sm_complex unit;   /* direction of the amplitude that the contacts feel */
    sm_complex force;  /* of the contacts on the mode: Q_j a_j and the near resonances */
} mode_contact;

static sm_complex pair(const double *values) { return sm_cx(values[0], values[1]); }

static double frequency_at(const sm_inputs *in, int j, double elapsed) {
    return in->frequency[j] + in->frequency_rate[j] * elapsed;
}

/* F exp(i ph) */
static sm_complex excitation(const sm_inputs *in, int j, double elapsed) {
    const double force = in->force[j] + in->force_rate[j] * elapsed;
    const double phase = in->phase[j] + in->phase_rate[j] * elapsed;
    return sm_cx(force * cos(phase), force * sin(phase));
}

static sm_complex coupling_turn(const sm_turn *turn, double nu) {
    const sm_complex c0 = pair(turn->c[0]), c1 = pair(turn->c[1]);
    return sm_cx(1.0 + c0.re - nu * c1.im, c0.im + nu * c1.re);
}

/* The amplitude that the contacts feel: its modulus is returned, turn and unit are set. */
static double felt_amplitude(const sm_slow_flow *flow, const sm_inputs *in, int j,
                             double elapsed, const double *a, mode_contact *contact) {
    contact->excitation = excitation(in, j, elapsed);
    const sm_complex shift = sm_cmul(pair(flow->shift[j]), contact->excitation);
    contact->turn = coupling_turn(&flow->turn[j], frequency_at(in, j, elapsed));
    const sm_complex felt = sm_cmul(contact->turn, sm_cadd(pair(a), shift));
    const double modulus = sqrt(sm_cabs2(felt));
    /* S a / |a| tends to 0 with a */
    contact->unit = modulus > 0.0 ? sm_cscale(felt, 1.0 / modulus) : sm_cx(0.0, 0.0);
    return modulus;
}

/* T exp(i (n t_A + m t_B - theta_j)) of a near resonance, t_j = theta_j + arg a_j. */
static sm_complex near_force(const sm_near *near, const sm_inputs *in, double elapsed,
                             const mode_contact *contact, sm_complex t) {
    double theta[SM_MODES];
    for (int j = 0; j < SM_MODES; j++)
        theta[j] = in->angle[j]
                   + elapsed * (in->frequency[j] + 0.5 * in->frequency_rate[j] * elapsed);
    const double angle = near->n * theta[0] + near->m * theta[1] - theta[near->mode];
    const sm_complex units = sm_cmul(sm_unit_power(contact[0].unit, near->n),
                                     sm_unit_power(contact[1].unit, near->m));
    return sm_cmul(sm_cmul(t, units), sm_cx(cos(angle), sin(angle)));
}

/* Forces of the contacts on the modes at the amplitudes in y, and the friction power. */
static sm_status contact_forces(const sm_slow_flow *flow, const sm_inputs *in, double elapsed,
                                const double *y, mode_contact *contact, double *power) {
    const int modes = flow->table.modes;
    double modulus[SM_MODES] = {0.0}, s[SM_MOST_FIELDS];
    for (int j = 0; j < modes; j++)
        modulus[j] = felt_amplitude(flow, in, j, elapsed, y + 2 * j, &contact[j]);
    const sm_status status = sm_table_lookup(&flow->table, modulus, s);
    if (status != SM_OK) return status;
    for (int j = 0; j < modes; j++)
        contact[j].force = sm_cmul(pair(s + 2 * j), contact[j].unit);
    for (int k = 0; k < flow->table.near; k++) {
        sm_complex *force = &contact[flow->near[k].mode].force;
        *force = sm_cadd(*force, near_force(&flow->near[k], in, elapsed, contact,
                                            pair(s + 2 * (modes + k))));
    }
    *power = 0.0;
    for (int j = 0; j < modes; j++) {
        contact[j].force = sm_cmul(contact[j].turn, contact[j].force);
        /* mean power that leaves the mode at the contacts: -2 Omega Im(conj(a) force) */
        *power -= 2.0 * frequency_at(in, j, elapsed)
                  * sm_cmul(sm_conj(pair(y + 2 * j)), contact[j].force).im;
    }
    /* less what the dampers between modes and contacts take of it */
    if (flow->table.power) *power = fmax(*power + s[2 * (modes + flow->table.near)], 0.0);
    return SM_OK;
}

/* Factor of a_j'. */
static sm_complex modal_mass(const sm_slow_flow *flow, const sm_inputs *in, int j,
                             double elapsed) {
    return flow->paper ? sm_cx(0.0, 2.0 * flow->natural[j])
                       : sm_cx(flow->damping[j], 2.0 * frequency_at(in, j, elapsed));
}

static sm_complex mode_rate(const sm_slow_flow *flow, const sm_inputs *in, int j, double elapsed,
                            sm_complex a, const mode_contact *contact) {
    const double natural = flow->natural[j], damping = flow->damping[j];
    const double frequency = frequency_at(in, j, elapsed);
    const sm_complex stiffness =
        flow->paper ? sm_cx(2.0 * natural * (natural - frequency), damping * natural)
                    : sm_cx((natural - frequency) * (natural + frequency),
                            damping * frequency + in->frequency_rate[j]);
    const sm_complex force = sm_cadd(sm_cscale(contact->excitation, 0.5), contact->force);
    return sm_cdiv(sm_csub(force, sm_cmul(stiffness, a)), modal_mass(flow, in, j, elapsed));
}

/* Rates of the amplitude equations without a'', and the friction power. */
static sm_status first_order(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                             const double *y, double *dy) {
    mode_contact contact[SM_MODES] = {{.turn = {1.0, 0.0}}};
    for (int u = 0; u < SM_UNKNOWNS; u++) dy[u] = 0.0;
    const sm_status status =
        contact_forces(flow, inputs, elapsed, y, contact, &dy[2 * SM_MODES]);
    if (status != SM_OK) return status;
    for (int j = 0; j < flow->table.modes; j++) {
        const sm_complex rate =
            mode_rate(flow, inputs, j, elapsed, pair(y + 2 * j), &contact[j]);
        dy[2 * j] = rate.re;
        dy[2 * j + 1] = rate.im;
    }
    return SM_OK;
}

/* A step along the flow that is short in time and against the table. */
static double short_step(const sm_slow_flow *flow, const sm_inputs *inputs, const double *dy) {
    const double range[SM_MODES] = {
        flow->table.node_a[flow->table.count_a - 1],
        flow->table.modes == 2 ? flow->table.node_b[flow->table.count_b - 1] : 0.0};
    double step = SHORT_STEP / inputs->frequency[0];
    for (int j = 0; j < flow->table.modes; j++) {
        const double moved = step * sqrt(sm_cabs2(pair(dy + 2 * j)));
        if (moved > SHORT_STEP * range[j]) step *= SHORT_STEP * range[j] / moved;
    }
    return step;
}

/* The exact equation of a mode is a'' + mass a' + stiffness a = ...; with v(a) the rate without
 * a'', a'' is v' along the flow to first order, so a' = v - v' / mass. v' by a short step. */
sm_status sm_slow_flow_derivative(const sm_slow_flow *flow, const sm_inputs *inputs,
                                  double elapsed, const double *y, double *dy) {
    sm_status status = first_order(flow, inputs, elapsed, y, dy);
    if (status != SM_OK || flow->paper) return status;
    double ahead = short_step(flow, inputs, dy);
    double y_ahead[SM_UNKNOWNS], dy_ahead[SM_UNKNOWNS];
    for (int u = 0; u < SM_UNKNOWNS; u++) y_ahead[u] = y[u] + ahead * dy[u];
    status = first_order(flow, inputs, elapsed + ahead, y_ahead, dy_ahead);
    if (status == SM_OUTSIDE_TABLE) { /* at its very edge: look back instead */
        ahead = -ahead;
        for (int u = 0; u < SM_UNKNOWNS; u++) y_ahead[u] = y[u] + ahead * dy[u];
        status = first_order(flow, inputs, elapsed + ahead, y_ahead, dy_ahead);
    }
    if (status != SM_OK) return status;
    for (int j = 0; j < flow->table.modes; j++) {
        const sm_complex change = sm_cx((dy_ahead[2 * j] - dy[2 * j]) / ahead,
                                        (dy_ahead[2 * j + 1] - dy[2 * j + 1]) / ahead);
        const sm_complex less = sm_cdiv(change, modal_mass(flow, inputs, j, elapsed));
        dy[2 * j] -= less.re;
        dy[2 * j + 1] -= less.im;
    }
    return SM_OK;
}

sm_status sm_slow_flow_rate(const sm_slow_flow *flow, const sm_inputs *inputs, double elapsed,
                            const double *amplitude, double *rate, double *input_power,
                            double *friction_power) {
    if (!flow || !inputs || !amplitude || !rate || !input_power || !friction_power)
        return SM_BAD_ARGUMENT;
    sm_status status = sm_slow_flow_check(flow);
    if (status != SM_OK) return status;
    if (!isfinite(elapsed)) return SM_NOT_FINITE;
    const int modes = flow->table.modes;
    const sm_inputs now = sm_inputs_after(inputs, modes, elapsed);
    status = sm_inputs_check(&now, modes);
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

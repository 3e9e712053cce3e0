/* The inputs at an instant, in the form in which the amplitude equations take them. */
#ifndef SLIPMODE_INSTANT_H
#define SLIPMODE_INSTANT_H

#include "base/cnumber.h"

/* mass a' + stiffness a = excitation / 2 + c s G(c (a + off_resonance excitation) / s), with c the
 * coupling ratio, G the reaction of the contacts as tabulated and s the scale of their limits. */
typedef struct {
    sm_modal excitation; /* F exp(i ph) */
    sm_modal coupling_ratio;       /* L_j(Omega_j) / L_j(carrier) */
    sm_modal mass, stiffness;
    double detuning[SM_MODES]; /* from the carriers of the table, as far as it knows [rad/s] */
} sm_coefficients;

/* The same equation with its factors multiplied out, for the hot path:
 *   e = amplitude_ratio a + off_resonance,  rate = forcing - spring a + rate_ratio G(e),
 *   force = force_ratio G(e).
 */
typedef struct {
    sm_modal amplitude_ratio, off_resonance; /* relative to the limits */
    sm_modal force_ratio;             /* coupling_ratio s */
    sm_modal forcing, spring, rate_ratio;
} sm_factors;

typedef struct {
    int known;                /* 1: of `inputs`, 0: of none yet */
    int held;                 /* 1: the inputs do not move, but for the angles */
    sm_inputs inputs;
    sm_modal direction; /* exp(i ph) */
    sm_modal per_mass;
    double per_scale; /* 1 / limit_scale */
    sm_coefficients now, rate; /* and d/dt of them */
    sm_factors factor;
    sm_complex combination_wave[SM_COMBINATIONS]; /* exp(i (n theta_A + m theta_B - theta_j)) */
    double combination_rate[SM_COMBINATIONS];     /* d/dt of that angle */
    int like_first[SM_COMBINATIONS]; /* that angle is the first one's times 1, -1; or another: 0 */
    double combination_on[SM_COMBINATIONS][SM_MODES]; /* 1 for the mode it acts on, else 0 */
    double combination_order[SM_COMBINATIONS][SM_MODES]; /* n, m */
    int32_t cell[SM_MODES];        /* of the table, where the last amplitudes were */
} sm_instant;

/* Finite inputs of the first `modes` modes, frequencies > 0. */
sm_status sm_inputs_check(const sm_inputs *inputs, int modes);

/* What the inputs are `elapsed` seconds later, modes that are not there 0. */
sm_inputs sm_inputs_after(const sm_inputs *inputs, int modes, double elapsed);

/* Moves to `inputs`; what they share with those before is not computed again. */
void sm_instant_set(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs);

/* Whether `inputs` are those of the instant but for the angles, and stay so. */
int sm_instant_holds(const sm_instant *instant, const sm_inputs *inputs);
/* Where it holds them: moves on to the angles `elapsed` seconds after their start. */
void sm_instant_advance(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs,
                        double elapsed);

/* How the coefficients change with the inputs. */
void sm_coefficients_change(const sm_slow_flow *flow, const sm_instant *instant,
                            const sm_inputs *change, sm_coefficients *d);
/* How the angle of a combination resonance does. */
double sm_combination_angle(const sm_combination *combination, const double *theta);

/* Distance of a frequency from the carrier of mode j, at most as far as the table has slopes [rad/s]. */
double sm_detuning(const sm_slow_flow *flow, int j, double Omega);

#endif

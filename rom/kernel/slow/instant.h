/* The inputs at an instant, in the form in which the amplitude equations take them. */
#ifndef SLIPMODE_INSTANT_H
#define SLIPMODE_INSTANT_H

#include "base/modal.h"

/* mass a' + stiffness a = excitation / 2 + turn s G(turn (a + shift excitation) / s), with G the
 * pull of the contacts as tabulated and s the scale of their limits. */
typedef struct {
    sm_modal excitation; /* F exp(i ph) */
    sm_modal turn;       /* L_j(Omega_j) / L_j(carrier) */
    sm_modal mass, stiffness;
} sm_coefficients;

/* The same equation by what it multiplies, for the hot path:
 *   felt = feel a + felt_force,  rate = drive - spring a + push pull(felt),  force = grip pull. */
typedef struct {
    sm_modal feel, felt_force; /* relative to the limits */
    sm_modal grip;             /* turn s */
    sm_modal drive, spring, push;
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
    sm_complex near_wave[SM_NEAR]; /* exp(i (n theta_A + m theta_B - theta_j)) */
    double near_rate[SM_NEAR];     /* d/dt of that angle */
    int like_first[SM_NEAR];       /* that angle is the first one's times 1, -1; or another: 0 */
    double near_on[SM_NEAR][SM_MODES]; /* 1 for the mode that it drives, else 0 */
    double near_order[SM_NEAR][SM_MODES]; /* n, m */
    int32_t cell[SM_MODES];        /* of the table, where the last amplitudes were */
} sm_instant;

/* Finite inputs of the first `modes` modes, frequencies > 0. */
sm_status sm_inputs_check(const sm_inputs *inputs, int modes);

/* What the inputs are `elapsed` seconds later, modes that are not there 0. */
sm_inputs sm_inputs_after(const sm_inputs *inputs, int modes, double elapsed);

/* Turns to `inputs`; what they share with those before is not computed again. */
void sm_instant_set(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs);

/* Whether `inputs` are those of the instant but for the angles, and stay so. */
int sm_instant_holds(const sm_instant *instant, const sm_inputs *inputs);
/* Where it holds them: turns to the angles `elapsed` seconds after their start. */
void sm_instant_turn(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs,
                     double elapsed);

/* How the coefficients change with the inputs. */
void sm_coefficients_change(const sm_slow_flow *flow, const sm_instant *instant,
                            const sm_inputs *change, sm_coefficients *d);
/* How the angle of a near resonance does. */
double sm_near_angle(const sm_near *near, const double *theta);

#endif

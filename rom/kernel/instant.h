/* The inputs at an instant, in the form in which the amplitude equations take them. */
#ifndef SLIPMODE_INSTANT_H
#define SLIPMODE_INSTANT_H

#include "cnumber.h"
#include "slipmode.h"

/* mass a' + stiffness a = excitation / 2 + turn s G(turn (a + shift excitation) / s), with G the
 * pull of the contacts as tabulated and s the scale of their limits. */
typedef struct {
    sm_complex excitation; /* F exp(i ph) */
    sm_complex turn;       /* L_j(Omega_j) / L_j(carrier) */
    sm_complex mass, stiffness;
} sm_coefficients;

typedef struct {
    int known;                /* 1: of `inputs`, 0: of none yet */
    sm_inputs inputs;
    sm_complex direction[SM_MODES]; /* exp(i ph) */
    sm_complex per_mass[SM_MODES];
    double per_scale; /* 1 / limit_scale */
    sm_coefficients now[SM_MODES], rate[SM_MODES]; /* and d/dt of them */
    sm_complex near_wave[SM_NEAR]; /* exp(i (n theta_A + m theta_B - theta_j)) */
    double near_rate[SM_NEAR];     /* d/dt of that angle */
    int32_t cell[SM_MODES];        /* of the table, where the last amplitudes were */
} sm_instant;

/* Finite inputs of the first `modes` modes, frequencies > 0. */
sm_status sm_inputs_check(const sm_inputs *inputs, int modes);

/* What the inputs are `elapsed` seconds later, modes that are not there 0. */
sm_inputs sm_inputs_after(const sm_inputs *inputs, int modes, double elapsed);

/* Turns to `inputs`; what they share with those before is not computed again. */
void sm_instant_set(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs);

/* How the coefficients of mode j change with the inputs. */
sm_coefficients sm_coefficients_change(const sm_slow_flow *flow, const sm_instant *instant, int j,
                                       const sm_inputs *change);
/* How the angle of a near resonance does. */
double sm_near_angle(const sm_near *near, const double *theta);

#endif

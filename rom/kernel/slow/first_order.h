/* The amplitude equations without a'', and how the rates that they give change. */
#ifndef SLIPMODE_FIRST_ORDER_H
#define SLIPMODE_FIRST_ORDER_H

#include "slow/instant.h"

/* The effective amplitudes, which the contacts see of the modes; a mode that is not there is 0. */
typedef struct {
    sm_modal amplitude;           /* a_j */
    sm_modal unit;                /* direction of the effective amplitude; 1 at rest */
    double modulus[SM_MODES];     /* of it, relative to the scale of the limits */
    double per_modulus[SM_MODES]; /* 1 / modulus; 0 at rest */
} sm_effective;

/* And how they react. */
typedef struct {
    sm_effective effective;
    sm_modal
        reaction;   /* of the contacts, as tabulated: S_j unit_j and the combination resonances */
    sm_modal force; /* rotated and scaled: on the mode */
    sm_modal rate;  /* of the amplitude */
    sm_complex combination_phasor[SM_COMBINATIONS]; /* exp(i (n t_A + m t_B - t_j)), t_j = theta_j +
                                                       arg a_j */
    double slopes[3 * SM_MOST_FIELDS]; /* of the table: values, d/da, d/db */
    double rate_correction[SM_RATE_CORRECTIONS];
    double detuning[3 * SM_RATE_CORRECTIONS]; /* dS_j / dOmega_k, d/da, d/db, if the table has it */
} sm_flow_state;

/* A direction in amplitudes and inputs. */
typedef struct {
    const sm_modal *amplitude;
    const sm_coefficients *now;
    const double *combination_angle; /* (combinations) */
    double limit_scale;
} sm_direction;

/* What changes along it. */
typedef struct {
    sm_modal rate, force;
    sm_modal rate_correction; /* along the flow: the force of friction less that in steady motion */
} sm_flow_change;

/* At amplitudes y (2 modes) and the inputs that `instant` is set to. */
void sm_effective_at(const sm_slow_flow *flow, const sm_instant *instant, const double *y,
                     sm_effective *effective);

/* At amplitudes y (2 modes) and the inputs that `instant` is set to. How it changes along a direction
 * takes slopes of the table, which are looked up if they are `sloped`. */
sm_status sm_first_order(const sm_slow_flow *flow, sm_instant *instant, int sloped,
                         const double *y, sm_flow_state *state);

void sm_first_order_change(const sm_slow_flow *flow, const sm_instant *instant,
                           const sm_flow_state *state, const sm_direction *along,
                           sm_flow_change *change);

#endif

/* The amplitude equations without a'', and how the rates that they give change. */
#ifndef SLIPMODE_FIRST_ORDER_H
#define SLIPMODE_FIRST_ORDER_H

#include "instant.h"

/* What the contacts feel of a mode, and what they answer. */
typedef struct {
    sm_complex amplitude; /* a_j */
    sm_complex unit;      /* direction of what the contacts feel */
    double modulus;       /* of it, relative to the scale of the limits */
    double per_modulus;   /* 1 / modulus; 0 at rest */
    sm_complex pull;      /* of theirs, as tabulated: S_j unit_j and the near resonances */
    sm_complex force;     /* turned and scaled: on the mode */
    sm_complex rate;      /* of the amplitude */
} sm_mode_state;

typedef struct {
    sm_mode_state mode[SM_MODES];
    sm_complex near_unit[SM_NEAR], near_pull[SM_NEAR];
    double slopes[3 * SM_MOST_FIELDS]; /* of the table: values, d/da, d/db */
    double lag[SM_LAGS];
} sm_flow_state;

/* A direction in amplitudes and inputs. */
typedef struct {
    sm_complex amplitude[SM_MODES];
    const sm_coefficients *now; /* (modes) */
    const double *near_angle;   /* (near) */
    double limit_scale;
} sm_direction;

/* What changes along it. */
typedef struct {
    sm_complex rate[SM_MODES], force[SM_MODES];
    sm_complex lag[SM_MODES]; /* along the flow: the force of friction less that in steady motion */
    double difference; /* tabulated: the friction power less what leaves the modes */
} sm_flow_change;

/* What the contacts feel at amplitudes y (2 modes) and the inputs that `instant` is set to: the
 * first four entries of the modes' states, a mode that is not there 0. */
void sm_feel(const sm_slow_flow *flow, const sm_instant *instant, const double *y,
             sm_mode_state mode[SM_MODES]);

/* At amplitudes y (2 modes) and the inputs that `instant` is set to. */
sm_status sm_first_order(const sm_slow_flow *flow, sm_instant *instant, const double *y,
                         sm_flow_state *state);

sm_flow_change sm_first_order_change(const sm_slow_flow *flow, const sm_instant *instant,
                                     const sm_flow_state *state, const sm_direction *along);

/* Along the flow itself. */
sm_flow_change sm_change_along_flow(const sm_slow_flow *flow, const sm_instant *instant,
                                    const sm_flow_state *state);

#endif

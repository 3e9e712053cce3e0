/* A component in memory, and its steps (component.c, component_steps.c). */
#ifndef SLIPMODE_COMPONENT_H
#define SLIPMODE_COMPONENT_H

#include "base/exact_sum.h"
#include "slow/component/contact_output.h"
#include "slow/discontinuity.h"

/* The slow state: doubles in the state of a component. */
typedef struct {
    sm_exact_sum time;              /* [s] */
    sm_exact_sum energy;            /* dissipated at the contacts [J] */
    sm_exact_sum angle[SM_MODES];   /* theta_j in [0, 2 pi) [rad] */
    double amplitude[2 * SM_MODES]; /* a_j [kg^1/2 m] */
    double step;                    /* next internal step, 0: not chosen yet [s] */
    sm_previous_force last_force;       /* up to the present time */
} sm_slow_state;

struct sm_component {
    sm_slow_flow flow;
    sm_contact_output contacts;
    double tolerance;
    sm_inputs inputs;
    sm_slow_state slow;
    uint64_t accepted, rejected;
    int rate_known; /* 1: `rate` is the derivative of the unknowns at present */
    double rate[SM_UNKNOWNS];
    sm_instant instant;
};

#endif

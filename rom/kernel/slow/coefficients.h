/* Coefficients of the amplitude equations at given inputs. */
#ifndef SLIPMODE_COEFFICIENTS_H
#define SLIPMODE_COEFFICIENTS_H

#include "base/cnumber.h"
#include "slow/inputs.h"

/* Coefficients of mass a' + stiffness a = force / 2 + c s G(e), e = c (a + shift force) / s, for
 * each mode, or the changes of all coefficients along a change of the inputs. */
typedef struct {
    sm_complex force[SM_MODES];    /* F exp(i phase) */
    sm_complex coupling[SM_MODES]; /* c = L_j(Omega_j) / L_j(carrier) */
    sm_complex mass[SM_MODES], stiffness[SM_MODES];
    double detuning[SM_MODES];     /* forcing frequency less the carrier of the table [rad/s] */
    double limit_scale;            /* s */
} sm_coefficients;

/* Coefficients at the last inputs of a series of evaluations, and products of them that each
 * evaluation needs: e = ratio a + offset, a' = (force / 2 + gain G) / mass - spring a. */
typedef struct {
    int known;    /* 0: no inputs yet */
    int constant; /* 1: only the angles of the inputs change, and `rate` is not set */
    sm_inputs inputs;
    sm_coefficients now, rate;
    sm_complex direction[SM_MODES]; /* exp(i phase) */
    sm_complex ratio[SM_MODES], offset[SM_MODES], gain[SM_MODES];
    sm_complex per_mass[SM_MODES], spring[SM_MODES];
    int32_t cell[SM_MODES];       /* cell of the friction table that was found last */
} sm_instant;

/* Evaluates the coefficients at `inputs`, unless only the angles differ from the last inputs. Equal
 * arguments give equal bits. */
void sm_instant_set(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs);

/* Sets the instant, which was set to `inputs`, to the inputs `elapsed` seconds later. */
void sm_instant_advance(sm_instant *instant, const sm_slow_flow *flow, const sm_inputs *inputs,
                        double elapsed);

/* Computes the change of the coefficients along a change of the inputs. */
void sm_coefficients_change(const sm_slow_flow *flow, const sm_instant *instant,
                            const sm_inputs *change, sm_coefficients *d);

/* Returns c = L_j(Omega) / L_j(carrier). */
SM_INLINE sm_complex sm_coupling_at(const sm_slow_flow *flow, int j, double Omega) {
    const double(*c)[2] = flow->coupling_ratio[j];
    return sm_cx(1.0 + c[0][0] - Omega * c[1][1], c[0][1] + Omega * c[1][0]);
}

/* Returns omega_j while mode j is forced at Omega [rad/s]. */
double sm_natural_at(const sm_slow_flow *flow, int j, double Omega);

/* Returns the distance of a frequency from the carrier of mode j [rad/s], limited to the range in
 * which the slope of the table in frequency is valid. */
double sm_detuning(const sm_slow_flow *flow, int j, double Omega);

#endif

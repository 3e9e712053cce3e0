/* Free vibrations that discontinuities of the forces leave behind.
 *
 * The slow flow follows the response of the modes that a force maintains. At a discontinuity
 * displacement and velocity of the modes are continuous, so that free vibrations make up the
 * difference; the header has their amplitudes. The component calls it at the start of a step, the
 * FMU in an event.
 */
#include "slow/discontinuity.h"

#include <math.h>
#include <string.h>

#include "base/cnumber.h"

sm_held_force sm_hold_force(const sm_inputs *inputs) {
    sm_held_force held = {.known = 1.0};
    memcpy(held.force, inputs->force, sizeof held.force);
    memcpy(held.phase, inputs->phase, sizeof held.phase);
    return held;
}

int sm_force_discontinuity(const sm_slow_flow *flow, const sm_held_force *held,
                           const sm_inputs *now, double *amplitude) {
    const int modes = flow->table.modes;
    const size_t size = (size_t)modes * sizeof(double);
    if (flow->paper || held->known == 0.0) return 0;
    if (memcmp(held->force, now->force, size) == 0 && memcmp(held->phase, now->phase, size) == 0)
        return 0;
    sm_complex discontinuity[SM_MODES]; /* times exp(i theta_j) */
    for (int j = 0; j < modes; j++)
        discontinuity[j] =
            sm_csub(sm_cscale(sm_unit(now->angle[j] + now->phase[j]), now->force[j]),
                    sm_cscale(sm_unit(now->angle[j] + held->phase[j]), held->force[j]));
    for (int k = 0; k < modes; k++) {
        const double decay = 0.5 * flow->damping[k], omega = flow->natural[k];
        if (decay >= omega) continue; /* overdamped: no vibration */
        const double omega_d = sqrt((omega - decay) * (omega + decay));
        const sm_complex both = sm_cx(flow->damping[k], 2.0 * (now->frequency[k] + omega_d));
        sm_complex left = sm_cx(0.0, sm_cdiv(discontinuity[k], both).re / omega_d);
        for (int j = 0; j < modes; j++) {
            const double *cross_response = flow->cross_response[k][j];
            const sm_complex q =
                sm_cmul(sm_cx(cross_response[0], cross_response[1]), discontinuity[j]);
            left.re -= q.re;
            left.im += (decay * q.re - now->frequency[j] * q.im) / omega_d;
        }
        left = sm_cmul(left, sm_unit(-now->angle[k]));
        amplitude[2 * k] += left.re;
        amplitude[2 * k + 1] += left.im;
    }
    return 1;
}

/* Free vibrations after discontinuities of the forces. The amplitudes of eqs. (18), (19)
 * follow the forced response of the modes. At a discontinuity of the force, displacement and
 * velocity of the modes are continuous: free vibrations with the amplitudes in the header are
 * the difference of both forced responses. The component calls it at the start of a step, the
 * FMU in an event. */
#include "slow/discontinuity.h"

#include <math.h>
#include <string.h>

#include "base/cnumber.h"
#include "slow/coefficients.h"

sm_previous_force sm_force_of(const sm_inputs *inputs) {
    sm_previous_force previous = {.known = 1.0};
    memcpy(previous.force, inputs->force, sizeof previous.force);
    memcpy(previous.phase, inputs->phase, sizeof previous.phase);
    return previous;
}

int sm_force_discontinuity(const sm_slow_flow *flow, const sm_previous_force *previous,
                           const sm_inputs *now, double *amplitude) {
    const int modes = flow->table.modes;
    const size_t size = (size_t)modes * sizeof(double);
    if (flow->paper || previous->known == 0.0) return 0;
    if (memcmp(previous->force, now->force, size) == 0
        && memcmp(previous->phase, now->phase, size) == 0)
        return 0;
    sm_complex discontinuity[SM_MODES]; /* times exp(i theta_j) */
    for (int j = 0; j < modes; j++)
        discontinuity[j] =
            sm_csub(sm_cscale(sm_unit(now->angle[j] + now->phase[j]), now->force[j]),
                    sm_cscale(sm_unit(now->angle[j] + previous->phase[j]), previous->force[j]));
    for (int k = 0; k < modes; k++) {
        const double decay = 0.5 * flow->damping[k];
        const double omega = sm_natural_at(flow, k, now->frequency[k]);
        if (decay >= omega) continue; /* overdamped: no vibration */
        const double omega_d = sqrt((omega - decay) * (omega + decay));
        const sm_complex both = sm_cx(flow->damping[k], 2.0 * (now->frequency[k] + omega_d));
        sm_complex vibration = sm_cx(0.0, sm_cdiv(discontinuity[k], both).re / omega_d);
        for (int j = 0; j < modes; j++) {
            const double *cross_response = flow->cross_response[k][j];
            const sm_complex q =
                sm_cmul(sm_cx(cross_response[0], cross_response[1]), discontinuity[j]);
            vibration.re -= q.re;
            vibration.im += (decay * q.re - now->frequency[j] * q.im) / omega_d;
        }
        vibration = sm_cmul(vibration, sm_unit(-now->angle[k]));
        amplitude[2 * k] += vibration.re;
        amplitude[2 * k + 1] += vibration.im;
    }
    return 1;
}

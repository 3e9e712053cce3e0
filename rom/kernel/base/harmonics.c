/* Phasors exp(i (n theta_A + m theta_B)) of harmonics, eq. (14), as products of powers of the two
 * carriers; powers by products of phasors. Called for the motion along a trajectory (slow/motion/),
 * the response of the modes (slow/component/response_surface.c), the combination resonances
 * (slow/friction_model.c) and the phase lines (torus/phases.c). */
#include <stdlib.h>

#include "base/cnumber.h"

void sm_powers(size_t count, size_t powers, double *power) {
    const size_t both = 2 * count;
    for (size_t k = 0; k < both; k++) power[k] = k < count ? 1.0 : 0.0;
    for (size_t m = 2; m < powers; m++) {
        double *next = power + m * both;
        memcpy(next, next - both, both * sizeof *next);
        sm_turn(count, next, next + count, power + both, power + both + count);
    }
}

void sm_harmonic_phasors(int count, const int32_t *orders, const sm_complex carrier[SM_MODES],
                         double *re, double *im) {
    double power[SM_HIGHEST_ORDER + 1][2][SM_MODES];
    int highest = 0;
    for (int k = 0; k < 2 * count; k++)
        if (abs(orders[k]) > highest) highest = abs(orders[k]);
    for (int j = 0; j < SM_MODES; j++) {
        power[1][0][j] = carrier[j].re;
        power[1][1][j] = carrier[j].im;
    }
    sm_powers(SM_MODES, (size_t)highest + 1, power[0][0]);
    for (int q = 0; q < count; q++) {
        sm_complex factor[SM_MODES];
        for (int j = 0; j < SM_MODES; j++) {
            const int n = orders[2 * q + j];
            factor[j] = sm_cx(power[abs(n)][0][j], copysign(1.0, n) * power[abs(n)][1][j]);
        }
        const sm_complex phasor = sm_cmul(factor[0], factor[1]);
        re[q] = phasor.re;
        im[q] = phasor.im;
    }
}

sm_status sm_orders_check(int count, const int32_t *orders) {
    if (count < 0 || count > SM_MOST_ORDERS || (count > 0 && !orders)) return SM_BAD_ARGUMENT;
    for (int k = 0; k < 2 * count; k++)
        if (orders[k] < -SM_HIGHEST_ORDER || orders[k] > SM_HIGHEST_ORDER) return SM_BAD_ARGUMENT;
    return SM_OK;
}

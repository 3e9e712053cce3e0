/* Phasors exp(i (n theta_A + m theta_B)) of harmonics, eq. (14), as products of powers of the two
 * carriers. Called for the motion along a trajectory (slow/motion/) and the response of the modes
 * (slow/component/response_surface.c). */
#include "base/cnumber.h"

#define MOST_ORDER 128 /* limit of |n| and |m|: powers are on the stack; tables have up to 15 */

/* Computes z^k for k = -highest ... highest, |z| = 1; `power` points at k = 0. */
static void fill_powers(sm_complex z, int highest, sm_complex *power) {
    power[0] = sm_cx(1.0, 0.0);
    for (int k = 1; k <= highest; k++) {
        power[k] = sm_cmul(power[k - 1], z);
        power[-k] = sm_conj(power[k]);
    }
}

/* Finds the highest |n| and the highest |m|. */
static void highest_orders(int count, const int32_t *orders, int highest[SM_MODES]) {
    int32_t a = 0, b = 0;
    for (int q = 0; q < count; q++) {
        const int32_t n = orders[2 * q] < 0 ? -orders[2 * q] : orders[2 * q];
        const int32_t m = orders[2 * q + 1] < 0 ? -orders[2 * q + 1] : orders[2 * q + 1];
        a = n > a ? n : a;
        b = m > b ? m : b;
    }
    highest[0] = a;
    highest[1] = b;
}

void sm_harmonic_phasors(int count, const int32_t *orders, const sm_complex carrier[SM_MODES],
                         double *re, double *im) {
    sm_complex a[2 * MOST_ORDER + 1], b[2 * MOST_ORDER + 1];
    int highest[SM_MODES];
    highest_orders(count, orders, highest);
    fill_powers(carrier[0], highest[0], a + MOST_ORDER);
    fill_powers(carrier[1], highest[1], b + MOST_ORDER);
    for (int q = 0; q < count; q++) {
        const sm_complex phasor =
            sm_cmul(a[MOST_ORDER + orders[2 * q]], b[MOST_ORDER + orders[2 * q + 1]]);
        re[q] = phasor.re;
        im[q] = phasor.im;
    }
}

sm_status sm_orders_check(int count, const int32_t *orders) {
    if (count < 0 || count > SM_MOST_ORDERS || (count > 0 && !orders)) return SM_BAD_ARGUMENT;
    for (int k = 0; k < 2 * count; k++)
        if (orders[k] < -MOST_ORDER || orders[k] > MOST_ORDER) return SM_BAD_ARGUMENT;
    return SM_OK;
}

#include "base/harmonics.h"

#define MOST_ORDER 32 /* |n| and |m| of a harmonic */

/* z^k for k = -highest ... highest, z on the unit circle; power points at k = 0. */
static void fill_powers(sm_complex z, int highest, sm_complex *power) {
    power[0] = sm_cx(1.0, 0.0);
    for (int k = 1; k <= highest; k++) {
        power[k] = sm_cmul(power[k - 1], z);
        power[-k] = sm_conj(power[k]);
    }
}

static int highest_order(int count, const int32_t *orders, int mode) {
    int highest = 0;
    for (int q = 0; q < count; q++) {
        const int k = orders[2 * q + mode];
        highest = k > highest ? k : -k > highest ? -k : highest;
    }
    return highest;
}

void sm_harmonic_phasors(int count, const int32_t *orders, const sm_complex carrier[SM_MODES],
                         double *re, double *im) {
    sm_complex a[2 * MOST_ORDER + 1], b[2 * MOST_ORDER + 1];
    fill_powers(carrier[0], highest_order(count, orders, 0), a + MOST_ORDER);
    fill_powers(carrier[1], highest_order(count, orders, 1), b + MOST_ORDER);
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

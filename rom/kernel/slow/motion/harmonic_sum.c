/* Fast motion at given times as a sum of harmonics with slowly varying coefficients, eq. (14),
 * x(t) = 2 Re (sum_j shape_j a_j exp(i theta_j) + sum_nm c_nm exp(i (n theta_A + m theta_B))), with
 * the amplitudes of the segments and coefficients that are linear between their ends.
 * rom/slow/motion.py calls it for contacts, modes and loads.
 */
#include "base/check.h"
#include "base/cnumber.h"
#include "base/lanes.h"
#include "slow/motion/segment.h"

/* Returns Re sum_q c_q (re_q + i im_q); c has a row of real parts, then a row of imaginary
 * parts. */
SM_INLINE double real_product(size_t count, const double *restrict c, const double *restrict re,
                              const double *restrict im) {
    double sum = 0.0;
    SM_SIMD_SUM(sum)
    for (size_t q = 0; q < count; q++) sum += c[q] * re[q] - c[count + q] * im[q];
    return sum;
}

/* Computes the signals `elapsed` seconds after the start of a segment. */
SM_HOT static void sum_at(const sm_harmonic_sum *sum, const sm_segment *g, const double *start,
                          double elapsed, double *out) {
    const size_t orders = (size_t)sum->orders_count, signals = sum->signals;
    const double *end = start + signals * 2 * orders;
    const double r = elapsed / g->duration;
    double re[SM_MOST_ORDERS], im[SM_MOST_ORDERS];
    sm_complex carrier[SM_MODES], q[SM_MODES] = {{0.0, 0.0}, {0.0, 0.0}};
    sm_segment_carriers(g, sum->modes, elapsed, carrier);
    sm_harmonic_phasors(sum->orders_count, sum->orders, carrier, re, im);
    for (int j = 0; j < sum->modes; j++) {
        sm_complex rate;
        q[j] = sm_cmul(sm_segment_amplitude(g, j, r, &rate), carrier[j]);
    }
    for (size_t s = 0; s < signals; s++) {
        const size_t row = s * 2 * orders;
        double value = (1.0 - r) * real_product(orders, start + row, re, im)
                       + r * real_product(orders, end + row, re, im);
        for (int j = 0; j < sum->modes; j++) value += sum->shape[(size_t)j * signals + s] * q[j].re;
        out[s] = 2.0 * value;
    }
}

/* Checks the arrays of the sum for a number of segments. */
static sm_status check_sum(const sm_harmonic_sum *sum, size_t segments) {
    if (!sum || sum->modes < 1 || sum->modes > SM_MODES) return SM_BAD_ARGUMENT;
    const size_t orders = (size_t)sum->orders_count;
    SM_TRY(sm_orders_check(sum->orders_count, sum->orders));
    if (sum->signals < 1 || !sum->shape || (orders > 0 && !sum->coefficient))
        return SM_BAD_ARGUMENT;
    const size_t per_point = sum->signals * (orders > 0 ? 2 * orders : 1);
    if (!sm_fits(sum->signals, 2 * SM_MOST_ORDERS * sizeof(double)) ||
        !sm_fits(segments + 1, per_point * sizeof(double)))
        return SM_BAD_ARGUMENT;
    if (!sm_all_finite(sum->shape, (size_t)sum->modes * sum->signals) ||
        !sm_all_finite(sum->coefficient, orders > 0 ? (segments + 1) * per_point : 0))
        return SM_NOT_FINITE;
    return SM_OK;
}

sm_status sm_harmonic_motion(const sm_harmonic_sum *sum, size_t segments,
                             const sm_segment *segment, size_t samples, const double *times,
                             double *motion) {
    SM_TRY(check_sum(sum, segments));
    SM_TRY(sm_segments_check(segments, segment, sum->modes));
    SM_TRY(sm_times_check(samples, times, segments, segment));
    if (!sm_fits(samples, sum->signals * sizeof(double)) || (samples > 0 && !motion))
        return SM_BAD_ARGUMENT;
    const size_t per_point = sum->signals * 2 * (size_t)sum->orders_count;
    size_t g = 0;
    for (size_t k = 0; k < samples; k++) {
        while (g + 1 < segments && times[k] >= sm_segment_end(&segment[g])) g++;
        sum_at(sum, &segment[g], sum->coefficient + g * per_point, times[k] - segment[g].start,
               motion + k * sum->signals);
    }
    return sm_all_finite(motion, samples * sum->signals) ? SM_OK : SM_NOT_FINITE;
}

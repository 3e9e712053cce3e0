/* The march on the torus that all contact laws share: response of the modes, scales of the motion.
 *
 * R = H Y, the response of the modes (docs/theory.md, "The contact problem"), is a sum over the
 * contacts for each harmonic. Differences of harmonics are relative to the motion that the modes
 * cause. The search for periodic motion (periodic/) and the marches (rigid/, elastic/) call it. */
#include "torus/march.h"

#include <math.h>
#include <string.h>

#include "base/lanes.h"

#define WIDTH SM_VECTOR

/* Adds the product of a row of H and Y, `count` real and imaginary parts each, to `to`. Products
 * of equal parts (re re, im im) and of different parts (re im, im re) have independent sums. */
SM_INLINE void add_product(size_t count, const double *restrict row, const double *restrict Y,
                           double to[2]) {
    double same[WIDTH] = {0.0}, other[WIDTH] = {0.0}; /* stay in registers */
    size_t k = 0;
    for (; k + WIDTH <= count; k += WIDTH)
        for (size_t j = 0; j < WIDTH; j++) {
            same[j] += row[k + j] * Y[k + j];
            other[j] += row[k + j] * Y[k + (j ^ 1)];
        }
    for (size_t j = 0; k + j < count; j++) {
        same[j] += row[k + j] * Y[k + j];
        other[j] += row[k + j] * Y[k + (j ^ 1)];
    }
    for (size_t j = 0; j < WIDTH; j += 2) {
        to[0] += same[j] - same[j + 1];
        to[1] += other[j] + other[j + 1];
    }
}

SM_HOT void sm_respond(const sm_contact *contact, const double *Y, double *R) {
    const sm_modal_response *response = contact->response;
    const double *H = response->dynamic_stiffness;
    const size_t orders = (size_t)response->orders_count, n = (size_t)contact->contacts;
    if (response->prescribed)
        memcpy(R, response->prescribed, 2 * orders * n * sizeof(double));
    else
        memset(R, 0, 2 * orders * n * sizeof(double));
    for (size_t q = 0; q < orders; q++, Y += 2 * n)
        for (size_t i = 0; i < n; i++, H += 2 * n, R += 2) add_product(2 * n, H, Y, R);
}

sm_scales sm_scales_at(const sm_contact *contact, const double *amplitude,
                       const double *smallest_scale) {
    const size_t n = (size_t)contact->contacts;
    const int elastic = contact->law == SM_ELASTIC;
    sm_scales scales = {{0.0, 0.0}, 0.0, 0.0};
    for (int j = 0; j < contact->modes; j++) {
        const double a = fmax(amplitude[j], smallest_scale[j]);
        double motion = 0.0;
        for (size_t i = 0; i < n; i++) {
            const double *L = contact->coupling + 2 * ((size_t)j * n + i);
            const double force = (elastic ? 1.0 : 2.0) * hypot(L[0], L[1]) * a;
            motion = fmax(motion, elastic ? force * contact->elastic->reference[i]
                                          : force / contact->stiffness[i * n + i]);
            scales.response = fmax(scales.response, force);
        }
        scales.of_mode[j] = elastic ? 0.0 : motion;
        scales.motion = fmax(scales.motion, motion);
    }
    return scales;
}

/* Harmonics of one mode are measured by the displacement due to this mode, so that a weak mode is
 * as accurate as a strong one. Mixed harmonics, and harmonics of a mode at rest, are measured by
 * the largest displacement. */
double sm_scale_of(const sm_scales *scales, const int32_t *order) {
    const double own = order[1] == 0   ? scales->of_mode[0]
                       : order[0] == 0 ? scales->of_mode[1]
                                       : 0.0;
    return own > 0.0 ? own : fmax(scales->motion, SM_TINY);
}

double sm_relative_distance(const sm_march *m, const sm_scales *scales, const double *one,
                            const double *other) {
    const size_t each = 2 * (size_t)m->contact->contacts, all = sm_march_harmonics(m);
    double largest = 0.0;
    for (size_t k = 0; k < all && scales->motion > 0.0; k++)
        largest = fmax(largest, fabs(one[k] - other[k])
                                    / sm_scale_of(scales, m->task->grid->orders + k / each * 2));
    return largest;
}

int sm_is_odd(const sm_discretisation *grid) {
    for (int q = 0; q < grid->orders_count; q++)
        if ((grid->orders[2 * q] + grid->orders[2 * q + 1]) % 2 == 0) return 0;
    return grid->steps % 2 == 0;
}

#include "torus/march.h"

#include <string.h>

#include "base/lanes.h"

#define WIDTH SM_VECTOR

/* to += row Y of `count` real and imaginary parts: products of parts that lie side by side, and of
 * those that lie across, in sums that do not wait for each other. */
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
    if (response->held)
        memcpy(R, response->held, 2 * orders * n * sizeof(double));
    else
        memset(R, 0, 2 * orders * n * sizeof(double));
    for (size_t q = 0; q < orders; q++, Y += 2 * n)
        for (size_t i = 0; i < n; i++, H += 2 * n, R += 2) add_product(2 * n, H, Y, R);
}

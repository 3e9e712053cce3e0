#include "contact/elastic/reversal.h"

#include <math.h>

#define SLID 1e-9 /* what a slider that slid may be off its limit by rounding, relative to that */

/* How far beyond z[1] the parabola through three points rises, if z[1] is the highest. */
static double rise(const double z[3]) {
    const double bend = 2.0 * z[1] - z[0] - z[2], slope = z[2] - z[0];
    return z[1] > z[0] && z[1] > z[2] ? slope * slope / (8.0 * bend) : 0.0;
}

/* Whether a slider that is stretched so far, or pulls as much, is at its limit. */
static int slid(double stretch, double limit) {
    return fabs(fabs(stretch) - limit) <= SLID * limit;
}

/* How far the slider at s goes on that slid at x[1] with its stretch `limit` and sticks at x[2]. */
static double further(const double x[3], const double limit[3], double s) {
    const double direction = copysign(1.0, x[1] - s);
    double z[3];
    for (int k = 0; k < 3; k++) z[k] = direction * x[k] - limit[k];
    return direction * rise(z);
}

static void sliders(const sm_elastic *elastic, const sm_element *element, const double x[3],
                    double *memory) {
    for (int k = 0; k < element->sliders; k++) {
        const double *slider = elastic->slider + 2 * (size_t)(element->first_slider + k);
        if (!slid(slider[1] * (x[1] - memory[k]), slider[0])) continue;
        const double stretch = slider[0] / slider[1], limit[3] = {stretch, stretch, stretch};
        memory[k] += further(x, limit, memory[k]);
    }
}

static void frictional(const sm_element *element, const double x[3], const double normal[3],
                       double *memory) {
    double limit[3];
    for (int k = 0; k < 3; k++) {
        const double pressed =
            element->preload + element->normal_stiffness * (normal[k] - element->gap);
        if (pressed <= 0.0) return; /* it touches down: sliders stop there */
        limit[k] = element->friction / element->tangential_stiffness * pressed;
    }
    if (slid(x[1] - memory[0], limit[1])) memory[0] += further(x, limit, memory[0]);
}

void sm_elastic_reverse(const sm_elastic *elastic, const double *const x[3], double *memory) {
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        const int32_t *column = element->column;
        const double along[3] = {x[0][column[0]], x[1][column[0]], x[2][column[0]]};
        if (element->law == SM_SLIDERS) {
            sliders(elastic, element, along, memory);
        } else if (element->tangents == 1) {
            const double normal[3] = {x[0][column[1]], x[1][column[1]], x[2][column[1]]};
            frictional(element, along, normal, memory);
        }
        memory += sm_element_memory(element);
    }
}

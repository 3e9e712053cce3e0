#include "contact/elastic/reversal.h"

#include <math.h>

/* How far beyond z[1] the parabola through three points rises, if z[1] is the highest. */
static double rise(const double z[3]) {
    const double bend = 2.0 * z[1] - z[0] - z[2], slope = z[2] - z[0];
    return z[1] > z[0] && z[1] > z[2] ? slope * slope / (8.0 * bend) : 0.0;
}

/* Whether a slider that is stretched so far, or pulls as much, is at its limit, to rounding. */
static int slid(double stretch, double limit) {
    return fabs(fabs(stretch) - limit) <= 1e-9 * limit;
}

/* y misses as much at the last step and, if the contact was farthest before the middle one, at that
 * too, which is over. */
static void miss(const sm_reversal *r, int32_t i, double correction, int before) {
    if (!r->now) return;
    r->now[i] += correction;
    r->before[i] += before ? correction : 0.0;
}

static void sliders(const sm_elastic *elastic, const sm_element *element, const sm_reversal *r,
                    double *memory) {
    const int32_t i = element->column[0];
    const double *slider = elastic->slider + 2 * (size_t)element->first_slider;
    double stiffness = 0.0, direction = 0.0, z[3];
    for (int k = 0; k < element->sliders; k++) {
        const double stretch = r->x[i] - memory[k];
        if (!slid(slider[2 * k + 1] * stretch, slider[2 * k])) continue;
        stiffness += slider[2 * k + 1];
        direction = copysign(1.0, stretch);
    }
    if (stiffness == 0.0) return;
    for (int k = 0; k < 3; k++) z[k] = direction * r->z[k][i];
    const double further = direction * rise(z) / (1.0 - r->gives[i] * stiffness);
    for (int k = 0; k < element->sliders; k++)
        if (slid(slider[2 * k + 1] * (r->x[i] - memory[k]), slider[2 * k])) memory[k] += further;
    miss(r, i, stiffness * further, z[2] <= z[0]);
}

static void frictional(const sm_element *element, const sm_reversal *r, double *memory) {
    const int32_t i = element->column[0], normal = element->column[1];
    const double stretch = r->x[i] - memory[0], direction = copysign(1.0, stretch);
    double limit[3], z[3];
    for (int k = 0; k < 3; k++) {
        const double pressed = element->preload
                               + element->normal_stiffness * (r->z[k][normal] - element->gap);
        if (pressed <= 0.0) return; /* it touches down: sliders stop there */
        limit[k] = element->friction / element->tangential_stiffness * pressed;
        z[k] = direction * r->z[k][i] - limit[k];
    }
    if (slid(stretch, limit[1])) memory[0] += direction * rise(z);
}

void sm_elastic_reverse(const sm_elastic *elastic, const sm_reversal *reversal, double *memory) {
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        if (element->law == SM_SLIDERS)
            sliders(elastic, element, reversal, memory);
        else if (element->tangents == 1)
            frictional(element, reversal, memory);
        memory += sm_element_memory(element);
    }
}

/* y has a kink where its slider begins to slide, after a part of the step. The error of means over
 * steps is the second Bernoulli polynomial of that part, times the motion in a step. */
static void begin(const double slider[2], double soft, double stretch, double moved, double *now) {
    if (moved == 0.0 || slid(slider[1] * stretch, slider[0])) return;
    const double direction = copysign(1.0, moved);
    const double stuck = slider[0] / slider[1] - direction * stretch;
    const double step = stuck + soft * fabs(moved), part = stuck / step;
    *now += direction * slider[1] * step / soft * (1.0 / 12.0 - 0.5 * part * (1.0 - part));
}

static void sliders_begin(const sm_elastic_solver *s, const sm_element *element, const double *x,
                          const double *memory, const double *next, double *now) {
    const size_t i = (size_t)element->column[0], n = (size_t)s->contacts;
    const double *slider = s->elastic->slider + 2 * (size_t)element->first_slider;
    double soft = 1.0;
    for (int k = 0; k < element->sliders; k++)
        if (next[k] != memory[k]) soft -= s->flexibility[i * n + i] * slider[2 * k + 1];
    for (int k = 0; k < element->sliders; k++)
        begin(slider + 2 * k, soft, x[i] - memory[k], next[k] - memory[k], now + i);
}

void sm_elastic_begin(const sm_elastic_solver *s, const double *x, const double *memory,
                      double *now) {
    const sm_element *element = s->elastic->element;
    const double *next = s->next;
    for (int k = 0; k < s->yielding && s->jenkins; k++) {
        const int32_t i = s->active[k];
        sliders_begin(s, element + i, x, memory + i, next + i, now);
    }
    for (int32_t e = 0; e < s->elastic->elements && !s->jenkins; e++) {
        const int remembered = sm_element_memory(element + e);
        if (element[e].law == SM_SLIDERS) sliders_begin(s, element + e, x, memory, next, now);
        memory += remembered;
        next += remembered;
    }
}

#include "contact/elastic/reversal.h"

#include "base/check.h"

double sm_rise(const double z[3]) {
    const double bend = 2.0 * z[1] - z[0] - z[2], slope = z[2] - z[0];
    return z[1] > z[0] && z[1] > z[2] ? slope * slope / (8.0 * bend) : 0.0;
}

/* Returns whether a slider with this force (or stretch) is at its limit, to rounding. */
static int slides(double force, double limit) {
    return fabs(fabs(force) - limit) <= SM_ROUNDING_TOLERANCE * limit;
}

/* Moves the sliders of an element that turned back. The error of y lasts from the reversal on: it
 * is in the middle step too if the contact turned back before that. */
static void reverse_sliders(const sm_elastic *elastic, const sm_element *element,
                            const sm_reversal *r, double *memory) {
    const int32_t i = element->column[0];
    const double *slider = elastic->slider + 2 * (size_t)element->first_slider;
    double stiffness = 0.0, direction = 0.0, z[3];
    for (int k = 0; k < element->sliders; k++) {
        const double stretch = r->x[i] - memory[k];
        if (!slides(slider[2 * k + 1] * stretch, slider[2 * k])) continue;
        stiffness += slider[2 * k + 1];
        direction = copysign(1.0, stretch);
    }
    if (stiffness == 0.0) return;
    for (int k = 0; k < 3; k++) z[k] = direction * r->z[k][i];
    const double further = direction * sm_rise(z) / (1.0 - r->compliance[i] * stiffness);
    for (int k = 0; k < element->sliders; k++)
        if (slides(slider[2 * k + 1] * (r->x[i] - memory[k]), slider[2 * k])) memory[k] += further;
    if (!r->now) return;
    r->now[i] += stiffness * further;
    r->before[i] += z[2] <= z[0] ? stiffness * further : 0.0;
}

/* Moves the slider of a frictional contact that turned back, relative to its varying limit. */
static void reverse_frictional(const sm_element *element, const sm_reversal *r, double *memory) {
    const int32_t i = element->column[0], normal = element->column[1];
    const double at_rest = element->tangential_preload[0] / element->tangential_stiffness;
    const double stretch = at_rest + r->x[i] - memory[0], direction = copysign(1.0, stretch);
    double limit[3], z[3];
    for (int k = 0; k < 3; k++) {
        const double N = element->preload
                         + element->normal_stiffness * (r->z[k][normal] - element->gap);
        if (N <= 0.0) return; /* the contact touches down, and its slider stops there */
        limit[k] = element->friction / element->tangential_stiffness * N;
        z[k] = direction * r->z[k][i] - limit[k];
    }
    if (slides(stretch, limit[1])) memory[0] += direction * sm_rise(z);
}

void sm_elastic_reverse(const sm_elastic *elastic, const sm_reversal *reversal, double *memory) {
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        if (element->law == SM_SLIDERS)
            reverse_sliders(elastic, element, reversal, memory);
        else if (element->tangents == 1)
            reverse_frictional(element, reversal, memory);
        memory += sm_element_memory(element);
    }
}

/* Returns the error of means of y by the kink where a slider begins to slide, after a part of the
 * step: the second Bernoulli polynomial of this part, times the motion in the step. `soft` is the
 * ratio of the displacements of a sticking and a sliding contact. */
static double begin_error(const double slider[2], double soft, double stretch, double moved) {
    if (moved == 0.0 || slides(slider[1] * stretch, slider[0])) return 0.0;
    const double direction = copysign(1.0, moved);
    const double stuck = slider[0] / slider[1] - direction * stretch;
    const double step = stuck + soft * fabs(moved), part = stuck / step;
    return direction * slider[1] * step / soft * (1.0 / 12.0 - 0.5 * part * (1.0 - part));
}

void sm_elastic_begin(const sm_elastic_solver *s, const double *x, const double *memory,
                      double *now) {
    const double *next = s->next;
    for (int32_t e = 0; e < s->elastic->elements; e++) {
        const sm_element *element = s->elastic->element + e;
        const int begins = element->law == SM_SLIDERS && s->state[e] == SM_SLIP;
        const int sliders = begins ? element->sliders : 0;
        const size_t i = (size_t)element->column[0], diagonal = i * (size_t)(s->contacts + 1);
        const double *slider = s->elastic->slider + 2 * (size_t)element->first_slider;
        double soft = 1.0;
        for (int k = 0; k < sliders; k++)
            if (next[k] != memory[k]) soft -= s->flexibility[diagonal] * slider[2 * k + 1];
        for (int k = 0; k < sliders; k++)
            now[i] += begin_error(slider + 2 * k, soft, x[i] - memory[k], next[k] - memory[k]);
        memory += sm_element_memory(element);
        next += sm_element_memory(element);
    }
}

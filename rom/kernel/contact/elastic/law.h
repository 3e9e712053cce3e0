/* Elastic contact laws as return maps: f = law(x, memory), and its tangent.
 *
 * Memory is where the sliders are: a slider of stiffness k at s pulls with k (x - s), at most with
 * its limit, and follows x beyond. Where the limit varies it is also where the contact was. The
 * reference stiffness is that of the contact while it sticks.
 */
#ifndef SLIPMODE_ELASTIC_LAW_H
#define SLIPMODE_ELASTIC_LAW_H

#include <math.h>

#include "slipmode.h"

#define SM_MOST_COLUMNS 3 /* of an element: two tangential directions and the normal */

/* What an element does to the contact DOFs that it has, in its own order of them. */
typedef struct {
    double force[SM_MOST_COLUMNS];
    double tangent[SM_MOST_COLUMNS][SM_MOST_COLUMNS]; /* d force / d x */
    sm_contact_state state;
    double *next; /* set by the caller: where the memory after the motion goes; may be `memory` */
} sm_element_force;

/* Contact DOFs of an element. */
static inline int sm_element_columns(const sm_element *element) {
    return element->law == SM_SLIDERS ? 1 : element->tangents + 1;
}

/* Doubles that an element remembers. */
static inline int sm_element_memory(const sm_element *element) {
    return element->law == SM_SLIDERS ? element->sliders : 2 * element->tangents + 1;
}

/* Whether any contact slides in two directions. */
static inline int sm_elastic_slides_in_two(const sm_elastic *elastic) {
    int found = 0;
    for (int32_t e = 0; e < elastic->elements; e++)
        found |= elastic->element[e].law == SM_FRICTIONAL && elastic->element[e].tangents == 2;
    return found;
}

/* Jenkins elements side by side (Jenkins' law and Iwan's) at displacement x. */
static inline void sm_sliders_evaluate(const sm_elastic *elastic, const sm_element *element,
                                       double scale, double x, const double *memory,
                                       sm_element_force *result) {
    double sum = 0.0, tangent = 0.0;
    result->state = SM_STICK;
    for (int k = 0; k < element->sliders; k++) {
        const double *slider = elastic->slider + 2 * (size_t)(element->first_slider + k);
        const double limit = scale * slider[0], stiffness = slider[1];
        const double trial = stiffness * (x - memory[k]);
        if (fabs(trial) <= limit) {
            sum += trial;
            tangent += stiffness;
            result->next[k] = memory[k];
        } else {
            const double force = copysign(limit, trial);
            sum += force;
            result->next[k] = x - force / stiffness;
            result->state = SM_SLIP;
        }
    }
    result->force[0] = sum;
    result->tangent[0][0] = tangent;
}

/* Any element at displacements x (N_c), reached from `memory`, with limits and preloads times
 * `scale`. */
void sm_element_evaluate(const sm_elastic *elastic, const sm_element *element, double scale,
                         const double *x, const double *memory, sm_element_force *result);

/* Whether limits and preloads times s make x and f s times as large: there is no gap. */
int sm_elastic_homogeneous(const sm_elastic *elastic);

sm_status sm_elastic_check(const sm_elastic *elastic, int32_t contacts);

/* Friction with a varying normal force, frictional.c, at displacements x of the element's columns. */
void sm_frictional_evaluate(const sm_element *element, double scale, const double *x,
                            const double *memory, sm_element_force *result);

#endif

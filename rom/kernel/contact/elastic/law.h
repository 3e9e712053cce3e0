/* Elastic contact laws as return maps: f = law(x, memory), and the tangent df/dx.
 *
 * A slider of stiffness k at position s has the force k (x - s) up to its limit; beyond, it follows
 * x. The memory holds the positions s of the sliders since rest; if the limit varies, also the
 * displacements of the previous step. Forces are changes since rest, where a frictional contact has
 * its preloads. The reference stiffness is the stiffness of a sticking contact. solve.c and
 * sm_elastic_force evaluate the laws.
 */
#ifndef SLIPMODE_ELASTIC_LAW_H
#define SLIPMODE_ELASTIC_LAW_H

#include <math.h>

#include "slipmode.h"

#define SM_MOST_COLUMNS 3 /* of an element: two tangential directions and the normal */

/* Forces of an element on its contact DOFs, in the order of its columns. */
typedef struct {
    double force[SM_MOST_COLUMNS];
    double tangent[SM_MOST_COLUMNS][SM_MOST_COLUMNS]; /* d force / d x */
    sm_contact_state state;
    double *next; /* set by the caller: receives the memory after the motion; may be `memory` */
} sm_element_force;

/* Returns the number of contact DOFs of an element. */
static inline int sm_element_columns(const sm_element *element) {
    return element->law == SM_SLIDERS ? 1 : element->tangents + 1;
}

/* Returns the number of doubles that an element remembers. */
static inline int sm_element_memory(const sm_element *element) {
    return element->law == SM_SLIDERS ? element->sliders : 2 * element->tangents + 1;
}

/* Returns whether any contact slides in two directions. */
static inline int sm_elastic_slides_in_two(const sm_elastic *elastic) {
    int found = 0;
    for (int32_t e = 0; e < elastic->elements; e++)
        found |= elastic->element[e].law == SM_FRICTIONAL && elastic->element[e].tangents == 2;
    return found;
}

/* Evaluates parallel Jenkins elements (Jenkins' law and Iwan's) at displacement x. */
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

/* Evaluates any element at displacements x (N_c), reached from `memory`, with limits and preloads
 * times `scale`. */
void sm_element_evaluate(const sm_elastic *elastic, const sm_element *element, double scale,
                         const double *x, const double *memory, sm_element_force *result);

/* Returns whether x and f are proportional to a common factor of limits and preloads: no gap. */
int sm_elastic_homogeneous(const sm_elastic *elastic);

/* Checks that each contact DOF belongs to one element, and the parameters of all laws. */
sm_status sm_elastic_check(const sm_elastic *elastic, int32_t contacts);

/* Evaluates friction with a varying normal force, at displacements x of the element's columns. */
void sm_frictional_evaluate(const sm_element *element, double scale, const double *x,
                            const double *memory, sm_element_force *result);

#endif

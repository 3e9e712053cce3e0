#include "contact/elastic/law.h"

#include <string.h>

#include "base/check.h"
#include "contact/elastic/frictional.h"

#define MOST_SLIDERS 100000

size_t sm_elastic_memory(const sm_elastic *elastic) {
    size_t count = 0;
    for (int32_t k = 0; k < elastic->elements; k++)
        count += (size_t)sm_element_memory(&elastic->element[k]);
    return count;
}

int sm_elastic_homogeneous(const sm_elastic *elastic) {
    for (int32_t k = 0; k < elastic->elements; k++)
        if (elastic->element[k].law == SM_FRICTIONAL && elastic->element[k].gap > 0.0) return 0;
    return 1;
}

/* Jenkins elements side by side: Jenkins' law, Iwan's. */
static void sliders(const sm_elastic *elastic, const sm_element *element, double scale, double x,
                    const double *memory, sm_element_force *result, double *next) {
    result->force[0] = result->tangent[0][0] = 0.0;
    result->state = SM_STICK;
    for (int k = 0; k < element->sliders; k++) {
        const double *slider = elastic->slider + 2 * (size_t)(element->first_slider + k);
        const double limit = scale * slider[0], stiffness = slider[1];
        const double trial = stiffness * (x - memory[k]);
        if (fabs(trial) <= limit) {
            result->force[0] += trial;
            result->tangent[0][0] += stiffness;
            next[k] = memory[k];
        } else {
            const double force = copysign(limit, trial);
            result->force[0] += force;
            next[k] = x - force / stiffness;
            result->state = SM_SLIP;
        }
    }
}

void sm_element_evaluate(const sm_elastic *elastic, const sm_element *element, double scale,
                         const double *x, const double *memory, sm_element_force *result,
                         double *next) {
    if (element->law == SM_SLIDERS) {
        sliders(elastic, element, scale, x[element->column[0]], memory, result, next);
        return;
    }
    double own[SM_MOST_COLUMNS] = {0.0};
    for (int k = 0; k <= element->tangents; k++) own[k] = x[element->column[k]];
    sm_frictional_evaluate(element, scale, own, memory, result, next);
}

static int allowed_columns(const sm_element *element, int32_t contacts) {
    for (int k = 0; k < sm_element_columns(element); k++) {
        if (element->column[k] < 0 || element->column[k] >= contacts) return 0;
        for (int j = 0; j < k; j++)
            if (element->column[j] == element->column[k]) return 0;
    }
    return 1;
}

static sm_status check_sliders(const sm_elastic *elastic, const sm_element *element) {
    if (element->sliders < 1 || element->first_slider < 0 ||
        element->first_slider > elastic->sliders - element->sliders)
        return SM_BAD_ARGUMENT;
    const double *slider = elastic->slider + 2 * (size_t)element->first_slider;
    if (!sm_all_finite(slider, 2 * (size_t)element->sliders)) return SM_NOT_FINITE;
    for (int k = 0; k < element->sliders; k++)
        if (slider[2 * k] < 0.0 || !(slider[2 * k + 1] > 0.0)) return SM_BAD_ARGUMENT;
    return SM_OK;
}

static sm_status check_frictional(const sm_element *element) {
    const double values[] = {element->friction, element->preload, element->gap,
                             element->tangential_stiffness, element->normal_stiffness};
    if (element->tangents < 1 || element->tangents > 2) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(values, sizeof values / sizeof *values)) return SM_NOT_FINITE;
    return element->friction >= 0.0 && element->preload >= 0.0 && element->gap >= 0.0 &&
                   element->tangential_stiffness > 0.0 && element->normal_stiffness > 0.0
               ? SM_OK : SM_BAD_ARGUMENT;
}

sm_status sm_elastic_check(const sm_elastic *elastic, int32_t contacts) {
    if (!elastic || elastic->elements < 1 || elastic->elements > contacts || !elastic->element ||
        !elastic->reference || elastic->sliders < 0 || elastic->sliders > MOST_SLIDERS ||
        (elastic->sliders > 0 && !elastic->slider))
        return SM_BAD_ARGUMENT;
    if (!sm_all_finite(elastic->reference, (size_t)contacts)) return SM_NOT_FINITE;
    for (int32_t k = 0; k < elastic->elements; k++) {
        const sm_element *element = &elastic->element[k];
        if (element->law != SM_SLIDERS && element->law != SM_FRICTIONAL) return SM_BAD_ARGUMENT;
        const sm_status status = element->law == SM_SLIDERS ? check_sliders(elastic, element)
                                                            : check_frictional(element);
        if (status != SM_OK) return status;
        if (!allowed_columns(element, contacts)) return SM_BAD_ARGUMENT;
    }
    return SM_OK;
}

sm_status sm_elastic_force(const sm_elastic *elastic, int32_t contacts, const double *x,
                           double *memory, double *force) {
    const sm_status status = sm_elastic_check(elastic, contacts);
    if (status != SM_OK) return status;
    if (!x || !memory || !force) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(x, (size_t)contacts) ||
        !sm_all_finite(memory, sm_elastic_memory(elastic)))
        return SM_NOT_FINITE;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        sm_element_force at;
        sm_element_evaluate(elastic, element, 1.0, x, memory, &at, memory);
        for (int k = 0; k < sm_element_columns(element); k++)
            force[element->column[k]] = at.force[k];
        memory += sm_element_memory(element);
    }
    return SM_OK;
}

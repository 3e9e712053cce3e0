/* Elastic contact laws: evaluation of any element, checks, and the public sm_elastic_force. */
#include "contact/elastic/law.h"

#include <string.h>

#include "base/check.h"

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

void sm_element_evaluate(const sm_elastic *elastic, const sm_element *element, double scale,
                         const double *x, const double *memory, sm_element_force *result) {
    if (element->law == SM_SLIDERS) {
        sm_sliders_evaluate(elastic, element, scale, x[element->column[0]], memory, result);
        return;
    }
    double own[SM_MOST_COLUMNS] = {0.0};
    for (int k = 0; k <= element->tangents; k++) own[k] = x[element->column[k]];
    sm_frictional_evaluate(element, scale, own, memory, result);
}

/* Returns whether a contact DOF is among the first columns of an element. */
static int has_column(const sm_element *element, int columns, int32_t column) {
    for (int k = 0; k < columns; k++)
        if (element->column[k] == column) return 1;
    return 0;
}

/* Returns whether the columns of element e are contact DOFs that occur only once up to it. */
static int allowed_columns(const sm_elastic *elastic, int32_t e, int32_t contacts) {
    const sm_element *element = &elastic->element[e];
    for (int k = 0; k < sm_element_columns(element); k++) {
        const int32_t column = element->column[k];
        if (column < 0 || column >= contacts || has_column(element, k, column)) return 0;
        for (int32_t b = 0; b < e; b++) {
            const sm_element *before = &elastic->element[b];
            if (has_column(before, sm_element_columns(before), column)) return 0;
        }
    }
    return 1;
}

/* Checks limits and stiffnesses of sliders. */
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

/* Checks the parameters of a frictional contact. */
static sm_status check_frictional(const sm_element *element) {
    const double values[] = {element->friction, element->preload, element->gap,
                             element->tangential_stiffness, element->normal_stiffness,
                             element->tangential_preload[0], element->tangential_preload[1]};
    if (element->tangents < 1 || element->tangents > 2) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(values, sizeof values / sizeof *values)) return SM_NOT_FINITE;
    return element->friction >= 0.0 && element->preload >= 0.0 && element->gap >= 0.0 &&
                   element->tangential_stiffness > 0.0 && element->normal_stiffness > 0.0
               ? SM_OK : SM_BAD_ARGUMENT;
}

sm_status sm_elastic_check(const sm_elastic *elastic, int32_t contacts) {
    if (!elastic || elastic->elements < 1 || elastic->elements > contacts || !elastic->element ||
        !elastic->reference || elastic->sliders < 0 || elastic->sliders > 100000 ||
        (elastic->sliders > 0 && !elastic->slider))
        return SM_BAD_ARGUMENT;
    if (!sm_all_finite(elastic->reference, (size_t)contacts)) return SM_NOT_FINITE;
    for (int32_t i = 0; i < contacts; i++)
        if (elastic->reference[i] < 0.0) return SM_BAD_ARGUMENT;
    int32_t columns = 0;
    for (int32_t k = 0; k < elastic->elements; k++) {
        const sm_element *element = &elastic->element[k];
        if (element->law != SM_SLIDERS && element->law != SM_FRICTIONAL) return SM_BAD_ARGUMENT;
        SM_TRY(element->law == SM_SLIDERS ? check_sliders(elastic, element)
                                          : check_frictional(element));
        if (!allowed_columns(elastic, k, contacts)) return SM_BAD_ARGUMENT;
        columns += sm_element_columns(element);
    }
    return columns == contacts ? SM_OK : SM_BAD_ARGUMENT;
}

sm_status sm_elastic_force(const sm_elastic *elastic, int32_t contacts, const double *x,
                           double *memory, double *force) {
    SM_TRY(sm_elastic_check(elastic, contacts));
    if (!x || !memory || !force) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(x, (size_t)contacts) ||
        !sm_all_finite(memory, sm_elastic_memory(elastic)))
        return SM_NOT_FINITE;
    double *own = memory;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        sm_element_force at = {.next = own};
        sm_element_evaluate(elastic, element, 1.0, x, own, &at);
        for (int k = 0; k < sm_element_columns(element); k++)
            force[element->column[k]] = at.force[k];
        own += sm_element_memory(element);
    }
    const size_t remembered = (size_t)(own - memory);
    const int finite = sm_all_finite(force, (size_t)contacts) && sm_all_finite(memory, remembered);
    return finite ? SM_OK : SM_NOT_FINITE;
}

#include "contact/elastic/law.h"

#include <string.h>

#include "base/check.h"

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

/* Coulomb's cone over an elastic surface that may open: |f_t| <= mu N, N >= 0. */
static void frictional(const sm_element *element, double scale, const double *x,
                       const double *memory, sm_element_force *result, double *next) {
    const int tangents = element->tangents, normal = tangents;
    const double preload = scale * element->preload, mu = element->friction;
    const double k_t = element->tangential_stiffness, k_n = element->normal_stiffness;
    const double N = preload + k_n * (x[normal] - element->gap);
    memset(result, 0, sizeof *result);
    if (N <= 0.0) { /* open: the sliders restart where the contact touches down */
        result->force[normal] = -preload;
        result->state = SM_OPEN;
        memcpy(next, x, (size_t)tangents * sizeof(double));
        return;
    }
    result->force[normal] = N - preload;
    result->tangent[normal][normal] = k_n;
    double trial[2] = {0.0, 0.0}, square = 0.0;
    for (int k = 0; k < tangents; k++) {
        trial[k] = k_t * (x[k] - memory[k]);
        square += trial[k] * trial[k];
    }
    const double size = sqrt(square), most = mu * N;
    result->state = size <= most ? SM_STICK : SM_SLIP;
    for (int k = 0; k < tangents; k++) {
        if (size <= most) {
            result->force[k] = trial[k];
            result->tangent[k][k] = k_t;
            next[k] = memory[k];
            continue;
        }
        const double along = trial[k] / size;
        result->force[k] = most * along;
        result->tangent[k][normal] = mu * k_n * along;
        for (int j = 0; j < tangents; j++)
            result->tangent[k][j] = k_t * most / size * ((j == k) - along * trial[j] / size);
        next[k] = x[k] - result->force[k] / k_t;
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
    frictional(element, scale, own, memory, result, next);
}

static int has_column(const sm_element *element, int columns, int32_t column) {
    for (int k = 0; k < columns; k++)
        if (element->column[k] == column) return 1;
    return 0;
}

/* Whether the columns of element e are contact DOFs that neither it nor one before it has. */
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
    for (int32_t i = 0; i < contacts; i++)
        if (elastic->reference[i] < 0.0) return SM_BAD_ARGUMENT;
    int32_t columns = 0;
    for (int32_t k = 0; k < elastic->elements; k++) {
        const sm_element *element = &elastic->element[k];
        if (element->law != SM_SLIDERS && element->law != SM_FRICTIONAL) return SM_BAD_ARGUMENT;
        const sm_status status = element->law == SM_SLIDERS ? check_sliders(elastic, element)
                                                            : check_frictional(element);
        if (status != SM_OK) return status;
        if (!allowed_columns(elastic, k, contacts)) return SM_BAD_ARGUMENT;
        columns += sm_element_columns(element);
    }
    return columns == contacts ? SM_OK : SM_BAD_ARGUMENT;
}

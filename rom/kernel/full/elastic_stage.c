#include "full/elastic_stage.h"

#include "base/block.h"
#include "base/lanes.h"

#define ROUNDING 1e-3 /* of displacements that the contacts remember: the solver resolves 1e-11 */

size_t sm_elastic_stage_size(const sm_elastic *elastic, int contacts, size_t width) {
    const size_t n = (size_t)contacts;
    return 2 * n * width + 3 * n + sm_elastic_memory(elastic)
           + sm_elastic_solver_size(elastic, contacts);
}

void sm_elastic_stage_place(sm_elastic_stage *s, const sm_elastic *elastic, int contacts,
                            size_t width, const double *flexibility, double *memory) {
    const size_t n = (size_t)contacts;
    *s = (sm_elastic_stage){
        .contacts = n, .width = width, .remembered = sm_elastic_memory(elastic)};
    s->directions = sm_take(&memory, n * width);
    s->gather = sm_take(&memory, n * width);
    s->u = sm_take(&memory, n);
    s->x = sm_take(&memory, n);
    s->v = sm_take(&memory, n);
    s->memory = sm_take(&memory, s->remembered);
    sm_elastic_solver_place(&s->solver, elastic, contacts, flexibility, memory);
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        if (element->law == SM_FRICTIONAL)
            s->static_closure =
                fmax(s->static_closure, element->preload / element->normal_stiffness);
    }
}

void sm_elastic_stage_set(sm_elastic_stage *s, const double *directions, size_t n) {
    const double *flexibility = s->solver.flexibility;
    const double *reference = s->solver.elastic->reference;
    for (size_t i = 0; i < s->contacts; i++) {
        memcpy(s->directions + i * s->width, directions + i * n, n * sizeof(double));
        for (size_t j = 0; j < s->contacts; j++) {
            const double part = (i == j) - flexibility[i * s->contacts + j] * reference[j];
            for (size_t k = 0; k < n; k++)
                s->gather[i * s->width + k] += part * directions[j * n + k];
        }
    }
}

/* The displacement below which the solver finds rounding. */
static double least(const sm_elastic_stage *s) {
    double largest = s->static_closure;
    for (size_t i = 0; i < s->contacts; i++) largest = fmax(largest, fabs(s->x[i]));
    for (size_t i = 0; i < s->remembered; i++) largest = fmax(largest, fabs(s->memory[i]));
    return ROUNDING * largest;
}

SM_HOT sm_status sm_elastic_stage_solve(sm_elastic_stage *s, double own, const double *base_q,
                                        const double *response, double *restrict v) {
    const size_t width = s->width;
    for (size_t i = 0; i < s->contacts; i++) {
        const double *restrict gather = s->gather + i * width;
        double part[SM_FULL_BLOCK] = {0.0};
        SM_EACH(k, width) part[k % SM_FULL_BLOCK] += gather[k] * (base_q[k] + own * v[k]);
        s->u[i] = (part[0] + part[1]) + (part[2] + part[3]);
    }
    s->solver.least = least(s);
    const sm_status status = sm_elastic_solve(&s->solver, s->u, s->memory, s->x);
    if (status != SM_OK) return status;
    for (size_t i = 0; i < s->contacts; i++) {
        const double force = s->solver.f[i];
        const double *restrict own_response = response + i * width;
        SM_EACH(k, width) v[k] -= own_response[k] * force;
    }
    for (size_t i = 0; i < s->contacts; i++) {
        const double *restrict direction = s->directions + i * width;
        double part[SM_FULL_BLOCK] = {0.0};
        SM_EACH(k, width) part[k % SM_FULL_BLOCK] += direction[k] * v[k];
        s->v[i] = (part[0] + part[1]) + (part[2] + part[3]);
    }
    return SM_OK;
}

void sm_elastic_stage_commit(sm_elastic_stage *s) {
    memcpy(s->memory, s->solver.next, s->remembered * sizeof(double));
}

/* Newton's step: what the contacts that do not stick do to all. */
#ifndef SLIPMODE_NEWTON_STEP_H
#define SLIPMODE_NEWTON_STEP_H

#include "base/lanes.h"
#include "contact/elastic/equations.h"
#include "contact/elastic/solve.h"

/* z at the active DOFs from ((1 + held) I - lack R) z = -lack residual: in `right`. 0 if that is
 * singular. */
SM_INLINE int sm_find_reaction(sm_elastic_solver *s, size_t m, double held) {
    const size_t n = (size_t)s->contacts;
    for (size_t a = 0; a < m; a++) {
        const size_t i = (size_t)s->active[a];
        const sm_element *element = &s->elastic->element[s->owner[i]];
        const double *lack = s->lack + i * SM_MOST_COLUMNS;
        double *row = s->matrix + a * m;
        s->right[a] = 0.0;
        for (size_t b = 0; b < m; b++) row[b] = 0.0;
        row[a] = 1.0 + held;
        for (int k = 0; k < sm_element_columns(element); k++) {
            const double *restrict from = s->flexibility + (size_t)element->column[k] * n;
            const double by = lack[k];
            if (by == 0.0) continue;
            s->right[a] -= by * s->residual[element->column[k]];
            for (size_t b = 0; b < m; b++) row[b] -= by * from[s->active[b]];
        }
    }
    return sm_eliminate(m, s->matrix, s->right);
}

/* The same of sliders, whose matrix divided by what they lack is symmetric; 0 if it is not positive
 * definite. */
SM_INLINE int sm_find_reaction_of_sliders(sm_elastic_solver *s, size_t m, double held) {
    const size_t n = (size_t)s->contacts;
    for (size_t a = 0; a < m; a++) {
        const size_t i = (size_t)s->active[a];
        const double *restrict from = s->flexibility + i * n;
        double *restrict row = s->matrix + a * m;
        s->right[a] = -s->residual[i];
        for (size_t b = a; b < m; b++) row[b] = -from[s->active[b]];
        row[a] += (1.0 + held) / s->lack[i * SM_MOST_COLUMNS];
    }
    return sm_eliminate_symmetric(m, s->matrix, s->right);
}

/* step = R z - residual with z (N_c) = lack step / (1 + held), nothing where contacts stick; from
 * ((1 + held) I - R lack) step = -(1 + held) residual, Newton's step where held = 0. */
SM_INLINE int sm_find_step(sm_elastic_solver *s, double held) {
    const size_t n = (size_t)s->contacts, m = (size_t)s->yielding;
    if (!(s->slides && sm_find_reaction_of_sliders(s, m, held)) && !sm_find_reaction(s, m, held))
        return 0;
    memset(s->z, 0, n * sizeof(double));
    for (size_t a = 0; a < m; a++) {
        s->z[s->active[a]] = s->right[a];
        s->right[a] = -s->right[a];
    }
    for (size_t i = 0; i < n; i++) s->step[i] = -s->residual[i];
    sm_subtract_columns(n, s->flexibility, s->active, m, s->right, s->step);
    memcpy(s->taken_before, s->taken, n * sizeof(double));
    memcpy(s->residual_before, s->residual, n * sizeof(double));
    return 1;
}

#endif

/* Newton's method: what the contacts do at displacements x, by how much x - R y = u fails there, and
 * the step from it.
 *
 * Of sliders only columns of R at which y changed are gone through from one x to the next: most
 * contacts stick, and where all that slip slip on as they did Newton's step leaves nothing. */
#ifndef SLIPMODE_ELASTIC_NEWTON_H
#define SLIPMODE_ELASTIC_NEWTON_H

#include "base/lanes.h"
#include "contact/elastic/equations.h"
#include "contact/elastic/solve.h"

/* fmax, but for NaN: a call costs more than the comparison. */
SM_INLINE double sm_larger(double a, double b) { return b > a ? b : a; }

/* The largest of `least` and of the sizes of n numbers. */
SM_INLINE double sm_largest(double least, const double *values, size_t n) {
    SM_SIMD_MAX(least)
    for (size_t i = 0; i < n; i++) least = sm_larger(least, fabs(values[i]));
    return least;
}

/* f, y, deficit and memory of an element; adds the contact DOFs that do not stick to the active ones. */
static int sm_evaluate_element(sm_elastic_solver *s, int32_t e, const double *memory,
                               const double *x, double *next, int active) {
    const sm_element *element = &s->elastic->element[e];
    const int columns = sm_element_columns(element);
    sm_element_force at = {.next = next};
    sm_element_evaluate(s->elastic, element, s->scale, x, memory, &at);
    s->state[e] = (int32_t)at.state;
    for (int k = 0; k < columns; k++) {
        const int32_t i = element->column[k];
        const double reference = s->elastic->reference[i];
        double *deficit = s->deficit + (size_t)i * SM_MOST_COLUMNS;
        int sticks = 1;
        s->f[i] = at.force[k];
        s->y[i] = reference * x[i] - at.force[k];
        for (int j = 0; j < columns; j++) {
            deficit[j] = (j == k ? reference : 0.0) - at.tangent[k][j];
            /* of the reference stiffness: a smaller deficit of the tangent is rounding */
            sticks &= fabs(deficit[j]) <= 1e-14 * reference;
        }
        if (!sticks) s->active[active++] = i;
    }
    return active;
}

/* The same of one slider at each contact DOF, side by side. */
SM_INLINE int sm_evaluate_jenkins(sm_elastic_solver *s, const double *restrict memory,
                                  const double *restrict x) {
    const int32_t n = s->contacts;
    const double *restrict limit = s->limit, *restrict stiffness = s->elastic->reference;
    double *restrict f = s->f, *restrict y = s->y, *restrict next = s->next;
    int32_t *restrict state = s->state;
    int active = 0;
    SM_SIMD
    for (int32_t i = 0; i < n; i++) {
        const double trial = stiffness[i] * (x[i] - memory[i]), most = s->scale * limit[i];
        const double sliding = copysign(most, trial), end = x[i] - sliding / stiffness[i];
        const int slips = fabs(trial) > most;
        f[i] = slips ? sliding : trial;
        next[i] = slips ? end : memory[i];
        y[i] = stiffness[i] * x[i] - f[i];
        state[i] = slips ? SM_SLIP : SM_STICK;
    }
    for (int32_t i = 0; i < n; i++) {
        s->active[active] = i;
        s->deficit[(size_t)i * SM_MOST_COLUMNS] = stiffness[i];
        active += state[i] == SM_SLIP;
    }
    return active;
}

/* f, y, next, state and deficit at x; returns the number of contact DOFs that do not stick. */
SM_INLINE int sm_evaluate(sm_elastic_solver *s, const double *memory, const double *x) {
    if (s->jenkins) return sm_evaluate_jenkins(s, memory, x);
    const sm_elastic *elastic = s->elastic;
    double *next = s->next;
    int active = 0;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        const int remembered = sm_element_memory(element);
        active = sm_evaluate_element(s, e, memory, x, next, active);
        memory += remembered;
        next += remembered;
    }
    return active;
}

/* Sets residual = x - R y - u; returns its largest entry. */
SM_INLINE double sm_find_residual(sm_elastic_solver *s, const double *u, const double *x) {
    const size_t n = (size_t)s->contacts;
    for (size_t i = 0; i < n; i++) {
        s->residual[i] = x[i] - u[i];
        s->changed[i] = (int32_t)i;
    }
    sm_subtract_columns(n, s->flexibility, s->changed, n, s->y, s->residual);
    return sm_largest(0.0, s->residual, n);
}

/* Updates the residual from x - R taken - u to x - R y - u; returns its largest entry. Differences of
 * y that are rounding against the tolerated residual are left out until they add up. */
SM_INLINE double sm_renew_residual(sm_elastic_solver *s, double tolerated) {
    size_t changed = 0;
    for (int32_t i = 0; i < s->contacts; i++) {
        const double by = s->y[i] - s->taken[i];
        if (fabs(by) <= 1e-3 * tolerated * s->elastic->reference[i]) continue;
        s->changed[changed] = i;
        s->by[changed++] = by;
        s->taken[i] = s->y[i];
    }
    const size_t n = (size_t)s->contacts;
    sm_subtract_columns(n, s->flexibility, s->changed, changed, s->by, s->residual);
    return sm_largest(0.0, s->residual, n);
}

/* z at the active DOFs from ((1 + held) I - deficit R) z = -deficit residual: in `right`. 0 if that is
 * singular. */
SM_INLINE int sm_find_reaction(sm_elastic_solver *s, size_t m, double held) {
    const size_t n = (size_t)s->contacts;
    for (size_t a = 0; a < m; a++) {
        const size_t i = (size_t)s->active[a];
        const sm_element *element = &s->elastic->element[s->owner[i]];
        const double *deficit = s->deficit + i * SM_MOST_COLUMNS;
        double *row = s->matrix + a * m;
        s->right[a] = 0.0;
        for (size_t b = 0; b < m; b++) row[b] = 0.0;
        row[a] = 1.0 + held;
        for (int k = 0; k < sm_element_columns(element); k++) {
            const double *restrict from = s->flexibility + (size_t)element->column[k] * n;
            const double by = deficit[k];
            if (by == 0.0) continue;
            s->right[a] -= by * s->residual[element->column[k]];
            for (size_t b = 0; b < m; b++) row[b] -= by * from[s->active[b]];
        }
    }
    return sm_eliminate(m, s->matrix, s->right);
}

/* The same for sliders: the matrix divided by their deficit is symmetric. Returns 0 if it is not
 * positive definite. */
SM_INLINE int sm_find_reaction_of_sliders(sm_elastic_solver *s, size_t m, double held) {
    const size_t n = (size_t)s->contacts;
    for (size_t a = 0; a < m; a++) {
        const size_t i = (size_t)s->active[a];
        const double *restrict from = s->flexibility + i * n;
        double *restrict row = s->matrix + a * m;
        s->right[a] = -s->residual[i];
        for (size_t b = a; b < m; b++) row[b] = -from[s->active[b]];
        row[a] += (1.0 + held) / s->deficit[i * SM_MOST_COLUMNS];
    }
    return sm_eliminate_symmetric(m, s->matrix, s->right);
}

/* step = R z - residual with z (N_c) = deficit step / (1 + held), nothing where contacts stick; from
 * ((1 + held) I - R deficit) step = -(1 + held) residual, Newton's step where held = 0. */
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

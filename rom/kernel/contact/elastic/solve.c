/* Semismooth Newton method for x - R y(x) = u with a line search.
 *
 * Iterates fulfil x = u + R y, with unbalanced forces w = y(x) - y. Newton's step is dy = w + q,
 * dx = R dy, with (I - D R) q = D R w, D = dy/dx: q is 0 where contacts stick. The step ends where
 * its work g = dx . (y - y(x)) vanishes; it is reversed if g > 0 at its start and the whole step fails.
 *
 * Sliders have a convex potential with the derivative g along the step: the solution is unique and
 * found from any guess. Friction under a varying normal force has no potential; if it is strong,
 * several solutions or none can exist. The solver returns the one reached from the guess, in time
 * steps the contact forces y of the previous step, or SM_NOT_CONVERGED. */
#include "contact/elastic/solve.h"

#include <stdlib.h>

#include "base/check.h"
#include "base/dense.h"
#include "base/lanes.h"

/* Residual of displacements, relative to the largest displacement. */
#define TOLERANCE 1e-11
/* Relative to the tolerated residual: an unbalanced force with less effect waits until it grows. */
#define NEGLECTED 1e-3
/* Work at the end of the line search, relative to its start. With 0.03 instead, some of 1e5 random
 * steps with friction coefficients up to 1 do not converge. */
#define REMAINING_WORK 0.01
#define LEAST_CUT 0.1 /* of the interval of the search: a kink near its lower end is approached */

/* Returns the larger number, or `a` if b is NaN; faster than fmax. */
SM_INLINE double larger(double a, double b) { return b > a ? b : a; }

/* Returns the largest of `least` and of the magnitudes of n numbers. */
SM_INLINE double largest(double least, const double *values, size_t n) {
    SM_SIMD_MAX(least)
    for (size_t i = 0; i < n; i++) least = larger(least, fabs(values[i]));
    return least;
}

void sm_elastic_solver_place(sm_elastic_solver *s, const sm_elastic *elastic, int contacts,
                             const double *flexibility, sm_block *block) {
    const size_t n = (size_t)contacts;
    *s = (sm_elastic_solver){.elastic = elastic, .contacts = contacts, .scale = 1.0,
                             .slides = 1, .flexibility = flexibility,
                             .remembered = sm_elastic_memory(elastic)};
    SM_TAKE_EACH(block, n, &s->f, &s->y, &s->own_y, &s->unbalanced, &s->residual, &s->step,
                 &s->step_y, &s->trial, &s->right);
    s->deficit = sm_take(block, SM_MOST_COLUMNS * n);
    s->matrix = sm_take(block, n * n);
    s->next = sm_take(block, s->remembered);
    s->active = (void *)sm_take(block, sm_doubles(n * sizeof(int32_t)));
    s->owner = (void *)sm_take(block, sm_doubles(n * sizeof(int32_t)));
    s->state = (void *)sm_take(block, sm_doubles((size_t)elastic->elements * sizeof(int32_t)));
    if (!block->memory) return;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        s->slides &= element->law == SM_SLIDERS;
        if (element->law == SM_FRICTIONAL) {
            s->closure = larger(s->closure, element->preload / element->normal_stiffness);
            const double pulled = largest(0.0, element->tangential_preload, 2);
            s->closure = larger(s->closure, pulled / element->tangential_stiffness);
            s->gap = larger(s->gap, element->gap);
        }
        for (int k = 0; k < sm_element_columns(element); k++) s->owner[element->column[k]] = e;
    }
}

/* Adds R values to `to` (N_c). */
SM_INLINE void add_product(const sm_elastic_solver *s, const double *values, double *to) {
    const size_t n = (size_t)s->contacts;
    for (size_t k = 0; k < n; k++) {
        const double *restrict column = s->flexibility + k * n;
        const double value = values[k];
        if (value == 0.0) continue;
        SM_SIMD
        for (size_t i = 0; i < n; i++) to[i] += column[i] * value;
    }
}

/* Sets x = u + R y. */
SM_INLINE void find_displacement(const sm_elastic_solver *s, const double *u, const double *y,
                                 double *x) {
    memcpy(x, u, (size_t)s->contacts * sizeof(double));
    add_product(s, y, x);
}

/* Evaluates element e; its DOFs that do not stick become active. */
SM_INLINE void evaluate_element(sm_elastic_solver *s, int32_t e, const double *memory,
                             const double *x, double *next) {
    const sm_element *element = &s->elastic->element[e];
    const int columns = sm_element_columns(element);
    sm_element_force at;
    at.next = next;
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
            sticks &= fabs(deficit[j]) <= SM_ROUNDING * reference;
        }
        if (!sticks) s->active[s->yielding++] = i;
    }
}

/* Sets f, y, next, state, the active DOFs and their deficit at displacements x. */
SM_INLINE void evaluate(sm_elastic_solver *s, const double *memory, const double *x) {
    s->yielding = 0;
    double *next = s->next;
    for (int32_t e = 0; e < s->elastic->elements; e++) {
        const int remembered = sm_element_memory(&s->elastic->element[e]);
        evaluate_element(s, e, memory, x, next);
        memory += remembered;
        next += remembered;
    }
}

/* Sets the unbalanced forces of iterate y and the residual; returns its largest entry. */
SM_INLINE double find_residual(sm_elastic_solver *s, const double *y, double tolerated) {
    const size_t n = (size_t)s->contacts;
    const double *reference = s->elastic->reference;
    for (size_t i = 0; i < n; i++) {
        const double unbalanced = s->y[i] - y[i];
        const int neglected = fabs(unbalanced) <= NEGLECTED * tolerated * reference[i];
        s->unbalanced[i] = neglected ? 0.0 : unbalanced;
        s->residual[i] = 0.0;
    }
    add_product(s, s->unbalanced, s->residual);
    return largest(0.0, s->residual, n);
}

/* Sets `right` to q at the active DOFs, from (I - D R) q = D residual. Where this is singular, q is
 * 0: the step goes along the unbalanced forces. */
SM_INLINE void find_reaction(sm_elastic_solver *s, size_t m) {
    const size_t n = (size_t)s->contacts;
    for (size_t a = 0; a < m; a++) {
        const size_t i = (size_t)s->active[a];
        const sm_element *element = &s->elastic->element[s->owner[i]];
        double *restrict row = s->matrix + a * m;
        s->right[a] = 0.0;
        for (size_t b = 0; b < m; b++) row[b] = a == b ? 1.0 : 0.0;
        for (int k = 0; k < sm_element_columns(element); k++) {
            const double deficit = s->deficit[i * SM_MOST_COLUMNS + (size_t)k];
            const double *restrict column = s->flexibility + (size_t)element->column[k] * n;
            if (deficit == 0.0) continue;
            s->right[a] += deficit * s->residual[element->column[k]];
            for (size_t b = 0; b < m; b++) row[b] -= deficit * column[s->active[b]];
        }
    }
    if (!sm_eliminate(m, s->matrix, s->right)) memset(s->right, 0, m * sizeof(double));
}

/* Returns the work of the step against the unbalanced forces, `part` of it after iterate y. */
SM_INLINE double work(const sm_elastic_solver *s, const double *y, double part) {
    double sum = 0.0;
    for (int i = 0; i < s->contacts; i++)
        sum += s->step[i] * (y[i] + part * s->step_y[i] - s->y[i]);
    return sum;
}

/* Sets Newton's step of x and y. */
SM_INLINE void find_step(sm_elastic_solver *s) {
    const size_t n = (size_t)s->contacts, m = (size_t)s->yielding;
    find_reaction(s, m);
    memcpy(s->step_y, s->unbalanced, n * sizeof(double));
    for (size_t a = 0; a < m; a++) s->step_y[s->active[a]] += s->right[a];
    memset(s->step, 0, n * sizeof(double));
    add_product(s, s->step_y, s->step);
}

/* Evaluates the contacts after a part of the step from x and y; returns the work there. */
SM_INLINE double try_part(sm_elastic_solver *s, const double *x, const double *y,
                          const double *memory, double part) {
    for (int i = 0; i < s->contacts; i++) s->trial[i] = x[i] + part * s->step[i];
    evaluate(s, memory, s->trial);
    return work(s, y, part);
}

/* Sets `trial` to the part of the step at which its work vanishes, by false position limited to the
 * lower half of the interval, and evaluates the contacts there; returns the part. */
SM_INLINE double search(sm_elastic_solver *s, const double *x, const double *y,
                        const double *memory) {
    double size = 0.0, low = 0.0, high = 1.0, part = 1.0, at_low = work(s, y, 0.0);
    for (int i = 0; i < s->contacts; i++) size += fabs(s->step[i] * y[i]);
    const double remaining = larger(REMAINING_WORK * fabs(at_low), SM_ROUNDING * size);
    double now = try_part(s, x, y, memory, part);
    if (at_low > 0.0 && fabs(now) > remaining) {
        for (int i = 0; i < s->contacts; i++) {
            s->step[i] = -s->step[i];
            s->step_y[i] = -s->step_y[i];
        }
        at_low = -at_low;
        now = try_part(s, x, y, memory, part);
    }
    for (int k = 0; k < SM_MAX_HALVINGS; k++) {
        if (fabs(now) <= remaining || (now < 0.0 && part == 1.0)) break;
        if (now > 0.0) {
            high = part;
            part = low + (high - low) * fmin(fmax(at_low / (at_low - now), LEAST_CUT), 0.5);
        } else {
            low = part;
            at_low = now;
            part = 0.5 * (low + high);
        }
        now = try_part(s, x, y, memory, part);
    }
    return part;
}

SM_HOT_ONE sm_status sm_elastic_follow(sm_elastic_solver *s, const double *u, const double *memory,
                                       double *x, double *y) {
    const size_t n = (size_t)s->contacts;
    /* contacts may return to 0 from the displacements that they remember */
    const double remembered = SM_LEAST_RESOLVED * largest(0.0, memory, s->remembered);
    const double given = largest(largest(larger(s->resolved, remembered), u, n), x, n);
    const double rounding = SM_ROUNDING * larger(s->scale * s->closure, s->gap);
    double longest = 0.0; /* of the steps */
    evaluate(s, memory, x);
    for (int iteration = 0; iteration < SM_MAX_ITERATIONS; iteration++) {
        const double tolerated = larger(TOLERANCE * largest(given, x, n), rounding);
        const double residual = find_residual(s, y, tolerated);
        if (!isfinite(residual)) return SM_NOT_FINITE;
        if (residual <= tolerated && SM_ROUNDING * longest <= tolerated) return SM_OK;
        if (residual <= tolerated) { /* x has lost digits in long steps */
            longest = 0.0;
            find_displacement(s, u, y, x);
            evaluate(s, memory, x);
            continue;
        }
        find_step(s);
        longest = largest(longest, s->step, n);
        const double part = search(s, x, y, memory);
        for (size_t i = 0; i < n; i++) y[i] += part * s->step_y[i];
        memcpy(x, s->trial, n * sizeof(double));
    }
    return SM_NOT_CONVERGED;
}

sm_status sm_elastic_solve(sm_elastic_solver *s, const double *u, const double *memory,
                           double *x) {
    evaluate(s, memory, x);
    memcpy(s->own_y, s->y, (size_t)s->contacts * sizeof(double));
    find_displacement(s, u, s->own_y, x);
    return sm_elastic_follow(s, u, memory, x, s->own_y);
}

sm_status sm_elastic_equilibrium(const sm_elastic *elastic, int32_t contacts,
                                 const double *flexibility, const double *displacement, double *x,
                                 double *force) {
    SM_TRY(sm_elastic_check(elastic, contacts));
    if (!flexibility || !displacement || !x || !force) return SM_BAD_ARGUMENT;
    const size_t n = (size_t)contacts;
    if (!sm_all_finite(flexibility, n * n) || !sm_all_finite(displacement, n))
        return SM_NOT_FINITE;
    sm_block block = {NULL, 0};
    sm_elastic_solver solver;
    sm_elastic_solver_place(&solver, elastic, contacts, flexibility, &block);
    sm_take(&block, sm_elastic_memory(elastic));
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    sm_elastic_solver_place(&solver, elastic, contacts, flexibility, &block);
    const double *at_rest = sm_take(&block, sm_elastic_memory(elastic));
    memcpy(x, displacement, n * sizeof(double)); /* as if all stuck */
    sm_status status = sm_elastic_solve(&solver, displacement, at_rest, x);
    if (status == SM_OK) {
        memcpy(force, solver.f, n * sizeof(double));
        if (!sm_all_finite(x, n) || !sm_all_finite(force, n)) status = SM_NOT_FINITE;
    }
    free(block.memory);
    return status;
}

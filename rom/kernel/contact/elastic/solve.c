#include "contact/elastic/solve.h"

#include <string.h>
#include <stdlib.h>

#include "base/block.h"
#include "base/check.h"
#include "contact/elastic/newton.h"

#define MOST_HELD 4.0
#define TOLERANCE 1e-11 /* of the displacements */

/* Normal displacements of further initial guesses, relative to all displacements. */
static const double START[] = {0.0, -1.0, 1.0, -1e3, 1e3};

void sm_elastic_solver_place(sm_elastic_solver *s, const sm_elastic *elastic, int contacts,
                             const double *flexibility, sm_block *block) {
    const size_t n = (size_t)contacts;
    *s = (sm_elastic_solver){.elastic = elastic, .contacts = contacts, .scale = 1.0,
                             .slides = 1, .jenkins = 1, .flexibility = flexibility};
    double **rows[] = {&s->f,     &s->y,  &s->step, &s->trial, &s->start,        &s->right,
                       &s->limit, &s->z,  &s->by,   &s->own,   &s->own_residual, &s->taken_before,
                       &s->residual_before};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) *rows[k] = sm_take(block, n);
    s->deficit = sm_take(block, SM_MOST_COLUMNS * n);
    s->matrix = sm_take(block, n * n);
    s->piece = sm_take(block, 2 * n);
    s->next = sm_take(block, sm_elastic_memory(elastic));
    int32_t **numbers[] = {&s->active, &s->changed, &s->owner};
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
        *numbers[k] = (void *)sm_take(block, sm_doubles(n * sizeof(int32_t)));
    s->state = (void *)sm_take(block, sm_doubles((size_t)elastic->elements * sizeof(int32_t)));
    if (!block->memory) return;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        const double *slider = elastic->slider + 2 * (size_t)element->first_slider;
        s->slides &= element->law == SM_SLIDERS;
        s->jenkins &= s->slides && element->sliders == 1 && element->column[0] == e
                      && slider[1] == elastic->reference[e];
        if (s->jenkins) s->limit[e] = slider[0];
        for (int k = 0; k < sm_element_columns(element); k++) s->owner[element->column[k]] = e;
    }
}

/* The displacements that the residual is small against, but for x itself: u, and where x came from,
 * as u may be zero where sliders hold x at another place, and both may be. */
SM_INLINE double given_scale(const sm_elastic_solver *s, const double *u) {
    const size_t n = (size_t)s->contacts;
    return sm_largest(sm_largest(s->least, u, n), s->start, n);
}

/* The residual at x below which it is solved. */
SM_INLINE double tolerated(const sm_elastic_solver *s, double given, const double *x) {
    return sm_larger(TOLERANCE * sm_largest(given, x, (size_t)s->contacts), s->rounding);
}

/* What rounding makes of preloads and gaps, as displacements. */
static double rounding_of(const sm_elastic *elastic, double scale) {
    double largest = 0.0;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        if (element->law != SM_FRICTIONAL) continue;
        const double preload = scale * element->preload / element->normal_stiffness;
        largest = sm_larger(largest, sm_larger(preload, element->gap));
    }
    return 1e-15 * largest;
}

/* What was found at displacements. */
typedef struct {
    double residual, allowed; /* largest entry; below `allowed` it is solved */
} found;

/* x as if there were no y; what there is comes next. */
SM_INLINE void begin(sm_elastic_solver *s, const double *u, const double *x) {
    for (int i = 0; i < s->contacts; i++) {
        s->taken[i] = 0.0;
        s->residual[i] = x[i] - u[i];
    }
}

/* Evaluates the contacts at x. The residual of sliders at the last x is updated. Contacts that open
 * are stiffer than the structure, and updates over large steps would lose digits. */
SM_INLINE found look(sm_elastic_solver *s, const double *u, double given, const double *memory,
                     const double *x) {
    s->yielding = sm_evaluate(s, memory, x);
    const double allowed = tolerated(s, given, x);
    return (found){s->slides ? sm_renew_residual(s, allowed) : sm_find_residual(s, u, x), allowed};
}

/* A part of the step from x: `to`, and of sliders the residual there with the y that it leads to. */
SM_INLINE void take_part(sm_elastic_solver *s, double part, const double *x, double *to) {
    for (int i = 0; i < s->contacts; i++) to[i] = x[i] + part * s->step[i];
    for (int i = 0; i < s->contacts && s->slides; i++) {
        s->taken[i] = s->taken_before[i] + part * s->z[i];
        s->residual[i] = (1.0 - part) * s->residual_before[i];
    }
}

/* x moved along the step until the residual falls. */
SM_INLINE found search(sm_elastic_solver *s, const double *u, double given,
                       const double *memory, double *x, double residual) {
    double part = 1.0;
    found at;
    for (int halving = 0; halving <= 6; halving++, part *= 0.5) {
        take_part(s, part, x, s->trial);
        at = look(s, u, given, memory, s->trial);
        if (at.residual <= (1.0 - 0.1 * part) * residual) break;
    }
    memcpy(x, s->trial, (size_t)s->contacts * sizeof(double));
    return at;
}

/* From x - R taken = u + residual. */
SM_HOT_ONE static sm_status newton(sm_elastic_solver *s, const double *u, const double *memory,
                                   double *x) {
    const double given = given_scale(s, u);
    found at = look(s, u, given, memory, x);
    for (int iteration = 0; iteration < 40; iteration++) {
        if (at.residual <= at.allowed) return SM_OK;
        if (!isfinite(at.residual)) return SM_NOT_FINITE;
        if (!sm_find_step(s, 0.0)) return SM_NOT_CONVERGED;
        at = search(s, u, given, memory, x, at.residual);
    }
    return at.residual <= at.allowed ? SM_OK : SM_NOT_CONVERGED;
}

/* Where Newton's steps go round in circles: u is brought up in ever smaller pieces. That arrives
 * wherever the solution is unique, as it is for sliders, and for friction that is not strong. */
static sm_status in_pieces(sm_elastic_solver *s, const double *u, const double *memory,
                           double *x) {
    const size_t n = (size_t)s->contacts;
    begin(s, u, s->start);
    look(s, u, given_scale(s, u), memory, s->start); /* the start solves for u + residual */
    double done = 0.0, piece = 0.5;
    double *part_u = s->piece, *start_u = part_u + n;
    for (size_t i = 0; i < n; i++) start_u[i] = u[i] + s->residual[i];
    memcpy(x, s->start, n * sizeof(double));
    for (int tries = 0; done < 1.0; tries++) {
        if (tries == 1000) return SM_NOT_CONVERGED;
        const double to = fmin(1.0, done + piece);
        for (size_t i = 0; i < n; i++) part_u[i] = start_u[i] + to * (u[i] - start_u[i]);
        begin(s, part_u, x);
        const sm_status status = newton(s, part_u, memory, x);
        if (status == SM_NOT_FINITE) return status;
        if (status == SM_OK) {
            done = to;
            piece *= 2.0;
            memcpy(s->start, x, n * sizeof(double));
        } else {
            piece *= 0.5;
            if (piece < 1.0 / 65536.0) return status;
            memcpy(x, s->start, n * sizeof(double));
        }
    }
    return SM_OK;
}

/* Strong friction may jam and let go at once: there the way ends, and x jumps. It creeps by
 * dx/dt = -residual, in implicit steps of 1 / held that grow as the residual falls. */
static sm_status creep(sm_elastic_solver *s, const double *u, const double *memory, double *x) {
    const double given = given_scale(s, u);
    begin(s, u, x);
    found at = look(s, u, given, memory, x);
    double held = MOST_HELD;
    for (int iteration = 0; iteration < 400; iteration++) {
        if (at.residual <= at.allowed) return SM_OK;
        if (!isfinite(at.residual)) return SM_NOT_FINITE;
        if (!sm_find_step(s, held)) return SM_NOT_CONVERGED;
        take_part(s, 1.0 / (1.0 + held), x, x);
        const double before = at.residual;
        at = look(s, u, given, memory, x);
        held = fmin(MOST_HELD, held * at.residual / before);
    }
    return SM_NOT_CONVERGED;
}

/* Another initial guess: x = u, as if all contacts stuck, but moved in their normal direction. */
static void displaced_guess(sm_elastic_solver *s, const double *u, double normal, double *x) {
    const sm_elastic *elastic = s->elastic;
    const double moved = normal * tolerated(s, given_scale(s, u), u) / TOLERANCE;
    memcpy(x, u, (size_t)s->contacts * sizeof(double));
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        if (element->law == SM_FRICTIONAL) x[element->column[element->tangents]] += moved;
    }
}

/* From wherever it takes: the residual is that of x on entry. */
static sm_status solve(sm_elastic_solver *s, const double *u, const double *memory, double *x) {
    memcpy(s->start, x, (size_t)s->contacts * sizeof(double));
    s->rounding = rounding_of(s->elastic, s->scale);
    sm_status status = newton(s, u, memory, x);
    if (status == SM_NOT_CONVERGED) status = in_pieces(s, u, memory, x);
    if (status == SM_NOT_CONVERGED) status = creep(s, u, memory, x);
    for (int start = 0; status == SM_NOT_CONVERGED && start < (int)(sizeof START / sizeof *START); start++) {
        displaced_guess(s, u, START[start], x);
        begin(s, u, x);
        status = newton(s, u, memory, x);
        if (status == SM_NOT_CONVERGED) status = creep(s, u, memory, x);
    }
    return status;
}

sm_status sm_elastic_solve(sm_elastic_solver *s, const double *u, const double *memory,
                           double *x) {
    s->taken = s->own;
    s->residual = s->own_residual;
    begin(s, u, x);
    return solve(s, u, memory, x);
}

sm_status sm_elastic_follow(sm_elastic_solver *s, const double *u, const double *memory, double *x,
                            double *taken, double *residual) {
    s->taken = taken;
    s->residual = residual;
    return solve(s, u, memory, x);
}

sm_status sm_elastic_equilibrium(const sm_elastic *elastic, int32_t contacts,
                                 const double *flexibility, const double *displacement, double *x,
                                 double *force) {
    const sm_status given = sm_elastic_check(elastic, contacts);
    if (given != SM_OK) return given;
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
    const sm_status status = sm_elastic_solve(&solver, displacement, at_rest, x);
    if (status == SM_OK) memcpy(force, solver.f, n * sizeof(double));
    free(block.memory);
    return status;
}

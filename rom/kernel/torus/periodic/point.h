/* The search for periodic motion at one point: residual, result and next iterate. Called by
 * search.c, which marches the points side by side. */
#ifndef SLIPMODE_POINT_H
#define SLIPMODE_POINT_H

#include "torus/periodic/fixed_point.h"
#include "torus/periodic/periodicity.h"

/* The search at one point. */
typedef struct {
    sm_fixed_point fixed_point;
    double *Y, *last_Y; /* (orders, N_c, 2) harmonics of the last two evaluations */
    double *square;     /* (N_c) mean square of the motion */
    double *change;     /* (orders N_c 2 + memory) next unknowns less the present ones */
    sm_scales scales;
    sm_progress progress; /* convergence from half period to half period */
    double residual;
    int done, open;     /* done: periodic. open: not periodic, and the residual decreases */
} sm_search_point;

/* The search at the points that are marched side by side. */
typedef struct {
    sm_march *march;
    sm_search_point *point; /* (march->points) */
    size_t harmonics, unknowns; /* doubles of a point */
    int follows;         /* 1: the response at the previous point is the initial guess */
    int32_t steps;       /* time steps along each line so far */
    double *memory;      /* block of all arrays */
} sm_search;

/* Returns the unknowns of a point: the response R, then the memory. */
static inline double *sm_search_unknowns(const sm_search *s, size_t p) {
    return s->march->response + p * s->unknowns;
}

/* Computes the residual of a point after an evaluation of whole periods: the change of the response
 * relative to the largest force (elastic contacts: displacement) of the modes, or the change of the
 * harmonics since the evaluation before, if it is larger. Where the memory is an unknown, a small
 * change of the memory suffices instead: harmonics repeat while stuck sliders creep, and change
 * where the search jumps. Returns the residual of the unknowns alone. */
double sm_search_residual(const sm_search *search, size_t p);
/* Copies harmonics, mean squares, residual and number of steps of a point into the results. */
void sm_search_store(const sm_search *search, size_t p);
/* Tests a point for periodicity after a half period, stores it, and sets its next response by a
 * relaxed iteration. Returns whether the iteration continues. */
int sm_search_next_half(const sm_search *search, size_t p);
/* Tests a point for periodicity after an evaluation, stores it, and sets its next unknowns by
 * Anderson's acceleration. Returns whether the iteration continues. The `first` evaluation after
 * the start sets no unknowns. Results at reduced amplitudes are not stored. */
int sm_search_next(const sm_search *search, size_t p, int first);

#endif

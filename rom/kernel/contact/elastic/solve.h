/* Displacements x of elastic contacts on a structure of flexibility R:
 *
 *   x - R y(x) = u,   y = k_ref x - f(x, memory).
 *
 * u is the displacement of contacts that stick, y the force deficit: the force by which the
 * contacts fall short of their reference springs. The time steps of torus/elastic, full and
 * slow/motion call the solver; sm_elastic_equilibrium calls it for a static force.
 */
#ifndef SLIPMODE_ELASTIC_SOLVE_H
#define SLIPMODE_ELASTIC_SOLVE_H

#include "base/block.h"
#include "contact/elastic/law.h"

/* Displacements below this part of the largest ones are not resolved [-]: of sticking contacts, or of
 * the displacements that the contacts remember. */
#define SM_LEAST_RESOLVED 1e-3

typedef struct {
    const sm_elastic *elastic;
    int contacts;
    const double *flexibility; /* (N_c, N_c) R */
    double scale;              /* of limits and preloads */
    double resolved;           /* displacement that the tolerance refers to at least [m] */
    int slides;                /* whether all elements are sliders */
    double closure, gap;       /* largest static stretch by a preload, largest gap [m] */
    size_t remembered;         /* doubles that the contacts remember */
    double *f, *y, *next;      /* (N_c), (N_c), (memory) at the solution */
    int32_t *state;            /* (elements) sm_contact_state at the solution */
    int yielding;              /* contact DOFs that do not stick at the solution */
    int32_t *active, *owner;   /* (N_c) these DOFs; the element of each contact DOF */
    /* work arrays */
    double *own_y;             /* (N_c) iterate of sm_elastic_solve */
    double *unbalanced;        /* (N_c) y(x) less the iterate y */
    double *residual;          /* (N_c) R unbalanced [m] */
    double *step, *step_y;     /* (N_c) of x and of y */
    double *trial;             /* (N_c) x on the line of the search */
    double *deficit;           /* (N_c, 3): d y / d x, rows of the elements' blocks */
    double *matrix, *right;    /* (N_c, N_c), (N_c) of the active DOFs */
} sm_elastic_solver;

/* Takes the arrays of a solver from a block, or counts them. */
void sm_elastic_solver_place(sm_elastic_solver *solver, const sm_elastic *elastic, int contacts,
                             const double *flexibility, sm_block *block);

/* Solves from displacements x (N_c), a guess. Leaves f, y, next and state in the solver. */
sm_status sm_elastic_solve(sm_elastic_solver *solver, const double *u, const double *memory,
                           double *x);

/* Solves from x = u + R y for some y (N_c): the iterate, which is returned with x. A step in which
 * no slider moves costs no product with R. */
sm_status sm_elastic_follow(sm_elastic_solver *solver, const double *u, const double *memory,
                            double *x, double *y);

#endif

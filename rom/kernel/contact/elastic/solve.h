/* Displacements x of elastic contacts on a structure of flexibility R:
 *
 *   x - R y(x) = u,   y = k_ref x - f(x, memory)
 *
 * u is where the structure would take contacts that stick, y what the contacts fall short of
 * their reference springs by. Newton's matrix differs from the identity only where a contact slips
 * or is open, so a step in which everything sticks costs no solution.
 */
#ifndef SLIPMODE_ELASTIC_SOLVE_H
#define SLIPMODE_ELASTIC_SOLVE_H

#include "contact/elastic/law.h"

typedef struct {
    const sm_elastic *elastic;
    int contacts;
    const double *flexibility; /* (N_c, N_c) R */
    double scale;              /* of limits and preloads */
    double least;              /* displacement that is small [m] */
    /* work space */
    double rounding;           /* residual that is rounding [m] */
    double *f, *y, *next;      /* (N_c), (N_c), (memory) at the solution */
    int32_t *state;            /* (elements) sm_contact_state there */
    double *residual, *step, *trial, *start; /* (N_c) */
    double *piece;             /* (2, N_c) u on the way, and where the way begins */
    double *lack;              /* (N_c, 3): d y / d x, rows of the elements' blocks */
    double *matrix, *right;    /* (N_c, N_c), (N_c) of the contacts that do not stick */
    int32_t *active, *owner;   /* (N_c) these; element of each contact DOF */
} sm_elastic_solver;

/* Doubles of the work space. */
size_t sm_elastic_solver_size(const sm_elastic *elastic, int contacts);
void sm_elastic_solver_place(sm_elastic_solver *solver, const sm_elastic *elastic, int contacts,
                             const double *flexibility, double *memory);

/* x on entry: a guess. Leaves f, y, next and state of the solution in the solver. */
sm_status sm_elastic_solve(sm_elastic_solver *solver, const double *u, const double *memory,
                           double *x);

#endif

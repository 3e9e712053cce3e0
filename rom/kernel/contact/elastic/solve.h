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

#include "base/block.h"
#include "contact/elastic/law.h"

typedef struct {
    const sm_elastic *elastic;
    int contacts;
    const double *flexibility; /* (N_c, N_c) R */
    double scale;              /* of limits and preloads */
    double least;              /* displacement that is small [m] */
    int slides, jenkins;       /* all elements are sliders; one, at each contact DOF in turn, */
    double *limit;             /* (N_c) of such a limit, before its scale */
    double *taken, *residual;  /* (N_c) y, and x - R y - u with it; where R y counts only changes */
    /* work space */
    double rounding;           /* residual that is rounding [m] */
    double *f, *y, *next;      /* (N_c), (N_c), (memory) at the solution */
    int32_t *state;            /* (elements) sm_contact_state there */
    int yielding;              /* contact DOFs that do not stick there */
    double *own, *own_residual, *taken_before, *residual_before; /* (N_c) */
    double *step, *z, *trial, *start; /* (N_c) */
    double *piece;             /* (2, N_c) u on the way, and where the way begins */
    double *deficit;           /* (N_c, 3): d y / d x, rows of the elements' blocks */
    double *matrix, *right;    /* (N_c, N_c), (N_c) of the contacts that do not stick */
    double *by;                /* (N_c) what y changed by */
    int32_t *active, *changed; /* (N_c) contact DOFs that do not stick; at which y changed */
    int32_t *owner;            /* (N_c) element of each contact DOF */
} sm_elastic_solver;

void sm_elastic_solver_place(sm_elastic_solver *solver, const sm_elastic *elastic, int contacts,
                             const double *flexibility, sm_block *block);

/* x on entry: a guess. Leaves f, y, next and state of the solution in the solver. */
sm_status sm_elastic_solve(sm_elastic_solver *solver, const double *u, const double *memory,
                           double *x);

/* The same where x - R taken = u + residual on entry, for some y taken (N_c), as it is if both are
 * what the solution before was left with and x went along with u. The rounding of all solutions
 * before stays: `least` has to be large against it. */
sm_status sm_elastic_follow(sm_elastic_solver *solver, const double *u, const double *memory,
                            double *x, double *taken, double *residual);

#endif

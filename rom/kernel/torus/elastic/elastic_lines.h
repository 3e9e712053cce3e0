/* Elastic contacts along the phase lines of one point.
 *
 * Modes are integrated with them (marched.h); the other modes act through the harmonics of their
 * response. Where sliders turn back or begin to slide between two steps is corrected, see
 * reversal.h.
 */
#ifndef SLIPMODE_ELASTIC_LINES_H
#define SLIPMODE_ELASTIC_LINES_H

#include "contact/elastic/solve.h"
#include "torus/elastic/marched.h"
#include "torus/elastic/phase_lines.h"
#include "torus/march.h"

#define SM_HISTORIES 7

typedef struct {
    const sm_contact *contact;
    sm_phase_lines lines;    /* displacements u without the force deficit, and the deficit y */
    sm_elastic_solver solver;
    sm_marched marched;
    double *flexibility;     /* (N_c, N_c) R */
    double *yields;          /* (N_c) R_ii if all elements are sliders, else 0: see sm_reversal */
    double *history;         /* (SM_HISTORIES, lines, N_c): */
    double *x, *u, *y, *residual; /* of the last step; y and residual as the solver left them */
    double *stuck_x[2];      /* x - yields y, one and two steps before */
    double *correction;      /* of y at the last step, see reversal.h */
    int32_t *slipped;        /* (lines) whether any contact slipped or was open at the last step */
    size_t memory_size;      /* doubles that the contacts of a line remember */
    double *memory, *memory_at_start; /* (lines, memory_size) now, and as the period began */
    double *x_before, *own_u, *own_stuck_x, *own_y, *own_correction; /* (N_c) of a line in a step */
    double *square;          /* (N_c) sum of y^2 */
    double *Y;               /* (orders, N_c, 2) harmonics of y */
    double *response;        /* (orders N_c 2 + memory) see sm_march */
    int half;                /* half periods are marched: the next one has the opposite sign */
    size_t shift;            /* line p ends a period where p + shift began it; 0: nowhere */
    size_t turned;           /* line p began the period where p + turned began the march */
    double *block;
} sm_elastic_lines;

/* Contacts at rest; displacements up to this size are to be resolved [m]. */
void sm_elastic_lines_start(sm_elastic_lines *e, double displacement);
/* The displacements along the lines: of modes with these amplitudes, and of the response R or
 * NULL. */
void sm_elastic_lines_displace(sm_elastic_lines *e, const double *amplitude, const double *R);
/* Steps `first` to `first + count`, SM_TOGETHER at most; adds y times `weight` to the sums of
 * harmonics. */
sm_status sm_elastic_lines_step(sm_elastic_lines *e, size_t first, size_t count, double weight);

/* At the end of a period of closed phase lines: a slider that has not moved on a line continues
 * from the last line before on which it has, or else, as it could rest anywhere, from the mean of
 * all lines, which is 0 of odd motion. */
void sm_carry_sliders_over(sm_elastic_lines *e);
/* One slider at each contact, of its reference stiffness: where it is at t = 0 for harmonics Y of
 * the force deficit, y = k s. */
void sm_place_sliders(sm_elastic_lines *e, const double *Y);

#endif

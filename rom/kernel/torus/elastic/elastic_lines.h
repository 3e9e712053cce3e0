/* Elastic contacts along the phase lines of one point: x - R y(x) = u at each step and line.
 *
 * u is the displacement by the resonant modes, by the response to the harmonics of y and by the
 * integrated modes (marched.h). reversal.h corrects sliders that turn back or begin to slide
 * between two steps. elastic_lines.c implements sm_torus_law with them; torus/growth.c calls the
 * functions below. */
#ifndef SLIPMODE_ELASTIC_LINES_H
#define SLIPMODE_ELASTIC_LINES_H

#include "contact/elastic/solve.h"
#include "torus/elastic/marched.h"
#include "torus/elastic/phase_lines.h"
#include "torus/march.h"

#define SM_HISTORIES 6 /* arrays of the last step, one after the other */

typedef struct {
    const sm_contact *contact;
    sm_phase_lines lines;    /* displacements u without the force deficit, and the deficit y */
    sm_elastic_solver solver;
    sm_marched marched;
    double *flexibility;     /* (N_c, N_c) R */
    double *compliance;      /* (N_c) R_ii if all elements are sliders, else 0: see sm_reversal */
    double *history;         /* (SM_HISTORIES, lines, N_c), of the last step: */
    double *x, *u, *y;       /* x = u + R y; y as the solver left it */
    double *stuck_x[2];      /* x - compliance y, one and two steps before */
    double *correction;      /* of y, see reversal.h */
    int32_t *slipped;        /* (lines) whether a contact slipped or was open at the last step */
    size_t memory_size;      /* doubles that the contacts of a line remember */
    double *memory, *memory_at_start; /* (lines, memory_size) now, and at the start of the period */
    double *bounds;          /* (elements, 2) low, - high, of sliders that stick for the whole period */
    double *last_bounds;     /* (lines, elements, 2, 2) at the last two steps */
    double *x_before, *own_u, *own_stuck_x, *own_y, *own_correction; /* (N_c) of a line in a step */
    double *square;          /* (N_c) sum of y^2 */
    double *Y;               /* (orders, N_c, 2) harmonics of y */
    double *response;        /* (orders N_c 2 + memory) see sm_march */
    int half;                /* half periods are integrated; the next one has the opposite sign */
    size_t shift;            /* line p ends a period at the start of line p + shift; 0: at none */
    size_t turned;           /* line p starts its period where line p + turned first started */
    double *block;
} sm_elastic_lines;

/* Sets contacts and integrated modes at rest; `displacement` is the size that the solver resolves
 * [m]. */
void sm_elastic_lines_start(sm_elastic_lines *e, double displacement);
/* Sets the displacements along the lines: by modes with these amplitudes, and by the response R or
 * NULL. */
void sm_elastic_lines_displace(sm_elastic_lines *e, const double *amplitude, const double *R);
/* Makes steps `first` to `first + count`, SM_TOGETHER at most; adds y times `weight` to the sums of
 * harmonics. */
sm_status sm_elastic_lines_step(sm_elastic_lines *e, size_t first, size_t count, double weight);

/* Returns whether sm_place_stuck_sliders applies to an element. In two directions the memory is
 * unknown, and the search finds it. */
static inline int sm_placed(const sm_element *element) {
    return element->law == SM_FRICTIONAL && element->tangents == 1;
}

/* Updates the bounds between which a slider sticks for the whole period, for displacements x (N_c)
 * of line p. */
void sm_bound_sliders(sm_elastic_lines *e, size_t p, const double *x);
/* Ends a period. The position of a slider that can stick is not unique: it depends on the history
 * of the motion. Sliders of contacts with a varying normal force move from rest only as far as they
 * must, as under vibration that grows slowly. */
void sm_place_stuck_sliders(sm_elastic_lines *e);
/* Ends a period of closed phase lines. A slider that has not moved on a line continues from the
 * last earlier line on which it has. If it moved on none, its position is arbitrary: it continues
 * from the mean of all lines, which is 0 for odd motion. */
void sm_carry_sliders_over(sm_elastic_lines *e);
/* Sets sliders s at t = 0 from harmonics Y of the force deficit y = k s, at the contacts that have
 * one slider alone. */
void sm_place_sliders(sm_elastic_lines *e, const double *Y);

#endif

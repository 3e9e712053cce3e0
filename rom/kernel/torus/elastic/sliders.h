/* What sliders remember at the end of a period of closed phase lines; and to begin with. */
#ifndef SLIPMODE_SLIDERS_H
#define SLIPMODE_SLIDERS_H

#include "contact/elastic/law.h"
#include "torus/elastic/phase_lines.h"

typedef struct {
    size_t lines, remembered; /* doubles that each line remembers */
    size_t shift;             /* line p ends where line p + shift began */
    int half;                 /* after half a period of odd motion: with another sign */
    const double *at_start;      /* (lines, remembered) memory as the period began */
} sm_period;

/* memory (lines, remembered): a slider that has not moved on a line brings that on at once from the
 * last line before on which it has, or else, as it could rest anywhere, from the mean of them all,
 * which is 0 of odd motion. */
void sm_carry_sliders_over(const sm_elastic *elastic, const sm_period *period, double *memory);

/* memory (lines, N_c): one slider at each contact, of its reference stiffness, where it is at t = 0
 * for harmonics Y (orders, N_c, 2), y = k s. */
void sm_place_sliders(const sm_phase_lines *lines, const double *reference, const double *Y,
                      double *memory);

#endif

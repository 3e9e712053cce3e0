/* Checks of the arguments that sm_torus_harmonics and sm_torus_growing share. */
#ifndef SLIPMODE_TORUS_H
#define SLIPMODE_TORUS_H

#include "slipmode.h"

/* The contacts and how finely they are resolved. */
sm_status sm_torus_check(const sm_contact *contact, const sm_discretisation *grid);

/* Finite amplitudes or growths (points, modes), and that the results at so many points fit. */
sm_status sm_torus_check_points(const sm_contact *contact, size_t points, const double *values,
                                int32_t orders_count);

#endif

/* Checks that both entries on the torus make. */
#ifndef SLIPMODE_TORUS_CHECK_H
#define SLIPMODE_TORUS_CHECK_H

#include "slipmode.h"

/* The contacts and how finely they are resolved. */
sm_status sm_torus_check(const sm_contact *contact, const sm_discretisation *grid);

/* Finite amplitudes or growths (points, modes), and that the results at so many points fit. */
sm_status sm_torus_check_points(const sm_contact *contact, size_t points, const double *values,
                                int32_t orders_count);

#endif

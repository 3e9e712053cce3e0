/* Friction tables: values of S_j = Q_j |a_j|, eq. (20), and their slopes at given amplitudes. The
 * slow flow (slow/friction_model.c) evaluates them in each stage of a step; the response surface of
 * the modes (slow/component/response_surface.c) has the same cells. */
#ifndef SLIPMODE_TABLE_H
#define SLIPMODE_TABLE_H

#include "base/block.h"
#include "slipmode.h"

/* Checks that the table has valid sizes and arrays, so that an evaluation stays inside them. */
sm_status sm_table_check_shape(const sm_table *table);

/* Evaluates all columns, and d/da and d/db of the first `sloped` columns, an even number:
 * slopes (3, columns). Neither the shape of the table nor the result is checked. The search for
 * the cell begins at `cell` (SM_MODES), which is set to the cell found; the result does not depend
 * on it. `rate_correction` (SM_RATE_CORRECTIONS) may be NULL; it is set if the table has one. */
sm_status sm_table_slopes_from(const sm_table *table, const double *amplitudes, size_t sloped,
                               int32_t *cell, double *slopes, double *rate_correction);

/* Evaluates dS_j / dOmega_k of a table that has it, in the cell that contains the amplitudes, and
 * its derivatives by the amplitudes if `sloped`: slopes (3, 2 modes modes). */
void sm_table_detuning(const sm_table *table, const double *amplitudes, int sloped,
                       const int32_t *cell, double *slopes);

/* Returns the cell of x in [node[0], node[count - 1]] by bisection, unless x is in cell `guess`. */
int32_t sm_find_cell(const double *node, int32_t count, double x, int32_t guess);

#endif

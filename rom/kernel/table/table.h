#ifndef SLIPMODE_TABLE_H
#define SLIPMODE_TABLE_H

#include "base/block.h"
#include "slipmode.h"

/* What keeps a look-up inside the arrays. */
sm_status sm_table_check_shape(const sm_table *table);

/* Finds the columns, and d/da and d/db of the first `sloped` of them, an even number: (3, columns).
 * Neither the table's shape nor the result is checked. `cell` (SM_MODES) says where to look first and
 * is set to the cell found; the result does not depend on it. `rate_correction`
 * (SM_RATE_CORRECTIONS) may be NULL, and is not set by a table without one. */
sm_status sm_table_slopes_from(const sm_table *table, const double *amplitudes, size_t sloped,
                               int32_t *cell, double *slopes, double *rate_correction);

/* dS_j / dOmega_k of a table that has it, in the cell where its amplitudes were found; and where
 * `sloped`, its slopes too: (3, 2 modes modes). */
void sm_table_detuning(const sm_table *table, const double *amplitudes, int sloped,
                       const int32_t *cell, double *slopes);

/* The cell that holds x in [node[0], node[count - 1]], tried first where `guess` says. */
int32_t sm_find_cell(const double *node, int32_t count, double x, int32_t guess);

#endif

/* Solution of dense linear equations A x = b by Gaussian elimination with partial pivoting.
 *
 * Newton's method for elastic contacts (solve.c) and for response curves (slow/branches/curve.c)
 * call it with up to some hundred unknowns. */
#ifndef SLIPMODE_EQUATIONS_H
#define SLIPMODE_EQUATIONS_H

#include <stddef.h>

/* Replaces `right` (n) by A^-1 right and overwrites A (n, n). Returns 0 if A is singular. */
int sm_eliminate(size_t n, double *A, double *right);

#endif

/* Dense equations A x = b with up to some hundred unknowns: Gaussian elimination with partial
 * pivoting, and Cholesky's factorisation of symmetric matrices.
 *
 * Newton's method for elastic contacts (contact/elastic/solve.c) and for solution curves
 * (slow/branches/curve.c) eliminate; the check of rigid contacts (contact/stepper.c) and the least
 * squares of Anderson's acceleration (torus/periodic/fixed_point.c) factorise. Matrices of contacts
 * side by side have a factorisation in lanes, contact/stage/factor.h. */
#ifndef SLIPMODE_DENSE_H
#define SLIPMODE_DENSE_H

#include <stddef.h>

/* Returns the inner product of two vectors of n numbers. */
double sm_dot(size_t n, const double *a, const double *b);

/* Replaces `right` (n) by A^-1 right and overwrites A (n, n). Returns 0 if A is singular. */
int sm_eliminate(size_t n, double *A, double *right);

/* Replaces the lower triangle of a symmetric matrix A (n, n) by its Cholesky factor L. A column
 * whose pivot is at most `least` times its diagonal depends on the columns before: its diagonal of
 * L is 0. Returns the number of other columns; it is n if A is positive definite. */
size_t sm_cholesky(size_t n, double least, double *A);

/* Replaces `right` (n) by the solution of L L^T x = right, with x = 0 for dependent columns. */
void sm_cholesky_solve(size_t n, const double *L, double *right);

#endif

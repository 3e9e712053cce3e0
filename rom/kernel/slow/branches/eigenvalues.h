/* Eigenvalues of small real matrices. */
#ifndef SLIPMODE_EIGENVALUES_H
#define SLIPMODE_EIGENVALUES_H

#define SM_EIGENVALUES 4 /* at most */

/* Of a finite matrix (n, n), as (Re, Im), the largest real part first, pairs together; NaN for any
 * that is not found. */
void sm_eigenvalues(int n, const double *matrix, double *values);

#endif

/* Coulomb's cone over an elastic surface that may open: N = N0 + k_n (x_n - gap) >= 0, |f_t| <= mu N.
 *
 * Return map along the straight line from where the contact was to where it is, with N linear on
 * it, exact on that line: second order in its length. The contact remembers its sliders, then all
 * its displacements.
 *
 * - An open contact has its sliders where it is; on the way in they stop at touch-down.
 * - In one tangential direction sliders are at x - mu N / k_t wherever they slide.
 * - In two, the elastic stretch e = x - s grows with x until |e| = rho = mu N / k_t. From there on
 *   s follows e's direction d, a tractrix: with the straight path q in units of rho and
 *   kappa = |q|, d becomes d + q (sinh(kappa) / kappa + (q . d) (cosh(kappa) - 1) / kappa^2), of
 *   unit length.
 */
#ifndef SLIPMODE_FRICTIONAL_H
#define SLIPMODE_FRICTIONAL_H

#include "contact/elastic/law.h"

/* x: of the element's columns; `next` may be `memory`. */
void sm_frictional_evaluate(const sm_element *element, double scale, const double *x,
                            const double *memory, sm_element_force *result, double *next);

#endif

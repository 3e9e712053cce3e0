/* Coulomb friction on an elastic surface that may open:
 * N = N0 + k_n (x_n - gap) >= 0, |f_t| <= mu N, f_t = T0 + k_t (x_t - s).
 *
 * The return map is exact for a straight path from the previous displacements to x, with N linear
 * along it: second order in its length. The memory holds the sliders s, then the displacements.
 *
 * - The sliders of an open contact follow it; when it closes they stop at touch-down.
 * - In one tangential direction a sliding slider is at x - mu N / k_t.
 * - In two directions the elastic stretch e = x - s grows with x until |e| = rho = mu N / k_t. From
 *   there on s moves in the direction d of e, a tractrix: with the straight path q in units of rho
 *   and kappa = |q|, d becomes d + q (sinh(kappa) / kappa + (q . d) (cosh(kappa) - 1) / kappa^2),
 *   normalised.
 */
#include "contact/elastic/law.h"

#include <string.h>

#include "base/check.h"
#include "contact/elastic/dual.h"

/* Path in units of rho, beyond which e points along the path to rounding: exp(-30) = 1e-13. */
#define LONGEST_PATH 30.0
/* Square of k below which sinh(k) / k is summed as a series: to 1e-16 with four terms. */
#define SERIES_END 1e-2

/* A step of one contact that is closed at its end. */
typedef struct {
    int tangents;
    double rho[2];      /* mu N / k_t at the start and at the end of the path */
    double rho_slope;   /* d rho[1] / d x_n */
    double stretch[2];  /* e at the start of the path, within rho */
    int unmoved;        /* the sliders start the path at their positions in the memory */
    sm_dual path[2];    /* displacement, of an open contact from touch-down on */
    sm_dual trial[2];   /* e at the end of the path if the contact sticks */
} path;

/* Returns sinh(k) / k from k^2. */
static sm_dual sinh_ratio(sm_dual square) {
    const double m = square.value, k = sqrt(m);
    if (m >= SERIES_END)
        return sm_dual_of(sinh(k) / k, 0.5 * (cosh(k) - sinh(k) / k) / m, square, 0.0, square);
    return sm_dual_of(1.0 + m / 6.0 * (1.0 + m / 20.0 * (1.0 + m / 42.0 * (1.0 + m / 72.0))),
                      (1.0 + m / 10.0 * (1.0 + m / 28.0 * (1.0 + m / 54.0))) / 6.0, square, 0.0,
                      square);
}

/* Returns the part of the path after which |e| reaches rho; the contact slides at its end. */
static sm_dual onset(const path *p, const sm_dual stretch[2], sm_dual grown) {
    const sm_dual a = sm_dual_sub(sm_dual_dot(p->path, p->path), sm_dual_mul(grown, grown));
    const sm_dual along = sm_dual_dot(stretch, p->path);
    const sm_dual b = sm_dual_scale(2.0, sm_dual_sub(along, sm_dual_scale(p->rho[0], grown)));
    double inside = -p->rho[0] * p->rho[0];
    for (int k = 0; k < 2; k++) inside += p->stretch[k] * p->stretch[k];
    const sm_dual c = sm_dual_constant(fmin(inside, 0.0));
    const sm_dual square = sm_dual_sub(sm_dual_mul(b, b), sm_dual_scale(4.0, sm_dual_mul(a, c)));
    const sm_dual root = sm_dual_root(square);
    if (b.value > 0.0)
        return sm_dual_div(sm_dual_scale(-2.0, c), sm_dual_add(b, root));
    if (!(a.value > 0.0)) return sm_dual_constant(0.0); /* no path: slip by rounding */
    return sm_dual_div(sm_dual_sub(root, b), sm_dual_scale(2.0, a));
}

/* Scales a vector to unit length. */
static void normalise(sm_dual d[2]) {
    const sm_dual size = sm_dual_root(sm_dual_dot(d, d));
    for (int k = 0; k < 2; k++) d[k] = sm_dual_div(d[k], size);
}

/* Sets d to the direction of e at the end of a path with slip in two directions. */
static void slide(const path *p, sm_dual rho, sm_dual d[2]) {
    if (p->rho[0] == 0.0) { /* e starts from 0 */
        memcpy(d, p->path, sizeof p->path);
        normalise(d);
        return;
    }
    const sm_dual begin = sm_dual_constant(p->rho[0]), grown = sm_dual_sub(rho, begin);
    const sm_dual stretch[2] = {sm_dual_constant(p->stretch[0]), sm_dual_constant(p->stretch[1])};
    const sm_dual part = onset(p, stretch, grown);
    const sm_dual rest = sm_dual_sub(sm_dual_constant(1.0), part);
    const sm_dual both = sm_dual_add(sm_dual_add(begin, sm_dual_mul(part, grown)), rho);
    sm_dual q[2];
    for (int k = 0; k < 2; k++) {
        d[k] = sm_dual_add(stretch[k], sm_dual_mul(part, p->path[k]));
        q[k] = sm_dual_div(sm_dual_scale(2.0, sm_dual_mul(rest, p->path[k])), both);
    }
    normalise(d);
    const double length = sqrt(sm_dual_dot(q, q).value);
    for (int k = 0; k < 2 && length > LONGEST_PATH; k++)
        q[k] = sm_dual_scale(LONGEST_PATH / length, q[k]);
    const sm_dual square = sm_dual_dot(q, q), half = sinh_ratio(sm_dual_scale(0.25, square));
    /* (cosh(k) - 1) / k^2 = 2 sinh(k / 2)^2 / k^2 */
    const sm_dual cosh_part = sm_dual_scale(0.5, sm_dual_mul(half, half));
    const sm_dual turn =
        sm_dual_add(sinh_ratio(square), sm_dual_mul(sm_dual_dot(q, d), cosh_part));
    for (int k = 0; k < 2; k++) d[k] = sm_dual_add(d[k], sm_dual_mul(turn, q[k]));
    normalise(d);
}

/* Moves sliders straight to the limit if their stretch exceeds rho: after a change of the load, or
 * if they were carried over from another phase line. Otherwise the force would jump when the path
 * enters the disk of radius rho, and some steps would have no solution. */
static void slide_within(path *p) {
    const double rho = (1.0 + SM_ROUNDING_TOLERANCE) * p->rho[0];
    const double square = p->stretch[0] * p->stretch[0] + p->stretch[1] * p->stretch[1];
    if (square <= rho * rho) return;
    const double part = p->rho[0] / sqrt(square);
    for (int k = 0; k < 2; k++) {
        p->stretch[k] *= part;
        p->trial[k].value = p->stretch[k] + p->path[k].value;
    }
    p->unmoved = 0;
}

/* Returns the path of a contact that is closed at its end, from normal force N_old to N. `at_rest`
 * is e at rest. */
static path path_of(const sm_element *element, const double *at_rest, const double *x,
                    const double *memory, double N, double N_old) {
    const double *x_old = memory + element->tangents;
    const double per_load = element->friction / element->tangential_stiffness;
    path p = {.tangents = element->tangents,
              .unmoved = N_old >= 0.0,
              .rho = {per_load * fmax(N_old, 0.0), per_load * N},
              .rho_slope = per_load * element->normal_stiffness};
    const int normal = element->tangents;
    sm_dual closed = sm_dual_constant(1.0); /* part of the path after touch-down */
    if (N_old < 0.0) {
        closed.value = N / (N - N_old);
        closed.slope[normal] =
            -N_old * element->normal_stiffness / ((N - N_old) * (N - N_old));
    }
    for (int k = 0; k < p.tangents; k++) {
        sm_dual moved = sm_dual_constant(x[k] - x_old[k]);
        moved.slope[k] = 1.0;
        p.path[k] = sm_dual_mul(closed, moved);
        p.trial[k] = p.path[k];
        if (N_old < 0.0) continue;
        p.stretch[k] = at_rest[k] + x_old[k] - memory[k];
        p.trial[k].value = at_rest[k] + x[k] - memory[k];
    }
    if (p.tangents == 2 && p.unmoved) slide_within(&p);
    return p;
}

void sm_frictional_evaluate(const sm_element *element, double scale, const double *x,
                            const double *memory, sm_element_force *result) {
    const int tangents = element->tangents, normal = tangents;
    double *next = result->next;
    const double preload = scale * element->preload, k_n = element->normal_stiffness;
    const double N = preload + k_n * (x[normal] - element->gap);
    *result = (sm_element_force){.next = next};
    double at_rest[2] = {0.0};
    for (int k = 0; k < tangents; k++)
        at_rest[k] = scale * element->tangential_preload[k] / element->tangential_stiffness;
    if (N <= 0.0) {
        result->force[normal] = -preload;
        result->state = SM_OPEN;
        for (int k = 0; k < tangents; k++) {
            result->force[k] = -scale * element->tangential_preload[k];
            next[k] = at_rest[k] + x[k];
        }
        memcpy(next + tangents, x, (size_t)(tangents + 1) * sizeof(double));
        return;
    }
    result->force[normal] = N - preload;
    result->tangent[normal][normal] = k_n;
    const double N_old = preload + k_n * (memory[tangents + normal] - element->gap);
    const path p = path_of(element, at_rest, x, memory, N, N_old);
    double square = 0.0;
    for (int k = 0; k < tangents; k++) square += p.trial[k].value * p.trial[k].value;
    result->state = square <= p.rho[1] * p.rho[1] ? SM_STICK : SM_SLIP;
    sm_dual e[2] = {p.trial[0], p.trial[1]};
    if (result->state == SM_SLIP) {
        sm_dual rho = {.value = p.rho[1]};
        rho.slope[normal] = p.rho_slope;
        if (tangents == 2 && rho.value > 0.0) slide(&p, rho, e);
        else e[0] = e[1] = sm_dual_constant(copysign(1.0, e[0].value));
        for (int k = 0; k < tangents; k++) e[k] = sm_dual_mul(rho, e[k]);
    }
    for (int k = 0; k < tangents; k++) {
        result->force[k] = element->tangential_stiffness * (e[k].value - at_rest[k]);
        for (int j = 0; j <= tangents; j++)
            result->tangent[k][j] = element->tangential_stiffness * e[k].slope[j];
        if (result->state == SM_SLIP || !p.unmoved) next[k] = at_rest[k] + x[k] - e[k].value;
        else next[k] = memory[k];
    }
    memcpy(next + tangents, x, (size_t)(tangents + 1) * sizeof(double));
}

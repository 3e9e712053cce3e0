/* Time integration of eq. (1) at full order, the reference for the slow flow. rom/full/ calls
 * it. */
#ifndef SLIPMODE_FULL_H
#define SLIPMODE_FULL_H

#include "slipmode.h"

/* I q'' + C q' + diag(stiffness) q + W g(W^T q') = sum_j pattern_j F_j cos(theta_j + ph_j), in
 * coordinates q where the mass is the identity and the stiffness diagonal. Elastic contacts have
 * W f(W^T q, memory) instead of W g; they are no part of the stiffness. */
typedef struct {
    int32_t coordinates;      /* n */
    int32_t contacts;         /* N_c, at most n */
    int32_t modes;            /* harmonic forces, 1 or 2 */
    int32_t outputs;          /* 0 or more */
    int32_t law;              /* sm_law */
    int32_t diagonal;         /* 1: C, and with it A, is diagonal */
    double alpha;             /* regularisation velocity of the tanh law [m/s] */
    double step;              /* h [s] */
    const double *limit;      /* (N_c) friction limits mu N [N]; not of elastic contacts */
    const double *stiffness;  /* (n) squared natural frequencies with free contacts */
    const double *damping;    /* C, (n) if diagonal, else (n, n) */
    const double *directions; /* (N_c, n) W^T */
    const double *patterns;   /* (modes, n) */
    const double *output;     /* (outputs, n): outputs per coordinate */
    const double *inverse;    /* of A = I / g + C + g diag(stiffness), as damping; g = gamma h */
    const double *resistance; /* (N_c, N_c) S = (W^T A^-1 W)^-1; not of elastic contacts */
    /* elastic contacts only: */
    const sm_elastic *elastic;
    const double *own, *ahead; /* (n) g and b, weights of a step: see full/elastic_step.h [s] */
    /* (N_c, N_c) R = D (I + diag(reference) D)^-1, D = W^T diag(g) A^-1 W */
    const double *flexibility;
} sm_full;

#define SM_FULL_GAMMA 0.25 /* diagonal coefficient of the ESDIRK4 method, full/esdirk4.h */

/* Returns the number of doubles of the state: q and q' (n each), contact displacement, velocity
 * and force (N_c each), the work done on the contacts, and the memory of elastic contacts. Rigid
 * contacts dissipate the work; elastic ones store a part. */
SM_API size_t sm_full_state_count(const sm_full *full);

/* Results of an integration: `count` samples, one after every `every` steps. */
typedef struct {
    size_t count, every;             /* both 1 or more */
    double *displacement, *velocity; /* (count, outputs) */
    double *contact;    /* (count, 3, N_c): displacement, velocity, force less preload */
    double *dissipated; /* (count) work done on the contacts [J] */
} sm_full_samples;

/* Integrates `count` times `every` steps; the first one begins `elapsed` seconds after the inputs
 * start. The state is advanced; it is undefined on any status but SM_OK. */
SM_API sm_status sm_full_march(const sm_full *full, const sm_inputs *inputs, double elapsed,
                               double *state, const sm_full_samples *samples);

#endif

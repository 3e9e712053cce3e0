/* One implicit step of the contact problem, eq. (12): [M x'' +] D x' + K x + g(x') = u(t).
 *
 * Two-stage L-stable SDIRK of second order (Alexander 1977, gamma = 1 - 1/sqrt 2): stages at
 * t + gamma h and t + h, so that a stuck contact stays exactly where it is. Each stage is
 *   S v + g(v) = r,   S = [M / (gamma h) +] D + gamma h K,
 * the minimum of a strictly convex potential, which stage/newton.h finds.
 */
#ifndef SLIPMODE_SDIRK2_H
#define SLIPMODE_SDIRK2_H

#include "base/block.h"
#include "contact/friction.h"
#include "base/products.h"

#define SM_GAMMA 0.29289321881345254
#define SM_STAGE_TOLERANCE 1e-11 /* of the forces on the contact */
#define SM_SMOOTH_TOLERANCE 1e-12 /* of the friction limits, for rounding alone */

typedef struct {
    int contacts;
    double h;            /* step [s] */
    double *matrix;      /* (N_c, N_c) S */
    double *stiffness;   /* (N_c, N_c) K */
    double *inertia;     /* (N_c, N_c) M / (gamma h) */
    int massless;
    int sticks;          /* Coulomb friction, which has a jump at zero velocity */
    double tolerance;    /* of the residual of tanh friction, in friction limits */
    double *factor;      /* (N_c, N_c) of S, for the check that it is positive definite */
    sm_resolvent *laws;  /* (N_c) */
} sm_stepper;

/* Lane arrays of a march. */
typedef struct {
    int lanes;
    size_t size;         /* doubles from x on: all of them */
    double *x, *base;    /* displacement; stage base x + h (1 - gamma) v_1 */
    double *u;           /* forcing of the stage */
    double *v;           /* velocity */
    double *g, *slope;   /* friction and dg/dv, infinite where a contact sticks */
    double *stage_v[2];  /* last velocity of each stage: the first guess of the next step */
    double *r, *residual; /* right-hand side of the stage, r - S v - g */
    double *step, *before; /* last Newton step, velocity before it */
    double *factor;      /* (N_c, N_c) per lane, of S + diag slope */
    double *last_r;      /* of one lane: right-hand side of the stage before */
    int rows;            /* of one lane: rows of the factor that are valid */
} sm_lanes;

void sm_stepper_place(sm_stepper *stepper, int contacts, sm_block *block);
/* SM_BAD_ARGUMENT unless S is positive definite: the step would have no unique solution. Its
 * tolerance is SM_SMOOTH_TOLERANCE. */
sm_status sm_stepper_set(sm_stepper *stepper, const sm_contact *contact, double h);
void sm_lanes_place(sm_lanes *lane, int contacts, int lanes, sm_block *block);

/* `n`, the number of contacts, may be a literal in what follows. */

/* r = u - K x */
SM_INLINE void sm_stage_load(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                             const double *restrict x) {
    sm_times(n, lanes, s->stiffness, x, m->r);
    for (int i = 0; i < n; i++) {
        double *restrict r = m->r + (size_t)i * lanes;
        const double *restrict u = m->u + (size_t)i * lanes;
        SM_SIMD
        for (int l = 0; l < lanes; l++) r[l] = u[l] - r[l];
    }
}

/* r += M (velocity the stage starts from) / (gamma h). The last stage of a step ends it, so
 * stage_v[1] holds the velocity at its start until that stage is solved. */
SM_INLINE void sm_stage_load_inertia(const int n, const int lanes, const sm_stepper *s,
                                     sm_lanes *m, int stage) {
    const double gain = stage == 0 ? 0.0 : (1.0 - SM_GAMMA) / SM_GAMMA;
    for (int i = 0; i < n; i++) {
        double *restrict r = m->r + (size_t)i * lanes;
        for (int j = 0; j < n; j++) {
            const double m_ij = s->inertia[i * n + j];
            const double *restrict start = m->stage_v[1] + (size_t)j * lanes;
            const double *restrict first = m->stage_v[0] + (size_t)j * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++)
                r[l] += m_ij * (start[l] + gain * (first[l] - start[l]));
        }
    }
}

/* Right-hand side m->r of a stage, 0 or 1, from the forcing in m->u. */
SM_INLINE void sm_stage_begin(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                              int stage) {
    sm_stage_load(n, lanes, s, m, stage == 0 ? m->x : m->base);
    if (!s->massless) sm_stage_load_inertia(n, lanes, s, m, stage);
}

/* What follows from the velocity m->v of a stage. */
SM_INLINE void sm_stage_end(const int n, const int lanes, const sm_stepper *s, sm_lanes *m,
                            int stage) {
    const size_t size = (size_t)n * (size_t)lanes;
    for (size_t k = 0; k < size; k++) m->stage_v[stage][k] = m->v[k];
    const double first = (1.0 - SM_GAMMA) * s->h, last = SM_GAMMA * s->h;
    if (stage == 0)
        for (size_t k = 0; k < size; k++) m->base[k] = m->x[k] + first * m->v[k];
    else
        for (size_t k = 0; k < size; k++) m->x[k] = m->base[k] + last * m->v[k];
}

#endif

/* One implicit step of I q'' + C q' + Lambda q + W g(W^T q') = f(t), in coordinates where the mass
 * is the identity and the stiffness diagonal.
 *
 * ESDIRK4(3)6L[2]SA of Kennedy and Carpenter (2003), the implicit part of ARK4(3)6L[2]SA: fourth
 * order, L-stable, second-order stages, the last stage ends the step and its acceleration begins
 * the next. A stage that starts from (x, u) and ends at velocity v, position x + gamma h v is
 *   A v + W g(W^T v) = f + u / (gamma h) - Lambda x,   A = I / (gamma h) + C + gamma h Lambda.
 * With free velocities v_0 = A^-1 (...) the contacts see S v_c + g(v_c) = S W^T v_0,
 * S = (W^T A^-1 W)^-1, and v = v_0 - A^-1 W g: O(n N_c) a stage where A is diagonal. Elastic
 * contacts have another step, elastic_step.h, in the same arrays. full.c makes the steps.
 */
#ifndef SLIPMODE_ESDIRK4_H
#define SLIPMODE_ESDIRK4_H

#include "base/check.h"
#include "contact/stepper.h"
#include "full/carrier.h"

#define SM_ESDIRK4_STAGES SM_CARRIER_STAGES

/* Loops over the coordinates k by blocks for the vectoriser; the last block is filled with zeros. */
#define SM_EACH(k, width)                                             \
    for (size_t block = 0; block < (width); block += SM_SHORT_VECTOR) \
        SM_SIMD for (size_t k = block; k < block + SM_SHORT_VECTOR; k++)

typedef struct {
    int contacts, diagonal;
    size_t width;              /* n, rounded up to whole blocks: rows of every array below */
    double h;
    sm_carrier carrier;
    sm_stepper stepper;        /* of the contacts: its matrix is S */
    sm_lanes lane;
    double *q, *v;             /* state */
    double *x_c, *force;       /* (N_c) contact displacement, friction force */
    const double *v_c;         /* (N_c) contact velocity */
    double dissipated;         /* at the contacts [J] */
    double *base_q, *base_v;   /* start of the stage */
    double *stage_v;           /* (stages) velocities */
    double *stage_dv;          /* (stages) accelerations times gamma h */
    double *stiffness;         /* Lambda */
    double *per_step;          /* 1 / (gamma h); elastic contacts: 1 / own */
    double *inverse;           /* A^-1: its diagonal, or (n) rows */
    double *load;              /* right-hand side of A */
    double *pattern;           /* (SM_MODES) force patterns, 0 if absent */
    double *pattern_response;            /* (SM_MODES) A^-1 pattern */
    double *response;          /* (N_c) A^-1 W */
    double *gather;            /* (N_c) S W^T */
} sm_esdirk4;

static const double SM_ESDIRK4_OFFSET[SM_ESDIRK4_STAGES] = {
    0.0, 0.5, 83.0 / 250.0, 31.0 / 50.0, 17.0 / 20.0, 1.0};

/* Weights of the earlier stages; the weight of the stage itself is SM_FULL_GAMMA. */
static const double SM_ESDIRK4_WEIGHT[SM_ESDIRK4_STAGES][SM_ESDIRK4_STAGES] = {
    {0.0},
    {0.25},
    {8611.0 / 62500.0, -1743.0 / 31250.0},
    {5012029.0 / 34652500.0, -654441.0 / 2922500.0, 174375.0 / 388108.0},
    {15267082809.0 / 155376265600.0, -71443401.0 / 120774400.0, 730878875.0 / 902184768.0,
     2285395.0 / 8070912.0},
    {82889.0 / 524892.0, 0.0, 15625.0 / 83664.0, 69875.0 / 102672.0, -2260.0 / 8211.0}};

/* Sets the start of a stage: the state, moved by the `stage` (a literal) earlier stages. */
SM_INLINE void sm_esdirk4_combine(const int stage, sm_esdirk4 *m) {
    const size_t width = m->width;
    const double *restrict q = m->q, *restrict v = m->v;
    const double *restrict stage_v = m->stage_v, *restrict stage_dv = m->stage_dv;
    double *restrict base_q = m->base_q, *restrict base_v = m->base_v;
    SM_EACH(k, width) {
        double moved = 0.0, sped = 0.0;
        for (int j = 0; j < stage; j++) {
            moved += SM_ESDIRK4_WEIGHT[stage][j] * stage_v[(size_t)j * width + k];
            sped += SM_ESDIRK4_WEIGHT[stage][j] * stage_dv[(size_t)j * width + k];
        }
        base_q[k] = q[k] + m->h * moved;
        base_v[k] = v[k] + sped / SM_FULL_GAMMA;
    }
}

/* Sets the start of any stage. */
SM_INLINE void sm_esdirk4_start_stage(sm_esdirk4 *m, int stage) {
    switch (stage) {
    case 1: sm_esdirk4_combine(1, m); break;
    case 2: sm_esdirk4_combine(2, m); break;
    case 3: sm_esdirk4_combine(3, m); break;
    case 4: sm_esdirk4_combine(4, m); break;
    default: sm_esdirk4_combine(5, m); break;
    }
}

/* Returns the product of two rows. */
SM_INLINE double sm_full_dot(const double *restrict a, const double *restrict b, size_t width) {
    double part[SM_SHORT_VECTOR] = {0.0};
    SM_EACH(k, width) part[k % SM_SHORT_VECTOR] += a[k] * b[k];
    return (part[0] + part[1]) + (part[2] + part[3]);
}

/* Sets v = A^-1 load, for a dense matrix. */
SM_INLINE void sm_esdirk4_divide(const sm_esdirk4 *m, double *restrict v) {
    const size_t width = m->width;
    const double *restrict load = m->load;
    for (size_t i = 0; i < width; i++) v[i] = 0.0;
    for (size_t i = 0; i < width; i++) { /* A^-1 is symmetric: its rows are its columns */
        const double *restrict column = m->inverse + i * width;
        const double load_i = load[i];
        SM_EACH(k, width) v[k] += column[k] * load_i;
    }
}

/* Sets the velocities v of the stage without friction, under forces (SM_MODES). */
SM_INLINE void sm_esdirk4_free(sm_esdirk4 *m, const double *force, double *restrict v) {
    const size_t width = m->width;
    const double *restrict base_q = m->base_q, *restrict base_v = m->base_v;
    const double *restrict stiffness = m->stiffness, *restrict inverse = m->inverse;
    const double *restrict first = m->pattern_response, *restrict second = first + width;
    const double *restrict per_step = m->per_step;
    double *restrict load = m->load;
    const double f_0 = force[0], f_1 = force[1];
    if (m->diagonal) {
        SM_EACH(k, width) {
            const double load_k = base_v[k] * per_step[k] - stiffness[k] * base_q[k];
            v[k] = inverse[k] * load_k + first[k] * f_0 + second[k] * f_1;
        }
        return;
    }
    SM_EACH(k, width) load[k] = base_v[k] * per_step[k] - stiffness[k] * base_q[k];
    sm_esdirk4_divide(m, v);
    SM_EACH(k, width) v[k] += first[k] * f_0 + second[k] * f_1;
}

/* Adds the effect of friction to the velocities v without it. */
SM_INLINE sm_status sm_esdirk4_friction(sm_esdirk4 *m, double *restrict v) {
    const int contacts = m->contacts;
    const size_t width = m->width;
    for (int i = 0; i < contacts; i++)
        m->lane.r[i] = sm_full_dot(m->gather + (size_t)i * width, v, width);
    const sm_status status = sm_solve_one(&m->stepper, &m->lane);
    for (int i = 0; i < contacts; i++) {
        double force = m->lane.r[i];
        for (int j = 0; j < contacts; j++)
            force -= m->stepper.matrix[i * contacts + j] * m->lane.v[j];
        m->force[i] = force;
        const double *restrict response = m->response + (size_t)i * width;
        SM_EACH(k, width) v[k] -= response[k] * force;
    }
    return status;
}

/* Adds to contact displacements and dissipated energy, by the quadrature of the step. */
SM_INLINE void sm_esdirk4_accumulate(sm_esdirk4 *m, double weight) {
    for (int i = 0; i < m->contacts; i++) {
        m->x_c[i] += weight * m->v_c[i];
        m->dissipated += weight * m->force[i] * m->v_c[i];
    }
}

/* Makes the step that starts `elapsed` seconds after the inputs do. On entry stage_dv[0] belongs to
 * the state and the carrier to this step; on return, to the next ones. */
SM_INLINE sm_status sm_esdirk4_step(sm_esdirk4 *m, double elapsed) {
    const size_t width = m->width;
    const double h = m->h, own = SM_FULL_GAMMA * h;
    sm_esdirk4_accumulate(m, SM_ESDIRK4_WEIGHT[SM_ESDIRK4_STAGES - 1][0] * h);
    memcpy(m->stage_v, m->v, width * sizeof(double));
    for (int stage = 1; stage < SM_ESDIRK4_STAGES; stage++) {
        double *restrict v = m->stage_v + (size_t)stage * width;
        double *restrict dv = m->stage_dv + (size_t)stage * width;
        double force[SM_MODES] = {0.0};
        sm_carrier_force(&m->carrier, stage, elapsed, force);
        sm_esdirk4_start_stage(m, stage);
        sm_esdirk4_free(m, force, v);
        SM_TRY(sm_esdirk4_friction(m, v));
        const int last = stage == SM_ESDIRK4_STAGES - 1;
        sm_esdirk4_accumulate(m, last ? own : h * SM_ESDIRK4_WEIGHT[SM_ESDIRK4_STAGES - 1][stage]);
        SM_EACH(k, width) dv[k] = v[k] - m->base_v[k];
    }
    const double *restrict v = m->stage_v + (SM_ESDIRK4_STAGES - 1) * width;
    const double *restrict dv = m->stage_dv + (SM_ESDIRK4_STAGES - 1) * width;
    SM_EACH(k, width) {
        m->q[k] = m->base_q[k] + own * v[k];
        m->v[k] = v[k];
        m->stage_dv[k] = dv[k];
    }
    sm_carrier_advance(&m->carrier);
    return SM_OK;
}

#endif

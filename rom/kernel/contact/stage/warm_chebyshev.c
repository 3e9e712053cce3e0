#include "contact/stage/warm_chebyshev.h"

#include "contact/stage/newton_cg.h"

#define FEWEST_FOR_CG 40 /* contacts from which that is faster than factors */

size_t sm_warm_size(int contacts) { return (size_t)contacts * (size_t)(contacts + 7); }

void sm_warm_place(sm_warm *warm, int contacts, double *memory) {
    double **arrays[] = {&warm->v,     &warm->r,    &warm->next, &warm->delta,
                         &warm->bend, &warm->tanh, &warm->sech2};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++, memory += contacts)
        *arrays[i] = memory;
    warm->factor = memory;
}

/* The inverse of J of two contacts, for which a single division is waited for: its diagonal, and
 * what is off it. */
SM_INLINE void invert_two(const sm_stepper *s, sm_warm *warm) {
    const double *S = s->matrix, *sech2 = warm->sech2;
    const double a = S[0] + s->laws[0].limit * warm->per_alpha * sech2[0];
    const double b = S[3] + s->laws[1].limit * warm->per_alpha * sech2[1];
    const double inverse = 1.0 / (a * b - S[1] * S[1]);
    warm->factor[0] = b * inverse;
    warm->factor[1] = a * inverse;
    warm->factor[2] = -S[1] * inverse;
}

/* The factor L D L^T of J, or the inverse. */
SM_INLINE void factorise(const int n, const sm_stepper *s, sm_warm *warm) {
    double *restrict f = warm->factor;
    const double *restrict sech2 = warm->sech2;
    if (n == 2) {
        invert_two(s, warm);
        return;
    }
    for (int i = 0; i < n; i++) {
        double pivot = s->matrix[i * n + i]
                       + s->laws[i].limit * warm->per_alpha * sech2[i];
        for (int j = 0; j < i; j++) {
            double sum = s->matrix[i * n + j];
            for (int k = 0; k < j; k++) sum -= f[i * n + k] * f[j * n + k];
            f[i * n + j] = sum;
        }
        for (int j = 0; j < i; j++) {
            const double entry = f[i * n + j] * f[j * n + j];
            pivot -= f[i * n + j] * entry;
            f[i * n + j] = entry;
        }
        f[i * n + i] = 1.0 / pivot;
    }
}

/* Friction tanh(v / alpha) and its slope, and the factor of J there. */
SM_INLINE void linearise(const int n, const sm_stepper *s, sm_warm *warm) {
    double *restrict tanh = warm->tanh, *restrict sech2 = warm->sech2;
    for (int i = 0; i < n; i++) {
        const double w = warm->next[i] * warm->per_alpha;
        const double e = sm_exp_negative(-2.0 * fabs(w)), inv = 1.0 / (1.0 + e);
        tanh[i] = sm_tanh_from(w, e, inv);
        sech2[i] = 4.0 * e * inv * inv;
    }
    factorise(n, s, warm);
}

/* x = J^-1 x */
SM_INLINE void divide(const int n, const sm_warm *warm, double *restrict x) {
    const double *restrict f = warm->factor;
    if (n == 2) {
        const double first = x[0];
        x[0] = f[0] * first + f[2] * x[1];
        x[1] = f[2] * first + f[1] * x[1];
        return;
    }
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) x[i] -= f[i * n + j] * x[j];
    for (int i = 0; i < n; i++) x[i] *= f[i * n + i];
    for (int i = n - 1; i > 0; i--)
        for (int j = 0; j < i; j++) x[j] -= f[i * n + j] * x[i];
}

/* Moves `next` by Chebyshev's step, J^-1 delta and what the curvature of g adds to it; whether
 * what remains is below the tolerance. */
SM_INLINE int move(const int n, const sm_stepper *s, sm_warm *warm) {
    int small = 1, settled = 1;
    divide(n, warm, warm->delta);
    for (int i = 0; i < n; i++) {
        const double x = warm->delta[i] * warm->per_alpha;
        const double curved = warm->sech2[i] * x * x;
        warm->bend[i] = s->laws[i].limit * warm->tanh[i] * curved; /* -g'' delta^2 / 2 */
        small = small && fabs(x) < 1.0;
        settled = settled && curved * fabs(x) < warm->tolerance;
        warm->next[i] += warm->delta[i];
    }
    if (!small) return 0; /* beyond the reach of the expansion: a Newton step alone */
    divide(n, warm, warm->bend);
    for (int i = 0; i < n; i++) warm->next[i] += warm->bend[i];
    return settled;
}

/* One Chebyshev step from `next`; whether it ends at the solution. */
SM_INLINE int iterate(const int n, const sm_stepper *s, sm_warm *warm, const double *r) {
    linearise(n, s, warm);
    for (int i = 0; i < n; i++) {
        double sum = r[i] - s->laws[i].limit * warm->tanh[i];
        for (int j = 0; j < n; j++) sum -= s->matrix[i * n + j] * warm->next[j];
        warm->delta[i] = sum;
    }
    return move(n, s, warm);
}

/* The right-hand side under which contacts have the velocities v. */
SM_INLINE void find_right_hand_side(const int n, const sm_stepper *s, sm_warm *warm,
                                    const double *force) {
    for (int i = 0; i < n; i++) {
        warm->r[i] = force[i];
        for (int j = 0; j < n; j++) warm->r[i] += s->matrix[i * n + j] * warm->v[j];
    }
}

SM_HOT_ONE void sm_warm_start(const sm_stepper *s, sm_warm *warm, const double *v,
                              const double *force) {
    const int n = s->contacts;
    warm->tolerance = SM_WARM_TOLERANCE;
    warm->per_alpha = s->laws[0].law == SM_TANH ? 1.0 / s->laws[0].alpha : 0.0;
    for (int i = 0; i < n; i++) warm->v[i] = warm->next[i] = v[i];
    find_right_hand_side(n, s, warm, force);
    if (warm->per_alpha == 0.0) return;
    if (n == 2)
        linearise(2, s, warm);
    else
        linearise(n, s, warm);
}

SM_INLINE void resume(const int n, const sm_stepper *s, sm_warm *warm, const double *force) {
    find_right_hand_side(n, s, warm, force);
    if (warm->per_alpha > 0.0) factorise(n, s, warm);
}

SM_HOT_ONE void sm_warm_resume(const sm_stepper *s, sm_warm *warm, const double *force) {
    if (s->contacts == 2)
        resume(2, s, warm, force);
    else
        resume(s->contacts, s, warm, force);
}

SM_HOT_ONE static int newton_cg(const sm_stepper *s, sm_lanes *lane) {
    return sm_newton_cg_try(1, s, lane);
}

SM_HOT_ONE static sm_status newton(const sm_stepper *s, sm_lanes *lane) {
    return sm_newton_solve(1, s, lane);
}

/* What is kept from one solution to the next. */
SM_INLINE void carry(const int n, const sm_warm *from, const sm_warm *to) {
    const size_t bytes = (size_t)n * sizeof(double);
    memcpy(to->v, from->v, bytes);
    memcpy(to->r, from->r, bytes);
    memcpy(to->tanh, from->tanh, bytes);
    memcpy(to->sech2, from->sech2, bytes);
    memcpy(to->factor, from->factor, (size_t)n * bytes);
}

/* `n` is a literal where there are few contacts. */
SM_INLINE sm_status solve(const int n, const sm_stepper *s, sm_warm *warm, sm_lanes *lane) {
    const int tries = warm->per_alpha > 0.0 ? 4 : 0;
    const size_t bytes = (size_t)n * sizeof(double);
    memcpy(lane->v, warm->v, bytes);
    if (s->smooth && n >= FEWEST_FOR_CG && newton_cg(s, lane)) {
        memcpy(warm->r, lane->r, bytes);
        memcpy(warm->v, lane->v, bytes);
        return SM_OK;
    }
    if (lane->factors_for == SM_FACTORS_FOR) { /* the factor is an old one */
        memcpy(warm->next, warm->v, bytes);
        linearise(n, s, warm);
    }
    if (tries > 0) {
        for (int i = 0; i < n; i++) warm->delta[i] = lane->r[i] - warm->r[i];
        memcpy(warm->next, warm->v, bytes);
        move(n, s, warm);
    }
    memcpy(warm->r, lane->r, bytes);
    for (int k = 0; k < tries; k++)
        if (iterate(n, s, warm, lane->r)) {
            memcpy(warm->v, warm->next, bytes);
            return SM_OK;
        }
    memcpy(lane->v, warm->v, bytes);
    const sm_status status = newton(s, lane);
    memcpy(warm->v, lane->v, bytes);
    memcpy(warm->next, lane->v, bytes);
    if (tries > 0) linearise(n, s, warm);
    return status;
}

/* In variables of its own, for the compiler to hold in registers: a number that goes through
 * memory comes back some cycles later, and each waits for the one before. */
SM_INLINE sm_status solve_two(const sm_stepper *s, sm_warm *warm, sm_lanes *lane) {
    double row[7][2], factor[4];
    sm_warm own = {.per_alpha = warm->per_alpha, .tolerance = warm->tolerance,
                   .v = row[0], .r = row[1], .next = row[2], .delta = row[3], .bend = row[4],
                   .tanh = row[5], .sech2 = row[6], .factor = factor};
    carry(2, warm, &own);
    const sm_status status = solve(2, s, &own, lane);
    carry(2, &own, warm);
    return status;
}

SM_HOT_ONE sm_status sm_warm_solve(const sm_stepper *s, sm_warm *warm, sm_lanes *lane) {
    return s->contacts == 2 ? solve_two(s, warm, lane) : solve(s->contacts, s, warm, lane);
}

SM_INLINE sm_status stage_one(const int n, const sm_stepper *s, sm_warm *warm, sm_lanes *lane,
                              int stage) {
    sm_stage_begin(n, 1, s, lane, stage);
    const sm_status status = n == 2 ? solve_two(s, warm, lane) : solve(n, s, warm, lane);
    memcpy(lane->v, warm->v, (size_t)n * sizeof(double));
    sm_stage_end(n, 1, s, lane, stage);
    return status;
}

SM_HOT_ONE sm_status sm_stage_one(const sm_stepper *s, sm_warm *warm, sm_lanes *lane, int stage) {
    return s->contacts == 2 ? stage_one(2, s, warm, lane, stage)
                            : stage_one(s->contacts, s, warm, lane, stage);
}

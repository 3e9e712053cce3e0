#include "contact/stage/warm_iteration.h"

void sm_warm_place(sm_warm *warm, int contacts, sm_block *block) {
    const size_t n = (size_t)contacts;
    double **arrays[] = {&warm->v,     &warm->r,    &warm->next, &warm->delta,
                         &warm->bend, &warm->tanh, &warm->sech2};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++) *arrays[i] = sm_take(block, n);
    warm->factor = sm_take(block, n * n);
}

SM_HOT_ONE int sm_warm_newton_cg(const sm_stepper *s, sm_lanes *lane) {
    return sm_newton_cg_try(1, s, lane);
}

SM_HOT_ONE sm_status sm_warm_newton(const sm_stepper *s, sm_lanes *lane) {
    return sm_newton_solve(1, s, lane);
}

/* The right-hand side under which contacts have the velocities v. */
static void find_right_hand_side(const sm_stepper *s, sm_warm *warm, const double *force) {
    const int n = s->contacts;
    for (int i = 0; i < n; i++) {
        warm->r[i] = force[i];
        for (int j = 0; j < n; j++) warm->r[i] += s->matrix[i * n + j] * warm->v[j];
    }
}

SM_HOT_ONE void sm_warm_start(const sm_stepper *s, sm_warm *warm, const double *v,
                              const double *force) {
    warm->tolerance = SM_WARM_TOLERANCE;
    warm->per_alpha = s->laws[0].law == SM_TANH ? 1.0 / s->laws[0].alpha : 0.0;
    for (int i = 0; i < s->contacts; i++) warm->v[i] = warm->next[i] = v[i];
    find_right_hand_side(s, warm, force);
    if (warm->per_alpha > 0.0) sm_warm_linearise(s->contacts, s, warm);
}

SM_HOT_ONE void sm_warm_resume(const sm_stepper *s, sm_warm *warm, const double *force) {
    find_right_hand_side(s, warm, force);
    if (warm->per_alpha > 0.0) sm_warm_factorise(s->contacts, s, warm);
}

SM_HOT_ONE static sm_status solve(const sm_stepper *s, sm_warm *warm, sm_lanes *lane) {
    return sm_warm_solve_in(s->contacts, s, warm, lane);
}

sm_status sm_warm_solve(const sm_stepper *s, sm_warm *warm, sm_lanes *lane) {
    return s->contacts == 2 ? sm_warm_solve_two(s, warm, lane) : solve(s, warm, lane);
}

SM_HOT_ONE static sm_status stage_one(const sm_stepper *s, sm_warm *warm, sm_lanes *lane,
                                      double *pull, int stage) {
    const int n = s->contacts;
    sm_tr_bdf2_begin(n, s, lane, pull, stage);
    const sm_status status = sm_warm_solve_in(n, s, warm, lane);
    memcpy(lane->v, warm->v, (size_t)n * sizeof(double));
    sm_tr_bdf2_end(n, s, lane, pull, stage);
    return status;
}

sm_status sm_stage_one(const sm_stepper *s, sm_warm *warm, sm_lanes *lane, double *pull,
                       int stage) {
    return s->contacts == 2 ? sm_stage_two(s, warm, lane, pull, stage)
                            : stage_one(s, warm, lane, pull, stage);
}

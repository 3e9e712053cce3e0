/* Stages of SDIRK2 for lanes side by side: the contacts through periods, called by
 * torus/rigid/steps.c. */
#include "contact/stage/solve.h"

#include "contact/stage/newton.h"

/* `n` is a literal where there are few contacts. */
SM_INLINE sm_status solve_of(const int n, const int lanes, const sm_stepper *s, sm_lanes *m) {
    sm_guess(n, lanes, s, m);
    return sm_newton(n, lanes, s, m);
}

SM_INLINE sm_status solve(const int lanes, const sm_stepper *s, sm_lanes *m) {
    if (s->contacts == 1) return solve_of(1, lanes, s, m);
    if (s->contacts == 2) return solve_of(2, lanes, s, m);
    return solve_of(s->contacts, lanes, s, m);
}

SM_HOT static sm_status solve_few(const sm_stepper *s, sm_lanes *m) {
    return solve(SM_FEW_LANES, s, m);
}

SM_HOT static sm_status solve_many(const sm_stepper *s, sm_lanes *m) {
    return solve(SM_LANES, s, m);
}

sm_status sm_solve_lanes(const sm_stepper *s, sm_lanes *m) {
    return m->lanes == SM_FEW_LANES ? solve_few(s, m) : solve_many(s, m);
}

SM_INLINE sm_status stage_of(const int lanes, const sm_stepper *s, sm_lanes *m, int stage) {
    sm_stage_begin(s->contacts, lanes, s, m, stage);
    memcpy(m->v, m->stage_v[stage], (size_t)(s->contacts * lanes) * sizeof(double));
    const sm_status status = sm_solve_lanes(s, m);
    sm_stage_end(s->contacts, lanes, s, m, stage);
    return status;
}

SM_HOT static sm_status stage_few(const sm_stepper *s, sm_lanes *m, int stage) {
    return stage_of(SM_FEW_LANES, s, m, stage);
}

SM_HOT static sm_status stage_many(const sm_stepper *s, sm_lanes *m, int stage) {
    return stage_of(SM_LANES, s, m, stage);
}

sm_status sm_stage_lanes(const sm_stepper *s, sm_lanes *m, int stage) {
    return m->lanes == SM_FEW_LANES ? stage_few(s, m, stage) : stage_many(s, m, stage);
}

/* Stages of TR-BDF2 and of ESDIRK4 for one lane: the contacts along a trajectory, called by
 * slow/motion/contact_march.c and full/esdirk4.h. */
#include "contact/stage/newton.h"
#include "contact/stage/solve.h"
#include "contact/tr_bdf2.h"

/* `n` is a literal where there are two contacts. */
SM_INLINE sm_status solve(const int n, const sm_stepper *s, sm_lanes *m) {
    const sm_status status = sm_newton(n, 1, s, m);
    for (int i = 0; i < n; i++) m->last_r[i] = m->r[i];
    return status;
}

SM_INLINE sm_status stage_of(const int n, const sm_stepper *s, sm_lanes *m, double *inertia,
                             int stage) {
    sm_tr_bdf2_begin(n, s, m, inertia, stage);
    const sm_status status = solve(n, s, m);
    sm_tr_bdf2_end(n, s, m, inertia, stage);
    return status;
}

SM_HOT_ONE sm_status sm_solve_one(const sm_stepper *s, sm_lanes *m) {
    return s->contacts == 2 ? solve(2, s, m) : solve(s->contacts, s, m);
}

SM_HOT_ONE sm_status sm_stage_one(const sm_stepper *s, sm_lanes *m, double *inertia, int stage) {
    return s->contacts == 2 ? stage_of(2, s, m, inertia, stage)
                            : stage_of(s->contacts, s, m, inertia, stage);
}

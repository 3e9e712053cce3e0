/* Stages of a time step for one lane: contacts along a trajectory, slow/motion/contact_march.c, and
 * in the structure at full order, full/esdirk4.h. The number of contacts is a literal if it is 2. */
#include "contact/stage/tr_bdf2.h"

SM_HOT_ONE sm_status sm_solve_one(const sm_stepper *s, sm_lanes *m) {
    return s->contacts == 2 ? sm_solve(2, 1, s, m) : sm_solve(s->contacts, 1, s, m);
}

SM_HOT_ONE sm_status sm_stage_one(const sm_stepper *s, sm_lanes *m, int stage) {
    return s->contacts == 2 ? sm_stage(2, 1, s, m, stage) : sm_stage(s->contacts, 1, s, m, stage);
}

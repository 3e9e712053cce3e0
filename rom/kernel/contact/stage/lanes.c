/* Stages of a time step for lanes side by side: contacts on the torus, torus/rigid/steps.c. */
#include "contact/stage/tr_bdf2.h"

/* Makes a stage with a literal number of contacts if there are few. */
SM_INLINE sm_status stage_of(const int lanes, const sm_stepper *s, sm_lanes *m, int stage) {
    if (s->contacts == 1) return sm_stage(1, lanes, s, m, stage);
    if (s->contacts == 2) return sm_stage(2, lanes, s, m, stage);
    return sm_stage(s->contacts, lanes, s, m, stage);
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

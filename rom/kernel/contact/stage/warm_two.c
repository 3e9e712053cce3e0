/* One lane of two contacts: all numbers of a stage fit in registers. */
#include "contact/stage/warm_iteration.h"

/* Copies what is kept from one solution to the next. */
SM_INLINE void carry(const sm_warm *from, const sm_warm *to) {
    sm_copy_few(2, from->v, to->v);
    sm_copy_few(2, from->r, to->r);
    sm_copy_few(2, from->tanh, to->tanh);
    sm_copy_few(2, from->sech2, to->sech2);
    sm_copy_few(3, from->factor, to->factor);
}

/* In variables of its own, for the compiler to hold in registers: a number that goes through
 * memory comes back some cycles later, and each waits for the one before. */
SM_INLINE sm_status solve(const sm_stepper *s, sm_warm *warm, sm_lanes *lane) {
    double row[7][2], factor[4];
    sm_warm own = {.per_alpha = warm->per_alpha, .tolerance = warm->tolerance,
                   .v = row[0], .r = row[1], .next = row[2], .delta = row[3], .bend = row[4],
                   .tanh = row[5], .sech2 = row[6], .factor = factor};
    carry(warm, &own);
    const sm_status status = sm_warm_solve_in(2, s, &own, lane);
    carry(&own, warm);
    return status;
}

SM_HOT_ONE sm_status sm_warm_solve_two(const sm_stepper *s, sm_warm *warm, sm_lanes *lane) {
    return solve(s, warm, lane);
}

SM_HOT_ONE sm_status sm_stage_two(const sm_stepper *s, sm_warm *warm, sm_lanes *lane,
                                    double *pull, int stage) {
    sm_tr_bdf2_begin(2, s, lane, pull, stage);
    const sm_status status = solve(s, warm, lane);
    sm_copy_few(2, warm->v, lane->v);
    sm_tr_bdf2_end(2, s, lane, pull, stage);
    return status;
}

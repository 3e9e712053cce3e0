/* Constants of the friction laws in friction.h, for the steps of one length. */
#include "contact/friction.h"

/* An estimate of 1 - tanh w at c w + tanh w = 1, for the initial guess of the resolvent only. */
static double transition_width(double c) {
    double w = 1.0;
    for (int i = 0; i < 4; i++) w = 0.5 * log(1.0 + 2.0 / (c * w));
    return c * w < 1.0 ? c * w : 1.0;
}

sm_resolvent sm_resolvent_make(int32_t law, double s, double limit, double alpha) {
    sm_resolvent f = {.law = law, .s = s, .limit = limit, .alpha = alpha};
    if (limit > 0.0) f.per_limit = 1.0 / limit;
    if (law == SM_TANH && limit > 0.0) {
        f.per_alpha = 1.0 / alpha;
        f.steepest = limit * f.per_alpha;
        f.per_steepest = alpha * f.per_limit;
        f.c = s * alpha / limit;
        f.slip = 1.0 / f.c;
        f.stick = 1.0 / (1.0 + f.c);
        f.knee = transition_width(f.c);
    }
    return f;
}

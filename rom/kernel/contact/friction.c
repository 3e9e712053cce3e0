#include "contact/friction.h"

/* About 1 - tanh w where c w + tanh w = 1. It only shapes the first guess of the resolvent. */
static double transition_width(double c) {
    double w = 1.0;
    for (int i = 0; i < 4; i++) w = 0.5 * log(1.0 + 2.0 / (c * w));
    return c * w < 1.0 ? c * w : 1.0;
}

sm_resolvent sm_resolvent_make(int32_t law, double s, double limit, double alpha) {
    sm_resolvent f = {law, s, limit, alpha, 0.0, 0.0, 0.0, 0.0};
    if (law == SM_TANH && limit > 0.0) {
        f.c = s * alpha / limit;
        f.slip = 1.0 / f.c;
        f.stick = 1.0 / (1.0 + f.c);
        f.knee = transition_width(f.c);
    }
    return f;
}

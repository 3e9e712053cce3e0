/* Phases t_B of the phase lines, eq. (13): powers exp(i m t_B) as products of exp(i t_B). */
#include "torus/phases.h"

#include <math.h>

#include "base/cnumber.h"
#include "base/exact_sum.h"

void sm_phases_place(sm_phases *f, size_t orders, const int32_t *order, sm_block *block) {
    int highest = 0;
    for (size_t q = 0; q < orders; q++)
        if (abs(order[2 * q + 1]) > highest) highest = abs(order[2 * q + 1]);
    f->powers = sm_whole((size_t)highest + 1, SM_TOGETHER);
    f->across = sm_take(block, 2 * f->powers * f->wide);
}

void sm_phases_start(sm_phases *f) {
    f->turns = 0.0;
    sm_phases_turn(f, 0.0);
}

void sm_phases_turn(sm_phases *f, double turns) {
    double *c = f->across + 2 * f->wide, *s = c + f->wide;
    f->turns = fmod(f->turns + turns, 1.0);
    for (size_t k = 0; k < f->wide; k++) {
        const double t_b0 =
            SM_TWO_PI * ((double)(k % f->lines) / (double)f->lines + f->turns);
        c[k] = cos(t_b0);
        s[k] = sin(t_b0);
    }
    sm_powers(f->wide, f->powers, f->across);
}

/* Phases t_B of the phase lines, eq. (13): powers exp(i m t_B) as products of exp(i t_B). */
#include "torus/phases.h"

#include <math.h>

#include "base/exact_sum.h"

void sm_phases_place(sm_phases *f, size_t orders, const int32_t *order, sm_block *block) {
    int highest = 0;
    for (size_t q = 0; q < orders; q++)
        if (abs(order[2 * q + 1]) > highest) highest = abs(order[2 * q + 1]);
    f->powers = ((size_t)highest + SM_POWERS) / SM_POWERS * SM_POWERS;
    f->across = sm_take(block, 2 * f->powers * f->wide);
}

/* Computes all powers from the first one. */
static void set_powers(sm_phases *f) {
    const size_t wide = f->wide;
    const double *c = f->across + 2 * wide, *s = c + wide;
    for (size_t k = 0; k < wide; k++) f->across[k] = 1.0;
    for (size_t m = 2; m < f->powers; m++) {
        const double *re = f->across + 2 * (m - 1) * wide, *im = re + wide;
        double *to = f->across + 2 * m * wide;
        for (size_t k = 0; k < wide; k++) {
            to[k] = re[k] * c[k] - im[k] * s[k];
            to[wide + k] = re[k] * s[k] + im[k] * c[k];
        }
    }
}

void sm_phases_start(sm_phases *f) {
    double *c = f->across + 2 * f->wide, *s = c + f->wide;
    for (size_t k = 0; k < f->wide; k++) {
        const double t_b0 = SM_TWO_PI * (double)(k % f->lines) / (double)f->lines;
        c[k] = cos(t_b0);
        s[k] = sin(t_b0);
    }
    set_powers(f);
}

void sm_phases_turn(sm_phases *f, double turns) {
    const double turn_c = cos(SM_TWO_PI * turns), turn_s = sin(SM_TWO_PI * turns);
    double *c = f->across + 2 * f->wide, *s = c + f->wide;
    for (size_t k = 0; k < f->wide; k++) {
        const double t = c[k] * turn_c - s[k] * turn_s;
        s[k] = c[k] * turn_s + s[k] * turn_c;
        c[k] = t;
    }
    set_powers(f);
}

/* Harmonic forces F cos(theta + ph) at the stages of equal time steps.
 *
 * From one step to the next each phasor is multiplied by a complex factor; in a sweep the factor
 * changes in the same way: two complex products instead of a cosine. Exact angles restart the
 * recurrence every SM_EXACT_STEPS steps, against rounding. full.c and the steps of this folder call
 * these functions.
 */
#ifndef SLIPMODE_CARRIER_H
#define SLIPMODE_CARRIER_H

#include <math.h>

#include "base/cnumber.h"
#include "base/exact_sum.h"
#include "slipmode.h"

#define SM_CARRIER_STAGES 6

typedef struct {
    double re[SM_CARRIER_STAGES], im[SM_CARRIER_STAGES];
} sm_phasors;

typedef struct {
    int modes;
    double h;                         /* step [s] */
    double offset[SM_CARRIER_STAGES]; /* of each stage from the start of the step [s] */
    const sm_inputs *inputs;
    sm_phasors wave[SM_MODES];        /* exp(i (theta_j + ph_j)) */
    sm_phasors by[SM_MODES];          /* factors of the wave from this step to the next */
    sm_phasors bend[SM_MODES];        /* factors of these factors, in a sweep */
} sm_carrier;

/* Sets the phasor of a stage. */
SM_INLINE void sm_set_phasor(sm_phasors *z, int stage, double angle) {
    z->re[stage] = cos(angle);
    z->im[stage] = sin(angle);
}

/* Sets exact phasors of the step that starts `elapsed` seconds after the inputs do. */
static inline void sm_carrier_anchor(sm_carrier *carrier, double elapsed) {
    const sm_inputs *inputs = carrier->inputs;
    const double h = carrier->h;
    for (int j = 0; j < carrier->modes; j++) {
        const double start = inputs->frequency[j] + inputs->phase_rate[j];
        const double angle = inputs->angle[j] + inputs->phase[j];
        const double sweep = inputs->frequency_rate[j];
        for (int stage = 0; stage < SM_CARRIER_STAGES; stage++) {
            const double t = elapsed + carrier->offset[stage];
            sm_set_phasor(&carrier->wave[j], stage, angle + t * (start + 0.5 * sweep * t));
            sm_set_phasor(&carrier->by[j], stage, h * (start + sweep * (t + 0.5 * h)));
            sm_set_phasor(&carrier->bend[j], stage, sweep * h * h);
        }
    }
}

/* Advances the phasors to the next step. */
SM_INLINE void sm_carrier_advance(sm_carrier *carrier) {
    for (int j = 0; j < carrier->modes; j++) {
        sm_phasors *wave = &carrier->wave[j], *by = &carrier->by[j], *bend = &carrier->bend[j];
        sm_turn(SM_CARRIER_STAGES, wave->re, wave->im, by->re, by->im);
        if (carrier->inputs->frequency_rate[j] != 0.0)
            sm_turn(SM_CARRIER_STAGES, by->re, by->im, bend->re, bend->im);
    }
}

/* Sets forces (SM_MODES) at a stage of the step that starts `elapsed` seconds after the inputs. */
SM_INLINE void sm_carrier_force(const sm_carrier *carrier, int stage, double elapsed,
                                double *force) {
    const sm_inputs *inputs = carrier->inputs;
    const double t = elapsed + carrier->offset[stage];
    for (int j = 0; j < carrier->modes; j++)
        force[j] = (inputs->force[j] + inputs->force_rate[j] * t) * carrier->wave[j].re[stage];
}

#endif

/* Work arrays of a march of one tone, and the rates of its amplitudes. */
#ifndef SLIPMODE_TONE_FLOW_H
#define SLIPMODE_TONE_FLOW_H

#include "base/block.h"
#include "slipmode.h"

typedef struct {
    const sm_tone *tone;
    const sm_tone_inputs *inputs;
    double *given, *drive, *deficit; /* (2, n) the deficits: the last that were found */
} sm_tone_flow;

void sm_tone_flow_place(sm_tone_flow *flow, const sm_tone *tone, sm_block *block);

/* b F + l y, (2, M), at a part (0 to 1) of the march. The deficits are found from the last ones. */
sm_status sm_tone_flow_load(sm_tone_flow *flow, double part, const double *amplitude,
                            double *load);

#endif

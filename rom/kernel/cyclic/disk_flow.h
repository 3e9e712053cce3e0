/* What a march of a disk works on, and the rates of its amplitudes. */
#ifndef SLIPMODE_DISK_FLOW_H
#define SLIPMODE_DISK_FLOW_H

#include "base/block.h"
#include "slipmode.h"

typedef struct {
    const sm_disk *disk;
    const sm_disk_inputs *inputs;
    double *given, *drive, *deficit; /* (2, n) the deficits: the last that were found */
} sm_disk_flow;

void sm_disk_flow_place(sm_disk_flow *flow, const sm_disk *disk, sm_block *block);

/* b F + l y, (2, M), at a part (0 to 1) of the march. The deficits are found from the last ones. */
sm_status sm_disk_flow_load(sm_disk_flow *flow, double part, const double *amplitude,
                            double *load);

#endif

/* A complex number of each mode, side by side: loops over modes are one operation on both.
 *
 * Nothing of the sort is copied as a whole or put together from one mode after the other on the
 * hot path: loads that are wider than the stores before them wait for these. */
#ifndef SLIPMODE_MODAL_H
#define SLIPMODE_MODAL_H

#include "base/cnumber.h"
#include "base/lanes.h"
#include "slipmode.h"

typedef struct {
    double re[SM_MODES], im[SM_MODES];
} sm_modal;

SM_INLINE sm_complex sm_of(const sm_modal *z, int j) { return sm_cx(z->re[j], z->im[j]); }

SM_INLINE void sm_put(sm_modal *z, int j, sm_complex value) {
    z->re[j] = value.re;
    z->im[j] = value.im;
}

#endif

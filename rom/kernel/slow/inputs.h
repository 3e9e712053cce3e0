/* Checks and linear changes of the inputs of a slow flow. */
#ifndef SLIPMODE_INPUTS_H
#define SLIPMODE_INPUTS_H

#include "base/block.h"
#include "slipmode.h"

#define SM_INPUT_DOUBLES SM_DOUBLES_IN(sm_inputs)
#define SM_INPUT_VALUES (3 * SM_MODES + 1) /* inputs that change at a rate */

/* Returns the index of input k among the doubles of sm_inputs, k < SM_INPUT_VALUES. */
SM_INLINE int sm_value_place(int k) {
    return k < 3 * SM_MODES ? k + k / SM_MODES * SM_MODES : 6 * SM_MODES;
}
/* Returns the index of the rate of input k among the doubles of sm_inputs. */
SM_INLINE int sm_rate_place(int k) {
    return sm_value_place(k) + (k < 3 * SM_MODES ? SM_MODES : 1);
}

/* Returns SM_OK if the inputs are finite, and the frequencies of the modes and the limit scale are
 * positive. */
sm_status sm_inputs_check(const sm_inputs *inputs, int modes);

/* Returns the inputs `elapsed` seconds later; inputs of modes that do not exist are 0. */
sm_inputs sm_inputs_after(const sm_inputs *inputs, int modes, double elapsed);

#endif

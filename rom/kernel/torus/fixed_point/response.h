/* What the modes respond to harmonics of the contacts. */
#ifndef SLIPMODE_RESPONSE_H
#define SLIPMODE_RESPONSE_H

#include <stddef.h>

#include "slipmode.h"

/* to = H Y + held, of so many harmonics Y (orders, N_c, 2); the response has an H. */
void sm_respond(const sm_modal_response *response, size_t orders, size_t contacts,
                const double *Y, double *to);

#endif

/* Messages of the status codes, for Python and the FMU; and the fingerprint of the headers that
 * the library was compiled with. */
#include "slipmode.h"

/* Returns what a status means in words. */
const char *sm_message(sm_status status) {
    switch (status) {
    case SM_OK: return "ok";
    case SM_BAD_ARGUMENT: return "an argument has a size, sign or order that is not allowed";
    case SM_NOT_FINITE: return "a value is NaN or infinite";
    case SM_NO_MEMORY: return "out of memory";
    case SM_NOT_CONVERGED: return "the implicit contact step did not converge";
    case SM_OUTSIDE_TABLE: return "an amplitude is outside the friction table";
    case SM_STEP_TOO_SMALL: return "the slow flow cannot meet its tolerance; use shorter steps or a larger tolerance";
    }
    return "unknown status";
}

#ifdef SM_HEADERS /* defined by CMakeLists.txt */
SM_API const char *sm_compiled_headers(void);

/* Returns the fingerprint of the headers, which Python compares with its own. */
const char *sm_compiled_headers(void) { return SM_HEADERS; }
#endif

/* Checks of the structure of a flow of several modes on one or two tones: sizes and finite numbers.
 * tone_entries.c calls them. */
#include "base/check.h"
#include "slow/tone/tone_flow.h"

#define MAX_SIZE 16384 /* modes, contacts, nodes, outputs: counts of doubles fit in 32 bits */

/* Returns whether a number is within its limits. */
static int is_size(int32_t count, int32_t least) { return count >= least && count <= MAX_SIZE; }

/* Checks that arrays exist and are finite. */
static sm_status check_arrays(size_t count, const double *const arrays[], const size_t sizes[]) {
    for (size_t i = 0; i < count; i++) {
        if (!arrays[i]) return SM_BAD_ARGUMENT;
        if (!sm_all_finite(arrays[i], sizes[i])) return SM_NOT_FINITE;
    }
    return SM_OK;
}

/* Checks the arrays of modes; the last one, of outputs, only if there are any. */
static sm_status check_modes(const sm_tone_modes *modes, size_t contacts, size_t rows) {
    const size_t M = 2 * (size_t)modes->count;
    const double *const arrays[] = {modes->pole,   modes->excitation, modes->conjugate,
                                    modes->motion, modes->projection, modes->output};
    const size_t sizes[] = {M, M, M, M * contacts, M * contacts, M * rows};
    return check_arrays(sizeof sizes / sizeof *sizes - (rows ? 0 : 1), arrays, sizes);
}

/* Checks the structure at carrier t. */
static sm_status check_carrier(const sm_tone *tone, int t) {
    const sm_tone_carrier *carrier = &tone->carrier[t];
    if (!is_size(carrier->slow.count, 1) || !is_size(carrier->fast.count, 1)
        || !is_size(carrier->amplitudes, 0))
        return SM_BAD_ARGUMENT;
    const size_t n = (size_t)tone->contacts, rows = sm_tone_rows(tone, t);
    const double *const arrays[] = {carrier->flexibility, carrier->own, carrier->output};
    const size_t sizes[] = {2 * n * (n + 1), 2 * n, 2 * rows * (n + 1)};
    SM_TRY(check_arrays(sizeof sizes / sizeof *sizes - (rows ? 0 : 1), arrays, sizes));
    SM_TRY(check_modes(&carrier->slow, n, rows));
    SM_TRY(check_modes(&carrier->fast, n, rows));
    return sm_check_positive(carrier->reference);
}

/* Checks the tables of the contacts. */
static sm_status check_tables(const sm_tone *tone) {
    const size_t tones = (size_t)tone->tones, kinds = (size_t)tone->kinds;
    const double *const arrays[] = {tone->stiffness, tone->onset, tone->secant};
    const size_t sizes[] = {(size_t)tone->contacts, kinds,
                            4 * tones * tones * (size_t)tone->nodes * (size_t)tone->shares * kinds};
    SM_TRY(check_arrays(sizeof sizes / sizeof *sizes, arrays, sizes));
    for (size_t i = 0; i < kinds; i++) SM_TRY(sm_check_positive(tone->onset[i]));
    SM_TRY(sm_check_positive(tone->spacing));
    SM_TRY(sm_check_not_negative(tone->contraction));
    return isfinite(tone->first) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_tone_check(const sm_tone *tone, double tolerance) {
    if (!tone || tone->tones < 1 || tone->tones > SM_MODES) return SM_BAD_ARGUMENT;
    if (!is_size(tone->contacts, 1) || !is_size(tone->nodes, 2) || tone->kinds < 1
        || tone->contacts % tone->kinds != 0 || !is_size(tone->elastic, 0)
        || !is_size(tone->shares, tone->tones) || (tone->tones == 1 && tone->shares != 1))
        return SM_BAD_ARGUMENT;
    SM_TRY(check_tables(tone));
    for (int t = 0; t < tone->tones; t++) SM_TRY(check_carrier(tone, t));
    return sm_check_positive(tolerance);
}

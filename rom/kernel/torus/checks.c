/* Checks of the arguments of sm_torus_harmonics (periodic/search.c) and sm_torus_growing (growth.c):
 * contacts, discretisation of the torus, points of the amplitude plane and arrays of the results. */
#include <string.h>

#include "base/check.h"
#include "torus/march.h"

#define MAX_COUNT 4096 /* phase lines, and harmonics: products with steps fit an int32_t */
/* A point is marched for at most 14 (max_periods + 16) + 16 periods (periodic/search.c), so that an
 * int32_t can count the steps: 1.85e9 < 2^31. */
#define MAX_PERIODS 2000

/* Checks steps, lines and harmonics. The lines of rigid contacts are a power of two, so that lanes
 * contain whole points, or points whole blocks of lanes. */
static sm_status check_grid(int law, const sm_discretisation *grid) {
    const int32_t steps = grid->steps, lines = grid->lines, orders_count = grid->orders_count;
    const int32_t *orders = grid->orders;
    if (steps < 4 || steps > SM_MOST) return SM_BAD_ARGUMENT;
    if (lines < 1 || lines > MAX_COUNT ||
        (law != SM_ELASTIC && (lines & (lines - 1)) != 0))
        return SM_BAD_ARGUMENT;
    if (!orders || orders_count < 1 || orders_count > MAX_COUNT) return SM_BAD_ARGUMENT;
    for (int32_t k = 0; k < 2 * orders_count; k++)
        if (orders[k] < -SM_MOST || orders[k] > SM_MOST) return SM_BAD_ARGUMENT;
    return SM_OK;
}

/* Checks the carrier frequencies, and that the phases of the highest harmonic are finite. */
static sm_status check_rates(int modes, const double *rates) {
    if (!rates) return SM_BAD_ARGUMENT;
    for (int j = 0; j < modes; j++) {
        SM_TRY(sm_check_positive(rates[j]));
    }
    return modes == 1 || isfinite(rates[1] / rates[0] * SM_MOST) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_torus_check(const sm_contact *contact, const sm_discretisation *grid) {
    SM_TRY(sm_contact_check(contact));
    if (!grid || contact->contacts == 0) return SM_BAD_ARGUMENT;
    SM_TRY(check_grid(contact->law, grid));
    return check_rates(contact->modes, grid->rates);
}

sm_status sm_torus_check_points(const sm_contact *contact, size_t points, const double *values,
                                int32_t orders_count) {
    const size_t per_point = (size_t)orders_count * (size_t)contact->contacts * 2;
    if (!sm_fits(points, per_point * sizeof(double))) return SM_BAD_ARGUMENT;
    if (points > 0 && !values) return SM_BAD_ARGUMENT;
    return sm_all_finite(values, points * (size_t)contact->modes) ? SM_OK : SM_NOT_FINITE;
}

/* Returns whether the response of the modes is given for the harmonics that are computed. */
static int responds_to(const sm_modal_response *response, const sm_discretisation *grid) {
    const size_t size = 2 * (size_t)grid->orders_count * sizeof(int32_t);
    return response->dynamic_stiffness && response->orders_count == grid->orders_count &&
           memcmp(response->orders, grid->orders, size) == 0;
}

/* Checks the smallest amplitudes that scale the tolerance. */
static sm_status check_scales(const sm_contact *contact, const double *smallest_scale) {
    if (!smallest_scale) return SM_BAD_ARGUMENT;
    for (int j = 0; j < contact->modes; j++) {
        SM_TRY(sm_check_not_negative(smallest_scale[j]));
    }
    return SM_OK;
}

/* Checks the points, their initial guesses, and the arrays of the results. */
static sm_status check_points(const sm_torus_task *task, const sm_contact *contact) {
    const sm_torus_points *points = task->points;
    const sm_torus_motion *motion = task->motion;
    const int32_t orders_count = task->grid->orders_count;
    SM_TRY(sm_torus_check_points(contact, points->count, points->amplitudes, orders_count));
    for (size_t k = 0; k < points->count * (size_t)contact->modes; k++)
        if (points->amplitudes[k] < 0.0) return SM_BAD_ARGUMENT;
    if (points->count == 0) return SM_OK;
    const sm_modal_response *response = contact->response;
    const size_t all = 2 * (size_t)contact->contacts * (size_t)orders_count * points->count;
    if (points->guess && !sm_all_finite(points->guess, all)) return SM_NOT_FINITE;
    if (response && (response->start || points->guess) && response->marched > 0
        && !response->periodic)
        return SM_BAD_ARGUMENT;
    return motion->harmonics && motion->mean_square && motion->residual && motion->marched
               ? SM_OK : SM_BAD_ARGUMENT;
}

sm_status sm_torus_check_task(const sm_contact *contact, const sm_torus_task *task) {
    const sm_discretisation *grid = task->grid;
    SM_TRY(sm_torus_check(contact, grid));
    if (!task->points || !task->motion) return SM_BAD_ARGUMENT;
    if (contact->response && !responds_to(contact->response, grid)) return SM_BAD_ARGUMENT;
    SM_TRY(sm_check_not_negative(grid->tolerance));
    SM_TRY(check_scales(contact, grid->smallest_scale));
    SM_TRY(check_points(task, contact));
    return grid->max_periods < 1 || grid->max_periods > MAX_PERIODS ? SM_BAD_ARGUMENT : SM_OK;
}

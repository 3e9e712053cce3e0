#include "torus/torus_check.h"

#include "base/check.h"

#define MAX_STEPS 65536
#define MAX_LINES 4096
#define MAX_ORDER 65536 /* of a harmonic: no grid resolves more */
#define MAX_ORDERS_COUNT 4096

/* Lines of rigid contacts fill lanes. */
static sm_status check_grid(int law, const sm_discretisation *grid) {
    const int32_t steps = grid->steps, lines = grid->lines, orders_count = grid->orders_count;
    const int32_t *orders = grid->orders;
    if (steps < 4 || steps > MAX_STEPS) return SM_BAD_ARGUMENT;
    if (lines < 1 || lines > MAX_LINES ||
        (law != SM_ELASTIC && (lines & (lines - 1)) != 0))
        return SM_BAD_ARGUMENT;
    if (!orders || orders_count < 1 || orders_count > MAX_ORDERS_COUNT) return SM_BAD_ARGUMENT;
    for (int32_t k = 0; k < 2 * orders_count; k++)
        if (orders[k] < -MAX_ORDER || orders[k] > MAX_ORDER) return SM_BAD_ARGUMENT;
    return SM_OK;
}

static sm_status check_rates(int modes, const double *rates) {
    if (!rates) return SM_BAD_ARGUMENT;
    for (int j = 0; j < modes; j++) {
        const sm_status status = sm_check_positive(rates[j]);
        if (status != SM_OK) return status;
    }
    return modes == 1 || isfinite(rates[1] / rates[0] * MAX_ORDER) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_torus_check(const sm_contact *contact, const sm_discretisation *grid) {
    sm_status status = sm_contact_check(contact);
    if (status == SM_OK && !grid) return SM_BAD_ARGUMENT;
    if (status == SM_OK) status = check_grid(contact->law, grid);
    return status == SM_OK ? check_rates(contact->modes, grid->rates) : status;
}

sm_status sm_torus_check_points(const sm_contact *contact, size_t points, const double *values,
                                int32_t orders_count) {
    const size_t per_point = (size_t)orders_count * (size_t)contact->contacts * 2;
    if (!sm_fits(points, per_point * sizeof(double))) return SM_BAD_ARGUMENT;
    if (points > 0 && !values) return SM_BAD_ARGUMENT;
    return sm_all_finite(values, points * (size_t)contact->modes) ? SM_OK : SM_NOT_FINITE;
}

/* Contact motion on the torus while the amplitudes grow: what is proportional to their growth.
 *
 * With a(t) = a + r t the contacts move by x0(t_A, t_B; a + r t) + r x1(t_A, t_B). Marched through
 * two periods of mode A about t = 0 and weighted by a hat over them, what x0 changes by cancels
 * line by line, and the means of (x - x0) exp(-i (n t_A + m t_B)) / r are the harmonics of x1.
 */
#include "torus/torus.h"
#include "torus/group.h"

#define PERIODS_BEFORE 2 /* periods from rest to the first that counts */

/* Weights of the sums of a period: rising from its start, or falling to its end. */
static void weigh(sm_torus_grid *grid, int falling) {
    const size_t row = 2 * (size_t)grid->orders_count;
    for (int k = 0; k < grid->steps; k++) {
        const double rising = (k + 1.0) / grid->steps;
        for (size_t q = 0; q < row; q++)
            grid->weight[(size_t)k * row + q] *= falling ? 1.0 - rising : rising;
    }
}

/* One period, and the amplitudes and phases of the next. */
static sm_status period(const sm_torus_grid *grid, sm_torus_group *g) {
    for (int half = 0; half < 2; half++) {
        const sm_status status = sm_torus_group_half(grid, g, half);
        if (status != SM_OK) return status;
    }
    for (int lane = 0; lane < g->blocks * grid->lanes; lane++) {
        g->a[lane] += grid->steps * g->a_step[lane];
        g->b[lane] += grid->steps * g->b_step[lane];
    }
    sm_torus_group_advance(grid, g);
    return SM_OK;
}

static sm_status solve_group(const sm_torus_grid hat[2], sm_torus_group *g, size_t first,
                             const sm_torus_points *through, const double *growth,
                             double *harmonics) {
    const int modes = hat->contact->modes;
    const size_t points = through->count;
    const double before = PERIODS_BEFORE + 1.0; /* periods until the amplitudes are as given */
    const size_t per_point = hat->per_point, most = (size_t)hat->points_per_group;
    sm_torus_group_start(hat, g, first, points, through->amplitudes);
    for (int lane = 0; lane < g->blocks * hat->lanes; lane++) {
        size_t point = first + (size_t)(lane / hat->lines);
        point = point < points ? point : points - 1;
        const double *of = growth + point * (size_t)modes;
        g->a_step[lane] = of[0] / hat->steps;
        g->b_step[lane] = modes == 2 ? of[1] / hat->steps : 0.0;
        g->a[lane] -= before * of[0];
        if (modes == 2) g->b[lane] -= before * of[1];
    }
    for (int k = 0; k < PERIODS_BEFORE; k++) {
        const sm_status status = period(hat, g);
        if (status != SM_OK) return status;
    }
    for (int k = 0; k < 2; k++) {
        const sm_status status = period(&hat[k], g);
        if (status != SM_OK) return status;
        for (size_t p = 0; p < most && first + p < points; p++)
            for (size_t i = 0; i < per_point; i++) {
                double *sum = harmonics + (first + p) * per_point + i;
                *sum = g->fresh[p * per_point + i] + (k == 0 ? 0.0 : *sum);
            }
    }
    return SM_OK;
}

sm_status sm_torus_growing(const sm_contact *contact, const sm_discretisation *grid,
                           size_t points, const double *amplitudes, const double *growth,
                           double *harmonics) {
    sm_torus_grid hat[2] = {{.memory = NULL}, {.memory = NULL}};
    sm_torus_group group = {.memory = NULL};
    sm_status status = sm_torus_check(contact, grid);
    if (status == SM_OK)
        status = sm_torus_check_points(contact, points, amplitudes, grid->orders_count);
    if (status == SM_OK)
        status = sm_torus_check_points(contact, points, growth, grid->orders_count);
    if (status != SM_OK) return status;
    if ((points > 0 && !harmonics) || contact->response) return SM_BAD_ARGUMENT;
    const sm_torus_points through = {.count = points, .amplitudes = amplitudes};
    if (contact->law == SM_ELASTIC) {
        const double none[SM_MODES] = {0.0};
        sm_discretisation unscaled = *grid;
        unscaled.smallest_scale = none;
        const sm_torus_motion motion = {.harmonics = harmonics};
        const sm_torus_task task = {&unscaled, &through, &motion};
        return sm_torus_elastic_growing(contact, &task, growth, PERIODS_BEFORE);
    }
    for (int k = 0; k < 2 && status == SM_OK; k++) {
        status = sm_torus_grid_make(&hat[k], contact, grid, points);
        if (status == SM_OK) weigh(&hat[k], k);
    }
    if (status == SM_OK) status = sm_torus_group_make(&group, &hat[0]);
    for (size_t first = 0; first < points && status == SM_OK;
         first += (size_t)hat->points_per_group)
        status = solve_group(hat, &group, first, &through, growth, harmonics);
    sm_torus_group_release(&group);
    sm_torus_grid_release(&hat[1]);
    sm_torus_grid_release(&hat[0]);
    return status;
}

/* Contact motion on the torus under growing amplitudes, for the rate correction R_jk of S_j
 * (docs/theory.md, "Rate correction"); called by Python.
 * With a(t) = a + r t the contacts move by x0(t_A, t_B; a + r t) + r x1(t_A, t_B). In a mean over
 * two periods of mode A around t = 0 with the hat 1 - |t| / period as weight, the change of x0
 * cancels, and the means of (x - x0) exp(-i (n t_A + m t_B)) / r are the harmonics of x1. */
#include "base/check.h"
#include "torus/elastic/elastic_lines.h"
#include "torus/rigid/group.h"

#define PERIODS_BEFORE 2 /* periods from rest to the first one of the mean */

/* ---- rigid contacts ------------------------------------------------------------------------ */

/* Multiplies the weights of a period by one half of the hat: rising, or falling. */
static void apply_hat(sm_torus_grid *grid, int falling) {
    const size_t row = 2 * (size_t)grid->orders_count;
    for (int k = 0; k < grid->steps; k++) {
        const double rising = (k + 1.0) / grid->steps;
        for (size_t q = 0; q < row; q++)
            grid->weight[(size_t)k * row + q] *= falling ? 1.0 - rising : rising;
    }
}

/* Adds the harmonics of the points of a group. */
static sm_status grow_group(sm_march *m, const sm_torus_grid *hat) {
    sm_rigid_lines *r = m->lines;
    const size_t all = r->grid.per_point, left = m->task->points->count - m->first;
    double *harmonics = m->task->motion->harmonics + m->first * all;
    m->law->start(m, NULL);
    for (int k = -PERIODS_BEFORE; k < 2; k++) {
        r->grid = hat[k == 1];
        m->elapsed = k - 1.0;
        SM_TRY(m->law->period(m));
        for (size_t i = 0; k >= 0 && i < (left < m->points ? left : m->points) * all; i++)
            harmonics[i] += m->Y[i];
    }
    return SM_OK;
}

/* Computes the harmonics of all points with rigid contacts, by two grids with a half of the hat. */
static sm_status grow_rigid(sm_march *m, const double *growth) {
    sm_rigid_lines *r = m->lines;
    sm_torus_grid hat[2] = {r->grid, {.memory = NULL}};
    sm_status status =
        sm_torus_grid_make(&hat[1], m->contact, m->task->grid, m->task->points->count);
    for (int k = 0; k < 2 && status == SM_OK; k++) apply_hat(&hat[k], k);
    m->growth = growth;
    for (; m->first < m->task->points->count && status == SM_OK; m->first += m->points)
        status = grow_group(m, hat);
    r->grid = hat[0];
    free(hat[1].memory);
    return status;
}

/* ---- elastic contacts ---------------------------------------------------------------------- */

/* Adds the harmonics of one point with elastic contacts. */
static sm_status grow_elastic_point(sm_march *m, const double *growth, double *harmonics) {
    static const double none[SM_MODES] = {0.0};
    sm_elastic_lines *e = m->lines;
    const size_t modes = (size_t)m->contact->modes, all = sm_march_harmonics(m);
    const double *amplitude = sm_march_amplitudes(m, 0), *by = growth + m->first * modes;
    double now[SM_MODES] = {0.0};
    for (size_t j = 0; j < modes; j++)
        now[j] = fabs(amplitude[j]) + (PERIODS_BEFORE + 1) * fabs(by[j]);
    sm_elastic_lines_start(e, sm_scales_at(m->contact, now, none).response);
    for (int period = -PERIODS_BEFORE - 1; period < 1; period++) {
        sm_phase_lines_clear(&e->lines);
        for (size_t k = 0; k < e->lines.steps; k++) {
            const double elapsed = period + (double)(k + 1) / (double)e->lines.steps; /* periods */
            for (size_t j = 0; j < modes; j++) now[j] = amplitude[j] + elapsed * by[j];
            sm_elastic_lines_displace(e, now, NULL);
            SM_TRY(sm_elastic_lines_step(e, k, 1, fmax(1.0 - fabs(elapsed), 0.0)));
        }
        sm_phase_lines_collect(&e->lines, e->lines.steps, e->Y);
        for (size_t i = 0; i < all; i++) harmonics[i] += e->Y[i];
        sm_phases_turn(&e->lines.phases, e->lines.ratio);
    }
    return sm_all_finite(harmonics, all) ? SM_OK : SM_NOT_FINITE;
}

/* Computes the harmonics of all points with elastic contacts. */
static sm_status grow_elastic(sm_march *m, const double *growth) {
    sm_status status = SM_OK;
    for (; m->first < m->task->points->count && status == SM_OK; m->first++)
        status = grow_elastic_point(
            m, growth, m->task->motion->harmonics + m->first * sm_march_harmonics(m));
    return status;
}

sm_status sm_torus_growing(const sm_contact *contact, const sm_discretisation *grid,
                           size_t points, const double *amplitudes, const double *growth,
                           double *harmonics) {
    SM_TRY(sm_torus_check(contact, grid));
    SM_TRY(sm_torus_check_points(contact, points, amplitudes, grid->orders_count));
    SM_TRY(sm_torus_check_points(contact, points, growth, grid->orders_count));
    if ((points > 0 && !harmonics) || contact->response) return SM_BAD_ARGUMENT;
    const sm_torus_points through = {.count = points, .amplitudes = amplitudes};
    const sm_torus_motion motion = {.harmonics = harmonics};
    sm_discretisation given = *grid;
    given.tolerance = 0.0;
    const sm_torus_task task = {&given, &through, &motion};
    sm_march march = {.contact = contact, .task = &task, .part = 1.0};
    const int elastic = contact->law == SM_ELASTIC;
    sm_status status = elastic ? sm_elastic_make(&march) : sm_rigid_make(&march);
    if (points > 0) memset(harmonics, 0, points * sm_march_harmonics(&march) * sizeof(double));
    if (status == SM_OK)
        status = elastic ? grow_elastic(&march, growth) : grow_rigid(&march, growth);
    march.law->release(&march);
    return status;
}

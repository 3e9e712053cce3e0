/* Amplitudes between two points of a trajectory: whether a cubic has them, and what has else. */
#include <math.h>
#include <string.h>

#include "base/check.h"
#include "slow/slow_flow.h"

/* Parts of a step at which the slopes are compared: not commensurate, so that no beat hides between. */
static const double INSIDE[] = {0.25, 0.6};

/* A step of the trajectory: its inputs move along straight lines. */
typedef struct {
    const sm_slow_flow *flow;
    const sm_inputs *inputs;
} step_flow;

/* dy/dt so many seconds into the step. */
static sm_status rate_at(const step_flow *step, double elapsed, const double *y, double *dy) {
    double powers[2];
    return sm_slow_flow_rate(step->flow, step->inputs, elapsed, y, dy, powers);
}

/* The largest difference of the cubic's slope from the slow flow, times the duration. */
static sm_status bend_of(const step_flow *step, double duration, const double *start,
                         const double *end, double *bend) {
    const int count = 2 * step->flow->table.modes;
    double y[2 * SM_MODES], leaving[2 * SM_MODES], arriving[2 * SM_MODES], rate[2 * SM_MODES];
    sm_status status = rate_at(step, 0.0, start, leaving);
    if (status == SM_OK) status = rate_at(step, duration, end, arriving);
    *bend = 0.0;
    for (int k = 0; k < 2 && status == SM_OK; k++) {
        const double r = INSIDE[k], rest = 1.0 - r, moved = r * r * (3.0 - 2.0 * r);
        for (int u = 0; u < count; u++)
            y[u] = start[u] + moved * (end[u] - start[u])
                   + duration * r * rest * (rest * leaving[u] - r * arriving[u]);
        status = rate_at(step, r * duration, y, rate);
        if (status != SM_OK) break;
        for (int u = 0; u < count; u++) {
            const double slope = rest * (1.0 - 3.0 * r) * leaving[u]
                                 - r * (2.0 - 3.0 * r) * arriving[u];
            const double off = duration * (rate[u] - slope) - 6.0 * r * rest * (end[u] - start[u]);
            *bend = fmax(*bend, fabs(off));
        }
    }
    return status;
}

static sm_status check_steps(const sm_slow_flow *flow, const sm_trajectory_steps *steps) {
    if (!flow || !steps || !steps->inputs || !steps->duration || !steps->start || !steps->end)
        return SM_BAD_ARGUMENT;
    sm_status status = sm_slow_flow_check(flow);
    for (size_t k = 0; k < steps->count && status == SM_OK; k++)
        status = sm_check_positive(steps->duration[k]);
    return status;
}

sm_status sm_trajectory_bend(const sm_slow_flow *flow, const sm_trajectory_steps *steps,
                             double *bend) {
    sm_status status = bend ? check_steps(flow, steps) : SM_BAD_ARGUMENT;
    for (size_t k = 0; status == SM_OK && k < steps->count; k++) {
        const size_t at = k * 2 * (size_t)flow->table.modes;
        const step_flow step = {flow, steps->inputs + k};
        status = bend_of(&step, steps->duration[k], steps->start + at, steps->end + at, bend + k);
        if (status != SM_OUTSIDE_TABLE) continue;
        bend[k] = INFINITY;
        status = SM_OK;
    }
    return status;
}

/* The classical Runge-Kutta method, y after h seconds. */
static sm_status runge_kutta(const step_flow *step, double elapsed, double h, double *y) {
    static const double node[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    const int count = 2 * step->flow->table.modes;
    double trial[2 * SM_MODES], k[2 * SM_MODES] = {0.0}, sum[2 * SM_MODES] = {0.0};
    for (int stage = 0; stage < 4; stage++) {
        for (int u = 0; u < count; u++) trial[u] = y[u] + node[stage] * h * k[u];
        const sm_status status = rate_at(step, elapsed + node[stage] * h, trial, k);
        if (status != SM_OK) return status;
        for (int u = 0; u < count; u++) sum[u] += weight[stage] * k[u];
    }
    for (int u = 0; u < count; u++) y[u] += h / 6.0 * sum[u];
    return SM_OK;
}

sm_status sm_trajectory_divide(const sm_slow_flow *flow, const sm_trajectory_steps *steps,
                               int32_t parts, double *between) {
    sm_status status = between && parts >= 2 ? check_steps(flow, steps) : SM_BAD_ARGUMENT;
    if (status != SM_OK) return status;
    const size_t count = 2 * (size_t)flow->table.modes, inner = (size_t)parts - 1;
    for (size_t k = 0; k < steps->count && status == SM_OK; k++) {
        double *own = between + k * inner * count, y[2 * SM_MODES];
        const step_flow step = {flow, steps->inputs + k};
        const double h = steps->duration[k] / (double)parts, *end = steps->end + k * count;
        memcpy(y, steps->start + k * count, count * sizeof(double));
        for (size_t part = 0; part < (size_t)parts && status == SM_OK; part++) {
            if (part > 0) memcpy(own + (part - 1) * count, y, count * sizeof(double));
            status = runge_kutta(&step, h * (double)part, h, y);
        }
        if (status != SM_OK) break;
        /* it ends where the trajectory does */
        for (size_t part = 1; part < (size_t)parts; part++)
            for (size_t u = 0; u < count; u++)
                own[(part - 1) * count + u] +=
                    (double)part / (double)parts * (end[u] - y[u]);
        if (!sm_all_finite(own, inner * count)) status = SM_NOT_FINITE;
    }
    return status;
}

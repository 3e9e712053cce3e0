/* A time step of the slow flow: the pair 5(4) of Dormand and Prince (1980),
 *   k_p = f(t + c_p h, y + h sum_q w_pq k_q),  y_new = y + h sum_q w_7q k_q,
 * with the error estimate h sum_p e_p k_p. The last stage is the first stage of the next step. The
 * component (component.c) calls it and chooses the step size.
 */
#include <math.h>

#include "base/check.h"
#include "base/lanes.h"
#include "slow/slow_flow.h"

#define STAGES 7

static const double NODE[STAGES] = {0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0};
static const double WEIGHT[STAGES][STAGES - 1] = {
    {0.0},
    {0.2},
    {3.0 / 40.0, 9.0 / 40.0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
    {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}};
static const double ERROR[STAGES] = {71.0 / 57600.0,  0.0,
                                     -71.0 / 16695.0, 71.0 / 1920.0,
                                     -17253.0 / 339200.0, 22.0 / 525.0,
                                     -1.0 / 40.0};

/* Absolute tolerance of an amplitude / (tolerance * range of the table) [-]: the table has a
 * relative error from this part of the range on (docs/theory.md, "Friction functions"). */
#define ABSOLUTE_TOLERANCE 1e-3

/* Returns the estimated error of the amplitudes after the step, relative to the tolerance. The
 * range of the table is proportional to the friction limits. */
SM_INLINE double error_of(const sm_time_step *step, double (*k)[SM_UNKNOWNS], const double *y_new) {
    const sm_table *table = &step->flow->table;
    double e[SM_AMPLITUDES] = {0.0}, largest = 0.0;
    for (int p = 0; p < STAGES; p++)
        for (int u = 0; u < SM_AMPLITUDES; u++) e[u] += ERROR[p] * k[p][u];
    for (int j = 0; j < table->modes; j++) {
        const double *a = y_new + 2 * j, *e_j = e + 2 * j;
        const double range = j == 0 ? table->node_a[table->count_a - 1]
                                    : table->node_b[table->count_b - 1];
        const double modulus = sqrt(a[0] * a[0] + a[1] * a[1]);
        const double allowed = step->tolerance
                               * (modulus + ABSOLUTE_TOLERANCE * step->end.limit_scale * range);
        const double relative = step->h * sqrt(e_j[0] * e_j[0] + e_j[1] * e_j[1]) / allowed;
        if (!isfinite(relative)) return relative;
        largest = fmax(largest, relative);
    }
    return largest;
}

/* Evaluates a stage; `stage` is a literal, so that the sum is unrolled. */
SM_INLINE sm_status add_stage(const sm_time_step *step, int stage, sm_instant *instant,
                              const double *y, double (*k)[SM_UNKNOWNS], double *y_new) {
    const int last = stage == STAGES - 1;
    /* amplitudes at rest become 0: with denormal numbers processors compute slowly */
    const int count = last ? SM_UNKNOWNS : SM_AMPLITUDES; /* no rate depends on energies */
    for (int u = 0; u < count; u++) {
        double sum = 0.0;
        for (int p = 0; p < stage; p++)
            if (WEIGHT[stage][p] != 0.0) sum += WEIGHT[stage][p] * k[p][u];
        const double value = y[u] + step->h * sum;
        y_new[u] = last && u < SM_AMPLITUDES && value * value < SM_TINY ? 0.0 : value;
    }
    if (NODE[stage] == 1.0)
        sm_instant_set(instant, step->flow, &step->end);
    else
        sm_instant_advance(instant, step->flow, step->inputs,
                           step->elapsed + NODE[stage] * step->h);
    return sm_slow_flow_derivative(step->flow, instant, y_new, k[stage]);
}

SM_HOT_ONE sm_status sm_dopri5(const sm_time_step *step, sm_instant *instant,
                               const sm_flow_point *start, sm_flow_point *end, double *error) {
    const double *y = start->y;
    double k[STAGES][SM_UNKNOWNS];
    memcpy(k[0], start->dy, sizeof k[0]);
    SM_TRY(add_stage(step, 1, instant, y, k, end->y));
    SM_TRY(add_stage(step, 2, instant, y, k, end->y));
    SM_TRY(add_stage(step, 3, instant, y, k, end->y));
    SM_TRY(add_stage(step, 4, instant, y, k, end->y));
    SM_TRY(add_stage(step, 5, instant, y, k, end->y));
    SM_TRY(add_stage(step, 6, instant, y, k, end->y));
    memcpy(end->dy, k[STAGES - 1], sizeof end->dy);
    *error = error_of(step, k, end->y);
    return SM_OK;
}

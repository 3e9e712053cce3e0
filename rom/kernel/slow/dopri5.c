/* A step of the slow flow: Dormand and Prince 1980, the 5(4) pair with first-same-as-last. */
#include <math.h>

#include "base/lanes.h"
#include "slow/slow_flow.h"

#define STAGES 7
#define AMPLITUDES (2 * SM_MODES) /* the first of the unknowns */

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

#define PAIR 2 /* unknowns side by side: as derivatives are written, so that no load waits */

/* Unknowns from `first` to before `end`: y + h sum of the stages so far, `count` of them.
 * `count`, `first` and `end` are literals. */
SM_INLINE void move(const double *y, double h, double (*k)[SM_UNKNOWNS], int count, int first,
                    int end, double *y_new) {
    for (int pair = first; pair < end; pair += PAIR) {
        SM_SIMD
        for (int u = pair; u < pair + PAIR; u++) {
            double sum = 0.0;
            for (int p = 0; p < count; p++)
                if (WEIGHT[count][p] != 0.0) sum += WEIGHT[count][p] * k[p][u];
            const double moved = y[u] + h * sum;
            /* the square of a smaller amplitude is a denormal, which is slow */
            y_new[u] = count == STAGES - 1 && fabs(moved) < 1e-140 ? 0.0 : moved;
        }
    }
}

/* Estimated error of the amplitudes after the step, relative to the tolerance. The range of the
 * table goes with the friction limits. */
SM_INLINE double error_of(const sm_table *table, double limit_scale, double h, double tolerance,
                          double (*k)[SM_UNKNOWNS], const double *y_new) {
    const double range[SM_MODES] = {table->node_a[table->count_a - 1],
                                    table->modes == SM_MODES ? table->node_b[table->count_b - 1]
                                                             : 0.0};
    double e[AMPLITUDES] = {0.0}, largest = 0.0;
    for (int p = 0; p < STAGES; p++)
        for (int u = 0; u < AMPLITUDES; u++) e[u] += ERROR[p] * k[p][u];
    for (int j = 0; j < table->modes; j++) {
        const double *a = y_new + 2 * j, *e_j = e + 2 * j;
        const double modulus = sqrt(a[0] * a[0] + a[1] * a[1]);
        const double scale = tolerance * (modulus + 1e-3 * limit_scale * range[j]);
        const double relative = h * sqrt(e_j[0] * e_j[0] + e_j[1] * e_j[1]) / scale;
        if (!isfinite(relative)) return relative;
        largest = fmax(largest, relative);
    }
    return largest;
}

/* A step over h that starts `elapsed` seconds after the inputs do, and its stages so far. */
typedef struct {
    const sm_slow_flow *flow;
    const sm_inputs *inputs, *end;
    double elapsed, h;
    int held; /* the inputs move their angles alone */
    sm_instant *instant;
    const double *y;
    double (*k)[SM_UNKNOWNS];
} attempt;

SM_INLINE void set_instant(const attempt *step, int stage) {
    const double later = step->elapsed + NODE[stage] * step->h;
    if (NODE[stage] == 1.0) {
        sm_instant_set(step->instant, step->flow, step->end);
    } else if (step->held) {
        sm_instant_advance(step->instant, step->flow, step->inputs, later);
    } else {
        const sm_inputs now = sm_inputs_after(step->inputs, step->flow->table.modes, later);
        sm_instant_set(step->instant, step->flow, &now);
    }
}

/* `stage` is a literal. */
SM_INLINE sm_status add_stage(const attempt *step, int stage, double *y_new) {
    set_instant(step, stage);
    move(step->y, step->h, step->k, stage, 0, AMPLITUDES, y_new);
    return sm_slow_flow_derivative_at(step->flow, step->instant, y_new, step->k[stage]);
}

SM_HOT_ONE sm_status sm_slow_flow_dopri5(const sm_slow_flow *flow, const sm_inputs *inputs,
                                      double elapsed, double h, const sm_inputs *end,
                                      double tolerance, sm_instant *instant, const double *y,
                                      const double *dy, double *y_new, double *dy_new,
                                      double *error) {
    double k[STAGES][SM_UNKNOWNS];
    for (int u = 0; u < SM_UNKNOWNS; u++) k[0][u] = dy[u];
    const attempt step = {flow, inputs, end, elapsed, h, sm_instant_holds(instant, inputs),
                          instant, y, k};
    sm_status status = add_stage(&step, 1, y_new);
    if (status == SM_OK) status = add_stage(&step, 2, y_new);
    if (status == SM_OK) status = add_stage(&step, 3, y_new);
    if (status == SM_OK) status = add_stage(&step, 4, y_new);
    if (status == SM_OK) status = add_stage(&step, 5, y_new);
    if (status == SM_OK) status = add_stage(&step, 6, y_new);
    if (status != SM_OK) return status;
    move(y, h, k, STAGES - 1, AMPLITUDES, SM_UNKNOWNS, y_new); /* no rate depends on these */
    *error = error_of(&flow->table, end->limit_scale, h, tolerance, k, y_new);
    for (int u = 0; u < SM_UNKNOWNS; u++) dy_new[u] = k[STAGES - 1][u];
    return SM_OK;
}

/* How the rates and powers of the slow flow change with amplitudes and inputs. */
#include <math.h>

#include "base/check.h"
#include "slow/first_order.h"
#include "slow/slow_flow.h"
#include "table/table.h"

#define FAR 1e-5 /* of a difference, relative to the range of what changes */

/* A point and a direction through it. */
typedef struct {
    const sm_slow_flow *flow;
    sm_inputs at, along;
    double y[2 * SM_MODES], dy[2 * SM_MODES];
} straight_line;

/* The rates at a point of the ray, and v' and the rate correction there. */
typedef struct {
    sm_instant instant;
    sm_flow_state state;
    sm_flow_change flow; /* along the flow */
} ray_point;

static sm_inputs sum_of(const sm_inputs *at, double distance, const sm_inputs *along) {
    sm_inputs sum = *at;
    double *value = (double *)(void *)&sum;
    const double *change = (const double *)(const void *)along;
    for (size_t k = 0; k < sizeof sum / sizeof *value; k++) value[k] += distance * change[k];
    return sum;
}

static sm_status point_at(const straight_line *ray, double distance, ray_point *point) {
    const sm_inputs inputs = sum_of(&ray->at, distance, &ray->along);
    double y[2 * SM_MODES];
    for (int k = 0; k < 2 * SM_MODES; k++) y[k] = ray->y[k] + distance * ray->dy[k];
    point->instant = (sm_instant){.known = 0};
    sm_instant_set(&point->instant, ray->flow, &inputs);
    const sm_status status = sm_first_order(ray->flow, &point->instant, 1, y, &point->state);
    if (status == SM_OK)
        sm_change_along_flow(ray->flow, &point->instant, &point->state, &point->flow);
    return status;
}

/* Distance along the ray over which nothing changes by more than FAR of its range. */
static double short_distance(const straight_line *ray) {
    const sm_table *table = &ray->flow->table;
    const double range[SM_MODES] = {table->node_a[table->count_a - 1],
                                    table->modes == SM_MODES ? table->node_b[table->count_b - 1]
                                                             : 1.0};
    double size = fabs(ray->along.limit_scale) / ray->at.limit_scale;
    for (int j = 0; j < table->modes; j++) {
        const double natural = ray->flow->natural[j];
        const double sizes[] = {hypot(ray->dy[2 * j], ray->dy[2 * j + 1]) / range[j],
                                fabs(ray->along.force[j]) / (natural * natural * range[j]),
                                fabs(ray->along.frequency[j]) / ray->at.frequency[j],
                                fabs(ray->along.phase[j]), fabs(ray->along.angle[j])};
        for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) size = fmax(size, sizes[k]);
    }
    return size > 0.0 ? FAR / size : 1.0; /* all the rest is at most quadratic */
}

/* Changes of v' and of the rate correction along the ray: v' would take second derivatives of the
 * table, and being small against v they are taken from a central difference; one-sided at the
 * table's very edge. */
static sm_status change_of_bend(const straight_line *ray, const ray_point *here,
                                sm_flow_change *change) {
    const double distance = short_distance(ray);
    ray_point ahead = *here, behind = *here;
    const sm_status forth = point_at(ray, distance, &ahead);
    const sm_status back = point_at(ray, -distance, &behind);
    if (forth != SM_OK && back != SM_OK) return forth;
    if (forth != SM_OK) ahead = *here;
    if (back != SM_OK) behind = *here;
    const double length = distance * ((forth == SM_OK) + (back == SM_OK));
    for (int j = 0; j < ray->flow->table.modes; j++) {
        const sm_complex rate = sm_csub(sm_of(&ahead.flow.rate, j), sm_of(&behind.flow.rate, j));
        const sm_complex rate_correction =
            sm_csub(sm_of(&ahead.flow.rate_correction, j), sm_of(&behind.flow.rate_correction, j));
        sm_put(&change->rate, j, sm_cscale(rate, 1.0 / length));
        sm_put(&change->rate_correction, j, sm_cscale(rate_correction, 1.0 / length));
    }
    return SM_OK;
}

/* Change along the ray of what friction takes, see sm_friction_power. */
static double change_of_friction(const straight_line *ray, const ray_point *here,
                                 const sm_flow_change *change, const sm_modal *correction_change) {
    const sm_slow_flow *flow = ray->flow;
    const double scale = ray->at.limit_scale;
    double power = 0.0;
    const sm_modal *rate_correction = &here->flow.rate_correction;
    if (flow->table.power
        && sm_friction_power(flow, &here->instant, &here->state, rate_correction) == 0.0)
        return 0.0; /* its lower limit */
    for (int j = 0; j < flow->table.modes; j++) {
        const sm_complex a = sm_conj(sm_of(&here->state.effective.amplitude, j));
        const sm_complex da = sm_cx(ray->dy[2 * j], -ray->dy[2 * j + 1]);
        const sm_complex force = sm_cadd(sm_of(&here->state.force, j), sm_of(rate_correction, j));
        const sm_complex d_force = sm_cadd(sm_of(&change->force, j), sm_of(correction_change, j));
        power -= 2.0 * ray->along.frequency[j] * sm_cmul(a, force).im
                 + 2.0 * ray->at.frequency[j] * (sm_cmul(da, force).im + sm_cmul(a, d_force).im);
    }
    if (flow->table.power)
        power += scale * scale * change->difference
                 + 2.0 * scale * ray->along.limit_scale
                       * here->state.slopes[2 * (flow->table.modes + flow->table.combinations)];
    return power;
}

/* Mean of F cos(theta + ph) q' is Re conj(excitation) (a' + i Omega a). */
static double change_of_input(const straight_line *ray, const ray_point *here, int j,
                              sm_complex excitation, sm_complex rate, sm_complex change) {
    const sm_complex a = sm_of(&here->state.effective.amplitude, j);
    const sm_complex da = sm_cx(ray->dy[2 * j], ray->dy[2 * j + 1]);
    const double Omega = ray->at.frequency[j], dOmega = ray->along.frequency[j];
    const sm_complex velocity = sm_cx(rate.re - Omega * a.im, rate.im + Omega * a.re);
    const sm_complex faster = sm_cx(change.re - Omega * da.im - dOmega * a.im,
                                    change.im + Omega * da.re + dOmega * a.re);
    return sm_cmul(sm_conj(excitation), velocity).re
           + sm_cmul(sm_conj(sm_of(&here->instant.now.excitation, j)), faster).re;
}

static sm_status change_along(const straight_line *ray, double *d_rate, double *d_input_power,
                              double *d_friction_power) {
    const sm_slow_flow *flow = ray->flow;
    ray_point here;
    sm_coefficients now;
    sm_modal ahead;
    double combination_angle[SM_COMBINATIONS];
    sm_flow_change bend = {.difference = 0.0};
    sm_status status = point_at(ray, 0.0, &here);
    if (status == SM_OK && !flow->paper) status = change_of_bend(ray, &here, &bend);
    if (status != SM_OK) return status;
    const sm_direction along = {.amplitude = &ahead,
                                .now = &now,
                                .combination_angle = combination_angle,
                                .limit_scale = ray->along.limit_scale};
    for (int j = 0; j < flow->table.modes; j++)
        sm_put(&ahead, j, sm_cx(ray->dy[2 * j], ray->dy[2 * j + 1]));
    sm_coefficients_change(flow, &here.instant, &ray->along, &now);
    for (int k = 0; k < flow->table.combinations; k++)
        combination_angle[k] = sm_combination_angle(&flow->combination[k], ray->along.angle);
    sm_flow_change change;
    sm_first_order_change(flow, &here.instant, &here.state, &along, &change);
    *d_input_power = 0.0;
    *d_friction_power = change_of_friction(ray, &here, &change, &bend.rate_correction);
    for (int j = 0; j < flow->table.modes; j++) {
        const sm_complex per_mass = sm_of(&here.instant.per_mass, j);
        sm_complex rate = sm_of(&here.state.rate, j), d = sm_of(&change.rate, j);
        if (!flow->paper) { /* of v - (v' - rate correction) / mass */
            const sm_complex bent =
                sm_csub(sm_of(&here.flow.rate, j), sm_of(&here.flow.rate_correction, j));
            const sm_complex d_bent =
                sm_csub(sm_of(&bend.rate, j), sm_of(&bend.rate_correction, j));
            const sm_complex less = sm_cmul(bent, per_mass);
            const sm_complex d_less =
                sm_cmul(sm_csub(d_bent, sm_cmul(less, sm_of(&now.mass, j))), per_mass);
            rate = sm_csub(rate, less);
            d = sm_csub(d, d_less);
        }
        d_rate[2 * j] = d.re;
        d_rate[2 * j + 1] = d.im;
        *d_input_power += change_of_input(ray, &here, j, sm_of(&now.excitation, j), rate, d);
    }
    return SM_OK;
}

sm_status sm_slow_flow_directional(const sm_slow_flow *flow, const sm_inputs *inputs,
                                   double elapsed, const double *amplitude,
                                   const double *d_amplitude, const sm_inputs *d_inputs,
                                   double *d_rate, double *d_input_power,
                                   double *d_friction_power) {
    if (!flow || !inputs || !amplitude || !d_amplitude || !d_inputs || !d_rate || !d_input_power ||
        !d_friction_power)
        return SM_BAD_ARGUMENT;
    straight_line ray = {.flow = flow};
    sm_status status = sm_slow_flow_check_at(flow, inputs, elapsed, &ray.at);
    if (status != SM_OK) return status;
    const int modes = flow->table.modes;
    ray.along = sm_inputs_after(d_inputs, modes, elapsed); /* it is linear in the inputs */
    for (int k = 0; k < 2 * modes; k++) {
        ray.y[k] = amplitude[k];
        ray.dy[k] = d_amplitude[k];
    }
    double rate[2 * SM_MODES] = {0.0}, power[2];
    status = change_along(&ray, rate, &power[0], &power[1]);
    if (status != SM_OK) return status;
    if (!sm_all_finite(rate, 2 * SM_MODES) || !sm_all_finite(power, 2)) return SM_NOT_FINITE;
    for (int k = 0; k < 2 * modes; k++) d_rate[k] = rate[k];
    *d_input_power = power[0];
    *d_friction_power = power[1];
    return SM_OK;
}

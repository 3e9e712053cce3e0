/* Periodic contact motion on the torus, eq. (13), by characteristics.
 *
 * Along t_B = t_B0 + (omega_B / omega_A) t_A the partial differential equation is ordinary.
 * `lines` phase lines with t_B0 = 2 pi p / lines are marched period by period of mode A, side by
 * side in lanes; P_nm is the plain mean of x exp(-i (n t_A + m t_B)) over steps and lines,
 * spectrally accurate in t_B. The march ends when the harmonics repeat.
 */
#include <stdlib.h>

#include "acceleration.h"
#include "check.h"
#include "contact.h"
#include "periodicity.h"

#define MAX_STEPS 65536
#define MAX_LINES 4096
#define MAX_ORDER 65536 /* of a harmonic: no grid resolves more */
#define MAX_ORDERS_COUNT 4096
#define TWO_PI 6.283185307179586

/* Angles that all points share. */
typedef struct {
    int steps, lines, points_per_group, orders_count;
    size_t per_point;           /* doubles: orders, N_c, 2 */
    const int32_t *orders;
    double ratio;               /* omega_B / omega_A */
    double *carrier;            /* (steps, 2 stages, cos A, sin A, cos B', sin B') */
    double *weight;             /* (steps, orders, 2): exp(-i (n + m ratio) t_A) / steps */
} torus_grid;

/* One group: the lanes of one point, or of several points when lines < SM_LANES. */
typedef struct {
    int blocks;                 /* lanes of the group / SM_LANES */
    sm_lanes *lanes;            /* (blocks) */
    double *a, *b;              /* (blocks * SM_LANES) amplitudes of each lane */
    double *phase;              /* (blocks * SM_LANES, 2) cos and sin of t_B at t_A = 0 */
    double *sums;               /* (blocks, orders, N_c, 2, SM_LANES) */
    double *fresh, *last;       /* (points_per_group, orders, N_c, 2) */
    sm_progress *track;         /* (points_per_group) */
    sm_acceleration *faster;    /* (points_per_group) */
    double *line_state;         /* (N_c + 2, lines): x, cos and sin of t_B of one point's lines */
} torus_group;

static void fill_grid(torus_grid *grid) {
    for (int k = 0; k < grid->steps; k++) {
        for (int stage = 0; stage < 2; stage++) {
            const double t = TWO_PI * (k + (stage == 0 ? SM_GAMMA : 1.0)) / grid->steps;
            double *c = grid->carrier + (k * 2 + stage) * 4;
            c[0] = cos(t);
            c[1] = sin(t);
            c[2] = cos(grid->ratio * t);
            c[3] = sin(grid->ratio * t);
        }
        const double t = TWO_PI * (k + 1) / grid->steps;
        for (int q = 0; q < grid->orders_count; q++) {
            const double angle = (grid->orders[2 * q] + grid->orders[2 * q + 1] * grid->ratio) * t;
            double *w = grid->weight + (k * grid->orders_count + q) * 2;
            w[0] = cos(angle) / grid->steps;
            w[1] = -sin(angle) / grid->steps;
        }
    }
}

/* u = -2 Re sum_j L_j a_j exp(i t_j) in every lane. */
SM_INLINE void load_forcing(const int lanes, const sm_contact *contact, const double *carrier,
                            const double *restrict a, const double *restrict b,
                            const double *restrict phase, double *restrict u) {
    const int n = contact->contacts;
    for (int i = 0; i < n; i++) {
        const double *L = contact->coupling + 2 * i;
        const double from_a = -2.0 * (L[0] * carrier[0] - L[1] * carrier[1]);
        SM_SIMD
        for (int l = 0; l < lanes; l++) u[i * lanes + l] = from_a * a[l];
        if (contact->modes == 1) continue;
        L = contact->coupling + 2 * (n + i);
        /* Re(L exp(i (t_B0 + ratio t_A))) = p cos t_B0 - q sin t_B0 */
        const double p = -2.0 * (L[0] * carrier[2] - L[1] * carrier[3]);
        const double q = -2.0 * (L[1] * carrier[2] + L[0] * carrier[3]);
        SM_SIMD
        for (int l = 0; l < lanes; l++)
            u[i * lanes + l] += b[l] * (p * phase[l] - q * phase[lanes + l]);
    }
}

/* One period of mode A for one block of lanes; adds to the sums. */
SM_HOT static sm_status march_period(const sm_contact *contact, const sm_stepper *stepper,
                                     const torus_grid *grid, sm_lanes *m, const double *a,
                                     const double *b, const double *phase, double *sums) {
    const int n = contact->contacts;
    for (int k = 0; k < grid->steps; k++) {
        for (int stage = 0; stage < 2; stage++) {
            load_forcing(SM_LANES, contact, grid->carrier + (k * 2 + stage) * 4, a, b, phase, m->u);
            const sm_status status = sm_stage(SM_LANES, stepper, m, stage);
            if (status != SM_OK) return status;
        }
        for (int q = 0; q < grid->orders_count; q++) {
            const double re = grid->weight[(k * grid->orders_count + q) * 2];
            const double im = grid->weight[(k * grid->orders_count + q) * 2 + 1];
            for (int i = 0; i < n; i++) {
                double *restrict sum = sums + ((size_t)q * n + i) * 2 * SM_LANES;
                const double *restrict x = m->x + (size_t)i * SM_LANES;
                SM_SIMD
                for (int l = 0; l < SM_LANES; l++) {
                    sum[l] += re * x[l];
                    sum[SM_LANES + l] += im * x[l];
                }
            }
        }
    }
    return SM_OK;
}

/* exp(-i m angle) from (cos, sin) of the angle, for a small integer m. */
static void power(double c, double s, int m, double *re, double *im) {
    const double sign = m < 0 ? 1.0 : -1.0;
    double pr = 1.0, pi = 0.0;
    for (int k = 0; k < abs(m); k++) {
        const double t = pr * c - pi * sign * s;
        pi = pr * sign * s + pi * c;
        pr = t;
    }
    *re = pr;
    *im = pi;
}

/* Mean over lines: fresh = sum over lanes of sums exp(-i m t_B0) / lines. */
static void collect(const sm_contact *contact, const torus_grid *grid, torus_group *g) {
    const int n = contact->contacts;
    memset(g->fresh, 0, sizeof(double) * (size_t)grid->points_per_group * grid->per_point);
    for (int lane = 0; lane < g->blocks * SM_LANES; lane++) {
        const int block = lane / SM_LANES, l = lane % SM_LANES;
        double *point = g->fresh + (size_t)(lane / grid->lines) * grid->per_point;
        const double *phase = g->phase + (size_t)block * 2 * SM_LANES;
        for (int q = 0; q < grid->orders_count; q++) {
            double re, im;
            power(phase[l], phase[SM_LANES + l], grid->orders[2 * q + 1], &re, &im);
            for (int i = 0; i < n; i++) {
                const double *sum = g->sums + ((((size_t)block * grid->orders_count + q) * n + i) * 2)
                                                  * SM_LANES + l;
                point[(q * n + i) * 2] += (re * sum[0] - im * sum[SM_LANES]) / grid->lines;
                point[(q * n + i) * 2 + 1] += (re * sum[SM_LANES] + im * sum[0]) / grid->lines;
            }
        }
    }
}

static void start_group(const sm_contact *contact, const torus_grid *grid, torus_group *g,
                        size_t first, size_t points, const double *amplitudes) {
    const size_t lanes_size = sm_lanes_size(contact->contacts, SM_LANES);
    for (int block = 0; block < g->blocks; block++)
        memset(g->lanes[block].x, 0, lanes_size * sizeof(double));
    for (int lane = 0; lane < g->blocks * SM_LANES; lane++) {
        const int block = lane / SM_LANES, l = lane % SM_LANES;
        size_t point = first + (size_t)(lane / grid->lines);
        point = point < points ? point : points - 1; /* spare lanes repeat the last point */
        const double t_b0 = TWO_PI * (lane % grid->lines) / grid->lines;
        g->a[lane] = amplitudes[point * (size_t)contact->modes];
        g->b[lane] = contact->modes == 2 ? amplitudes[point * 2 + 1] : 0.0;
        g->phase[block * 2 * SM_LANES + l] = cos(t_b0);
        g->phase[(block * 2 + 1) * SM_LANES + l] = sin(t_b0);
    }
}

static void rotate_phases(const torus_grid *grid, torus_group *g) {
    const double c = cos(TWO_PI * grid->ratio), s = sin(TWO_PI * grid->ratio);
    for (int block = 0; block < g->blocks; block++) {
        double *pc = g->phase + (size_t)block * 2 * SM_LANES, *ps = pc + SM_LANES;
        for (int l = 0; l < SM_LANES; l++) {
            const double t = pc[l] * c - ps[l] * s;
            ps[l] = pc[l] * s + ps[l] * c;
            pc[l] = t;
        }
    }
}

/* Copies the lanes of point p of the group into line_state, or back. */
static void exchange_lines(const torus_grid *grid, torus_group *g, int contacts, size_t p,
                           int back) {
    double *x = g->line_state, *angle = x + (size_t)contacts * (size_t)grid->lines;
    for (int line = 0; line < grid->lines; line++) {
        const size_t lane = p * (size_t)grid->lines + (size_t)line;
        const size_t block = lane / SM_LANES, l = lane % SM_LANES;
        for (int i = 0; i < contacts; i++) {
            double *in_lane = g->lanes[block].x + (size_t)i * SM_LANES + l;
            double *in_line = x + (size_t)i * (size_t)grid->lines + line;
            *(back ? in_lane : in_line) = *(back ? in_line : in_lane);
        }
        angle[line] = g->phase[block * 2 * SM_LANES + l];
        angle[grid->lines + line] = g->phase[(block * 2 + 1) * SM_LANES + l];
    }
}

/* After the phases have turned: move the lines of unfinished points closer to periodicity. */
static void accelerate(const torus_grid *grid, torus_group *g, int contacts, size_t points) {
    const double *angle = g->line_state + (size_t)contacts * (size_t)grid->lines;
    for (size_t p = 0; p < points; p++) {
        if (g->track[p].done) continue;
        exchange_lines(grid, g, contacts, p, 0);
        if (sm_accelerate(&g->faster[p], angle, angle + grid->lines, g->line_state)) {
            exchange_lines(grid, g, contacts, p, 1);
            g->track[p].change = 0.0; /* what follows does not continue the series */
        }
    }
}

static sm_status solve_group(const sm_contact *contact, const sm_stepper *stepper,
                             const torus_grid *grid, torus_group *g, size_t first, size_t points,
                             const double *amplitudes, double tolerance,
                             const double *smallest_scale, int max_periods, double *harmonics,
                             double *residual, int32_t *periods) {
    const int n = contact->contacts;
    const size_t per_point = grid->per_point;
    const size_t group_points =
        points - first < (size_t)grid->points_per_group ? points - first
                                                        : (size_t)grid->points_per_group;
    start_group(contact, grid, g, first, points, amplitudes);
    for (size_t p = 0; p < group_points; p++) {
        sm_progress_start(&g->track[p]);
        sm_acceleration_start(&g->faster[p]);
    }
    for (int period = 1; period <= max_periods; period++) {
        memset(g->sums, 0, sizeof(double) * (size_t)g->blocks * SM_LANES * per_point);
        for (int block = 0; block < g->blocks; block++) {
            const size_t at = (size_t)block * SM_LANES;
            const sm_status status = march_period(
                contact, stepper, grid, &g->lanes[block], g->a + at, g->b + at, g->phase + 2 * at,
                g->sums + at * per_point);
            if (status != SM_OK) return status;
        }
        collect(contact, grid, g);
        if (!sm_all_finite(g->fresh, group_points * per_point)) return SM_NOT_FINITE;
        int open = 0;
        for (size_t p = 0; p < group_points; p++) {
            const size_t point = first + p;
            double *fresh = g->fresh + p * per_point;
            double *last = g->last + p * per_point;
            if (g->track[p].done) continue; /* its answer is already stored */
            const sm_scales scales = sm_displacement_scales(
                contact, amplitudes + point * (size_t)contact->modes, smallest_scale);
            residual[point] = sm_distance_from_periodic(
                &g->track[p], &scales, n, grid->orders_count, grid->orders, fresh, last,
                period == 1, tolerance);
            memcpy(last, fresh, sizeof(double) * per_point);
            memcpy(harmonics + point * per_point, fresh, sizeof(double) * per_point);
            periods[point] = period;
            open |= !g->track[p].done;
        }
        if (!open) break;
        rotate_phases(grid, g);
        accelerate(grid, g, n, group_points);
    }
    return SM_OK;
}

static size_t take(size_t *total, size_t doubles) {
    const size_t at = *total;
    *total += (doubles + 7) & ~(size_t)7; /* whole cache lines */
    return at;
}

static sm_status check_grid(int32_t steps, int32_t lines, int32_t max_periods,
                            int32_t orders_count, const int32_t *orders) {
    if (steps < 4 || steps > MAX_STEPS || max_periods < 1) return SM_BAD_ARGUMENT;
    if (lines < 1 || lines > MAX_LINES || (lines & (lines - 1)) != 0) return SM_BAD_ARGUMENT;
    if (!orders || orders_count < 1 || orders_count > MAX_ORDERS_COUNT) return SM_BAD_ARGUMENT;
    for (int32_t k = 0; k < 2 * orders_count; k++)
        if (orders[k] < -MAX_ORDER || orders[k] > MAX_ORDER) return SM_BAD_ARGUMENT;
    return SM_OK;
}

static sm_status check_rates(const sm_contact *contact, const double *rates,
                             const double *smallest_scale) {
    if (!rates || !smallest_scale) return SM_BAD_ARGUMENT;
    for (int j = 0; j < contact->modes; j++) {
        sm_status status = sm_check_positive(rates[j]);
        if (status == SM_OK) status = sm_check_not_negative(smallest_scale[j]);
        if (status != SM_OK) return status;
    }
    const double ratio = contact->modes == 2 ? rates[1] / rates[0] : 0.0;
    return isfinite(ratio * MAX_ORDER) ? SM_OK : SM_NOT_FINITE;
}

static sm_status check_points(const sm_contact *contact, size_t points, const double *amplitudes,
                              size_t per_point) {
    if (!sm_fits(points, per_point * sizeof(double))) return SM_BAD_ARGUMENT;
    if (points > 0 && !amplitudes) return SM_BAD_ARGUMENT;
    for (size_t k = 0; k < points * (size_t)contact->modes; k++) {
        const sm_status status = sm_check_not_negative(amplitudes[k]);
        if (status != SM_OK) return status;
    }
    return SM_OK;
}

sm_status sm_torus_harmonics(const sm_contact *contact, const double *rates, int32_t steps,
                             int32_t lines, double tolerance, const double *smallest_scale,
                             int32_t max_periods, size_t points, const double *amplitudes,
                             int32_t orders_count, const int32_t *orders, double *harmonics,
                             double *residual, int32_t *periods) {
    sm_status status = sm_contact_check(contact);
    if (status == SM_OK) status = check_grid(steps, lines, max_periods, orders_count, orders);
    if (status == SM_OK) status = sm_check_not_negative(tolerance);
    if (status == SM_OK) status = check_rates(contact, rates, smallest_scale);
    if (status != SM_OK) return status;
    const int n = contact->contacts;
    const size_t per_point = (size_t)orders_count * (size_t)n * 2;
    status = check_points(contact, points, amplitudes, per_point);
    if (status != SM_OK) return status;
    if (points > 0 && (!harmonics || !residual || !periods)) return SM_BAD_ARGUMENT;
    const int blocks = lines > SM_LANES ? lines / SM_LANES : 1;
    torus_grid grid = {.steps = steps,
                       .lines = lines,
                       .points_per_group = blocks * SM_LANES / lines,
                       .orders_count = orders_count,
                       .per_point = per_point,
                       .orders = orders,
                       .ratio = contact->modes == 2 ? rates[1] / rates[0] : 0.0};
    torus_group g = {.blocks = blocks};
    sm_stepper stepper;

    const size_t per_group = (size_t)grid.points_per_group * per_point;
    const size_t lanes_size = (sm_lanes_size(n, SM_LANES) + 7) & ~(size_t)7;
    const size_t wide = (size_t)blocks * SM_LANES;
    size_t total = 0;
    const size_t at_carrier = take(&total, (size_t)steps * 8);
    const size_t at_weight = take(&total, (size_t)steps * (size_t)orders_count * 2);
    const size_t at_stepper = take(&total, sm_stepper_size(n));
    const size_t at_lanes = take(&total, lanes_size * (size_t)blocks);
    const size_t at_a = take(&total, wide), at_b = take(&total, wide);
    const size_t at_phase = take(&total, 2 * wide);
    const size_t at_sums = take(&total, wide * per_point);
    const size_t at_fresh = take(&total, per_group), at_last = take(&total, per_group);
    const size_t speed = sm_acceleration_size(n, lines);
    const size_t at_speed = take(&total, speed * (size_t)grid.points_per_group);
    const size_t at_line = take(&total, (size_t)(n + 2) * (size_t)lines);
    double *memory = calloc(total, sizeof(double));
    g.faster = calloc((size_t)grid.points_per_group, sizeof(sm_acceleration));
    g.lanes = calloc((size_t)blocks, sizeof(sm_lanes));
    g.track = calloc((size_t)grid.points_per_group, sizeof(sm_progress));
    if (!memory || !g.lanes || !g.track) {
        free(memory);
        free(g.lanes);
        free(g.track);
        return SM_NO_MEMORY;
    }
    grid.carrier = memory + at_carrier;
    grid.weight = memory + at_weight;
    g.a = memory + at_a;
    g.b = memory + at_b;
    g.phase = memory + at_phase;
    g.sums = memory + at_sums;
    g.fresh = memory + at_fresh;
    g.last = memory + at_last;
    g.line_state = memory + at_line;
    for (int p = 0; p < grid.points_per_group; p++)
        sm_acceleration_place(&g.faster[p], n, lines, memory + at_speed + speed * (size_t)p);
    for (int block = 0; block < blocks; block++)
        sm_lanes_place(&g.lanes[block], n, SM_LANES, memory + at_lanes + lanes_size * (size_t)block);
    sm_stepper_place(&stepper, n, memory + at_stepper);
    status = sm_stepper_set(&stepper, contact, TWO_PI / (rates[0] * steps));
    fill_grid(&grid);

    for (size_t first = 0; first < points && status == SM_OK;
         first += (size_t)grid.points_per_group)
        status = solve_group(contact, &stepper, &grid, &g, first, points, amplitudes, tolerance,
                             smallest_scale, max_periods, harmonics, residual, periods);
    free(memory);
    free(g.lanes);
    free(g.track);
    return status;
}

/* Periodic contact motion on the torus, eq. (13), by characteristics.
 *
 * Along t_B = t_B0 + (omega_B / omega_A) t_A the partial differential equation is ordinary.
 * `lines` phase lines with t_B0 = 2 pi p / lines are marched period by period of mode A, side by
 * side in lanes; P_nm is the plain mean of x exp(-i (n t_A + m t_B)) over steps and lines,
 * spectrally accurate in t_B. The march ends when the harmonics repeat.
 */
#include <stdlib.h>

#include "contact.h"

#define TWO_PI 6.283185307179586

/* Angles that all points share. */
typedef struct {
    int steps, lines, points_per_group, orders_count;
    const int32_t *orders;
    double ratio;               /* omega_B / omega_A */
    double *carrier;            /* (steps, 2 stages, cos A, sin A, cos B', sin B') */
    double *weight;             /* (steps, orders, 2): exp(-i (n + m ratio) t_A) / steps */
} torus_grid;

/* How the harmonics of one point settle from period to period. */
typedef struct {
    double change;              /* last change, relative to the displacement scale */
    double best;                /* smallest change so far */
    int idle;                   /* periods since `best` last fell noticeably */
    int done;
} progress;

/* Periods without progress after which a change is put down to the discretisation: phases drift
 * from period to period, so the harmonics of a coarse grid keep moving by its error. */
#define IDLE_PERIODS 12
#define PROGRESS 0.8

/* One group: the lanes of one point, or of several points when lines < SM_LANES. */
typedef struct {
    int blocks;                 /* lanes of the group / SM_LANES */
    sm_lanes *lanes;            /* (blocks) */
    double *a, *b;              /* (blocks * SM_LANES) amplitudes of each lane */
    double *phase;              /* (blocks * SM_LANES, 2) cos and sin of t_B at t_A = 0 */
    double *sums;               /* (blocks, orders, N_c, 2, SM_LANES) */
    double *fresh, *last;       /* (points_per_group, orders, N_c, 2) */
    progress *track;            /* (points_per_group) */
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
    sm_status status = SM_OK;
    const int n = contact->contacts;
    for (int k = 0; k < grid->steps; k++) {
        for (int stage = 0; stage < 2; stage++) {
            load_forcing(SM_LANES, contact, grid->carrier + (k * 2 + stage) * 4, a, b, phase, m->u);
            const sm_status s = sm_stage(SM_LANES, stepper, m, stage);
            status = s != SM_OK ? s : status;
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
    return status;
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
    const int n = contact->contacts, per_point = grid->orders_count * n * 2;
    memset(g->fresh, 0, sizeof(double) * (size_t)(grid->points_per_group * per_point));
    for (int lane = 0; lane < g->blocks * SM_LANES; lane++) {
        const int block = lane / SM_LANES, l = lane % SM_LANES;
        double *point = g->fresh + (size_t)(lane / grid->lines) * per_point;
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

/* Largest frictionless contact displacement at a point: the scale of its harmonics. */
static double displacement_scale(const sm_contact *contact, const double *amplitude) {
    const int n = contact->contacts;
    double scale = 0.0;
    for (int i = 0; i < n; i++) {
        double force = 0.0;
        for (int j = 0; j < contact->modes; j++) {
            const double *L = contact->coupling + 2 * (j * n + i);
            force += 2.0 * hypot(L[0], L[1]) * amplitude[j];
        }
        const double x = force / contact->stiffness[i * n + i];
        scale = x > scale ? x : scale;
    }
    return scale;
}

/* Distance from periodicity: the last change, times the sum of the geometric series it starts. */
static double periodicity(progress *track, const double *fresh, const double *last, int count,
                          double scale) {
    double now = 0.0;
    for (int k = 0; k < count; k++) {
        const double c = fabs(fresh[k] - last[k]);
        now = c > now ? c : now;
    }
    now /= scale;
    double ratio = track->change > 0.0 ? now / track->change : 0.9;
    ratio = ratio < 0.3 ? 0.3 : ratio > 0.97 ? 0.97 : ratio;
    track->change = now;
    track->idle = now < PROGRESS * track->best ? 0 : track->idle + 1;
    track->best = now < track->best ? now : track->best;
    return now * ratio / (1.0 - ratio);
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

static sm_status solve_group(const sm_contact *contact, const sm_stepper *stepper,
                             const torus_grid *grid, torus_group *g, size_t first, size_t points,
                             const double *amplitudes, double tolerance, double floor_scale,
                             int max_periods, double *harmonics, double *residual,
                             int32_t *periods) {
    const int n = contact->contacts, per_point = grid->orders_count * n * 2;
    const size_t group_points =
        points - first < (size_t)grid->points_per_group ? points - first
                                                        : (size_t)grid->points_per_group;
    start_group(contact, grid, g, first, points, amplitudes);
    for (size_t p = 0; p < group_points; p++)
        g->track[p] = (progress){.change = 0.0, .best = INFINITY, .idle = 0, .done = 0};
    for (int period = 1; period <= max_periods; period++) {
        memset(g->sums, 0,
               sizeof(double) * (size_t)(g->blocks * grid->orders_count * n * 2 * SM_LANES));
        for (int block = 0; block < g->blocks; block++) {
            const size_t at = (size_t)block * SM_LANES;
            const sm_status status = march_period(
                contact, stepper, grid, &g->lanes[block], g->a + at, g->b + at, g->phase + 2 * at,
                g->sums + at * (size_t)(grid->orders_count * n * 2));
            if (status != SM_OK) return status;
        }
        collect(contact, grid, g);
        int open = 0;
        for (size_t p = 0; p < group_points; p++) {
            const size_t point = first + p;
            double *fresh = g->fresh + p * (size_t)per_point;
            double *last = g->last + p * (size_t)per_point;
            progress *track = &g->track[p];
            if (track->done) continue; /* its answer is already stored */
            const double scale = fmax(
                floor_scale,
                displacement_scale(contact, amplitudes + point * (size_t)contact->modes));
            residual[point] = scale == 0.0  ? 0.0
                              : period == 1 ? INFINITY
                                            : periodicity(track, fresh, last, per_point, scale);
            memcpy(last, fresh, sizeof(double) * (size_t)per_point);
            memcpy(harmonics + point * (size_t)per_point, fresh,
                   sizeof(double) * (size_t)per_point);
            periods[point] = period;
            track->done = residual[point] <= tolerance || track->idle >= IDLE_PERIODS;
            open |= !track->done;
        }
        if (!open) break;
        rotate_phases(grid, g);
    }
    return SM_OK;
}

static size_t take(size_t *total, size_t doubles) {
    const size_t at = *total;
    *total += (doubles + 7) & ~(size_t)7; /* whole cache lines */
    return at;
}

static sm_status check(const sm_contact *contact, const double *rates, int32_t steps,
                       int32_t lines, size_t points, const double *amplitudes,
                       int32_t orders_count) {
    const sm_status status = sm_contact_check(contact);
    if (status != SM_OK) return status;
    if (steps < 4 || steps > 65536 || lines < 1 || lines > 4096 || (lines & (lines - 1)) != 0)
        return SM_BAD_ARGUMENT;
    if (orders_count < 1 || orders_count > 4096) return SM_BAD_ARGUMENT;
    for (int j = 0; j < contact->modes; j++)
        if (!(rates[j] > 0.0) || !isfinite(rates[j])) return SM_BAD_ARGUMENT;
    for (size_t k = 0; k < points * (size_t)contact->modes; k++)
        if (!(amplitudes[k] >= 0.0) || !isfinite(amplitudes[k])) return SM_NOT_FINITE;
    return SM_OK;
}

sm_status sm_torus_harmonics(const sm_contact *contact, const double *rates, int32_t steps,
                             int32_t lines, double tolerance, const double *smallest_scale,
                             int32_t max_periods, size_t points, const double *amplitudes,
                             int32_t orders_count, const int32_t *orders, double *harmonics,
                             double *residual, int32_t *periods) {
    sm_status status = check(contact, rates, steps, lines, points, amplitudes, orders_count);
    if (status != SM_OK) return status;
    const int n = contact->contacts;
    const int blocks = lines > SM_LANES ? lines / SM_LANES : 1;
    torus_grid grid = {.steps = steps,
                       .lines = lines,
                       .points_per_group = blocks * SM_LANES / lines,
                       .orders_count = orders_count,
                       .orders = orders,
                       .ratio = contact->modes == 2 ? rates[1] / rates[0] : 0.0};
    torus_group g = {.blocks = blocks};
    sm_stepper stepper;

    const size_t per_group = (size_t)grid.points_per_group * (size_t)(orders_count * n * 2);
    const size_t lanes_size = (sm_lanes_size(n, SM_LANES) + 7) & ~(size_t)7;
    const size_t wide = (size_t)blocks * SM_LANES;
    size_t total = 0;
    const size_t at_carrier = take(&total, (size_t)steps * 8);
    const size_t at_weight = take(&total, (size_t)(steps * orders_count * 2));
    const size_t at_stepper = take(&total, sm_stepper_size(n));
    const size_t at_lanes = take(&total, lanes_size * (size_t)blocks);
    const size_t at_a = take(&total, wide), at_b = take(&total, wide);
    const size_t at_phase = take(&total, 2 * wide);
    const size_t at_sums = take(&total, wide * (size_t)(orders_count * n * 2));
    const size_t at_fresh = take(&total, per_group), at_last = take(&total, per_group);
    double *memory = calloc(total, sizeof(double));
    g.lanes = calloc((size_t)blocks, sizeof(sm_lanes));
    g.track = calloc((size_t)grid.points_per_group, sizeof(progress));
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
    for (int block = 0; block < blocks; block++)
        sm_lanes_place(&g.lanes[block], n, SM_LANES, memory + at_lanes + lanes_size * (size_t)block);
    sm_stepper_place(&stepper, n, memory + at_stepper);
    sm_stepper_set(&stepper, contact, TWO_PI / (rates[0] * steps));
    fill_grid(&grid);

    const double floor_scale = displacement_scale(contact, smallest_scale);
    for (size_t first = 0; first < points && status == SM_OK;
         first += (size_t)grid.points_per_group)
        status = solve_group(contact, &stepper, &grid, &g, first, points, amplitudes, tolerance,
                             floor_scale, max_periods, harmonics, residual, periods);
    free(memory);
    free(g.lanes);
    free(g.track);
    return status;
}

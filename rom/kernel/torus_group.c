#include "torus_group.h"

#include <stdlib.h>

#include "check.h"
#include "torus_march.h"

static size_t whole_lines(size_t doubles) { return (doubles + 7) & ~(size_t)7; }

/* ---- the grid ------------------------------------------------------------------------ */

/* exp(i m angle) from (cos, sin) of the angle, for a small integer m. */
static void power(double c, double s, int m, double *re, double *im) {
    const double signed_s = m < 0 ? -s : s;
    double pr = 1.0, pi = 0.0;
    for (int k = 0; k < abs(m); k++) {
        const double t = pr * c - pi * signed_s;
        pi = pr * signed_s + pi * c;
        pr = t;
    }
    *re = pr;
    *im = pi;
}

/* exp(i (n t_A + m t_B')) from the carriers there. */
static void harmonic(const double *carrier, const int32_t *order, double *re, double *im) {
    double a_re, a_im, b_re, b_im;
    power(carrier[0], carrier[1], order[0], &a_re, &a_im);
    power(carrier[2], carrier[3], order[1], &b_re, &b_im);
    *re = a_re * b_re - a_im * b_im;
    *im = a_re * b_im + a_im * b_re;
}

static void fill_angles(sm_torus_grid *grid) {
    const int orders = grid->orders_count;
    for (int k = 0; k < 2 * (grid->steps + SM_TOGETHER); k++) {
        const double t = SM_TWO_PI * sm_stage_place((size_t)k) / grid->steps;
        double *c = grid->carrier + k * 4;
        c[0] = cos(t);
        c[1] = sin(t);
        c[2] = cos(grid->ratio * t);
        c[3] = sin(grid->ratio * t);
        for (int q = 0; q < orders; q++) {
            double re, im;
            harmonic(c, grid->orders + 2 * q, &re, &im);
            if (grid->turn) {
                grid->turn[2 * (k * orders + q)] = re;
                grid->turn[2 * (k * orders + q) + 1] = im;
            }
            if (k % 2 == 1) {
                grid->weight[(k - 1) * orders + 2 * q] = re / grid->steps;
                grid->weight[(k - 1) * orders + 2 * q + 1] = -im / grid->steps;
            }
        }
    }
}

/* The answer to one period acts in the next: a fixed-point iteration with factor H / K. Where that
 * is large it is relaxed; more so where a mode in resonance answers a quarter turn late. */
static double relaxation_of(const sm_contact *contact, const double *H) {
    const size_t n = (size_t)contact->contacts;
    double size = 0.0, re = 0.0, im = 0.0;
    for (size_t i = 0; i < n; i++) {
        double row = 0.0;
        for (size_t k = 0; k < n; k++)
            row += hypot(H[2 * (i * n + k)], H[2 * (i * n + k) + 1]);
        size = fmax(size, row / contact->stiffness[i * n + i]);
        re += H[2 * (i * n + i)] / contact->stiffness[i * n + i];
        im += H[2 * (i * n + i) + 1] / contact->stiffness[i * n + i];
    }
    if (size <= 0.3) return 1.0;
    const double along = size * re / fmax(hypot(re, im), 1e-300);
    const double best = (1.0 - along) / (1.0 - 2.0 * along + size * size);
    const double safe = 1.0 / (1.0 + size); /* whatever the phase, for a factor below 1 */
    return best > 0.0 ? fmin(best, safe) : safe;
}

sm_status sm_torus_grid_make(sm_torus_grid *grid, const sm_contact *contact, const double *rates,
                             int steps, int lines, int orders_count, const int32_t *orders) {
    const size_t n = (size_t)contact->contacts, count = (size_t)orders_count;
    const size_t rows = (size_t)steps + SM_TOGETHER;
    const size_t carrier = rows * 8, weight = rows * count * 2;
    const size_t stepper = whole_lines(sm_stepper_size(contact->contacts));
    const size_t turn = contact->answer ? rows * count * 4 : 0;
    const size_t relaxation = contact->answer ? count : 0;
    grid->contact = contact;
    grid->steps = steps;
    grid->lines = lines;
    grid->points_per_group = lines > SM_LANES ? 1 : SM_LANES / lines;
    grid->orders_count = orders_count;
    grid->per_point = count * n * 2;
    grid->orders = orders;
    grid->ratio = contact->modes == 2 ? rates[1] / rates[0] : 0.0;
    grid->memory = calloc(stepper + carrier + weight + turn + relaxation, sizeof(double));
    if (!grid->memory) return SM_NO_MEMORY;
    sm_stepper_place(&grid->stepper, contact->contacts, grid->memory);
    grid->carrier = grid->memory + stepper;
    grid->weight = grid->carrier + carrier;
    grid->turn = contact->answer ? grid->weight + weight : NULL;
    grid->feedback = contact->answer ? contact->answer->feedback : NULL;
    grid->relaxation = contact->answer ? grid->weight + weight + turn : NULL;
    fill_angles(grid);
    for (int q = 0; q < orders_count && grid->feedback; q++)
        grid->relaxation[q] = relaxation_of(contact, grid->feedback + (size_t)q * n * n * 2);
    return sm_stepper_set(&grid->stepper, contact, SM_TWO_PI / (rates[0] * steps));
}

void sm_torus_grid_release(sm_torus_grid *grid) { free(grid->memory); }

/* ---- the group ----------------------------------------------------------------------- */

sm_status sm_torus_group_make(sm_torus_group *g, const sm_torus_grid *grid) {
    const int n = grid->contact->contacts;
    const size_t points = (size_t)grid->points_per_group;
    g->blocks = grid->lines > SM_LANES ? grid->lines / SM_LANES : 1;
    const size_t wide = (size_t)g->blocks * SM_LANES;
    const size_t lanes = whole_lines(sm_lanes_size(n, SM_LANES)) * (size_t)g->blocks;
    const size_t sums = wide * grid->per_point, squares = wide * (size_t)n;
    const size_t pull = grid->feedback ? sums : 0;
    const size_t harmonics = whole_lines(points * grid->per_point);
    const size_t speed = whole_lines(sm_acceleration_size(n, grid->lines));
    const size_t line_state = (size_t)(n + 2) * (size_t)grid->lines;
    const size_t row = (size_t)n * SM_LANES;
    g->memory = calloc(lanes + 6 * wide + sums + pull + 2 * squares + 3 * SM_TOGETHER * row
                           + 8 * harmonics + points * speed + line_state + points * (size_t)n,
                       sizeof(double));
    g->lanes = calloc((size_t)g->blocks, sizeof(sm_lanes));
    g->track = calloc(points, sizeof(sm_progress));
    g->faster = calloc(points, sizeof(sm_acceleration));
    if (!g->memory || !g->lanes || !g->track || !g->faster) return SM_NO_MEMORY;
    double *memory = g->memory;
    for (int block = 0; block < g->blocks; block++, memory += lanes / (size_t)g->blocks)
        sm_lanes_place(&g->lanes[block], n, SM_LANES, memory);
    g->a = memory;
    g->b = g->a + wide;
    g->a_step = g->b + wide;
    g->b_step = g->a_step + wide;
    g->phase = g->b_step + wide;
    g->sums = g->phase + 2 * wide;
    g->pull = grid->feedback ? g->sums + sums : NULL;
    g->squares[0] = g->sums + sums + pull;
    g->squares[1] = g->squares[0] + squares;
    g->forcing = g->squares[1] + squares;
    g->moved = g->forcing + 2 * SM_TOGETHER * row;
    memory = g->moved + SM_TOGETHER * row;
    double **arrays[] = {&g->half[0], &g->half[1], &g->fresh,   &g->last[0],
                         &g->last[1], &g->idle_sum, &g->answered, &g->answer};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++, memory += harmonics)
        *arrays[k] = memory;
    for (size_t p = 0; p < points; p++, memory += speed)
        sm_acceleration_place(&g->faster[p], n, grid->lines, memory);
    g->line_state = memory;
    g->idle_squares = memory + line_state;
    return SM_OK;
}

void sm_torus_group_release(sm_torus_group *g) {
    free(g->memory);
    free(g->lanes);
    free(g->track);
    free(g->faster);
}

void sm_torus_group_start(const sm_torus_grid *grid, sm_torus_group *g, size_t first,
                          size_t points, const double *amplitudes) {
    const size_t modes = (size_t)grid->contact->modes;
    const size_t lanes_size = sm_lanes_size(grid->contact->contacts, SM_LANES);
    for (int block = 0; block < g->blocks; block++)
        memset(g->lanes[block].x, 0, lanes_size * sizeof(double));
    const size_t harmonics = (size_t)grid->points_per_group * grid->per_point * sizeof(double);
    memset(g->answered, 0, harmonics);
    memset(g->half[1], 0, harmonics);
    if (g->pull)
        memset(g->pull, 0, (size_t)g->blocks * SM_LANES * grid->per_point * sizeof(double));
    for (int lane = 0; lane < g->blocks * SM_LANES; lane++) {
        const int block = lane / SM_LANES, l = lane % SM_LANES;
        size_t point = first + (size_t)(lane / grid->lines);
        point = point < points ? point : points - 1; /* spare lanes repeat the last point */
        const double t_b0 = SM_TWO_PI * (lane % grid->lines) / grid->lines;
        g->a[lane] = amplitudes[point * modes];
        g->b[lane] = modes == 2 ? amplitudes[point * 2 + 1] : 0.0;
        g->phase[block * 2 * SM_LANES + l] = cos(t_b0);
        g->phase[(block * 2 + 1) * SM_LANES + l] = sin(t_b0);
    }
    for (int p = 0; p < grid->points_per_group; p++) {
        sm_progress_start(&g->track[p]);
        sm_acceleration_start(&g->faster[p]);
    }
}

/* ---- half a period --------------------------------------------------------------------- */

/* Mean over lines: P = sum over lanes of sums exp(-i m t_B0) / lines. */
static void collect(const sm_torus_grid *grid, const sm_torus_group *g, double *harmonics) {
    const size_t n = (size_t)grid->contact->contacts;
    memset(harmonics, 0, sizeof(double) * (size_t)grid->points_per_group * grid->per_point);
    for (int lane = 0; lane < g->blocks * SM_LANES; lane++) {
        const size_t block = (size_t)(lane / SM_LANES), l = (size_t)(lane % SM_LANES);
        double *point = harmonics + (size_t)(lane / grid->lines) * grid->per_point;
        const double *phase = g->phase + block * 2 * SM_LANES;
        const double *sums = g->sums + block * SM_LANES * grid->per_point;
        for (int q = 0; q < grid->orders_count; q++) {
            double re, im;
            power(phase[l], phase[SM_LANES + l], -grid->orders[2 * q + 1], &re, &im);
            for (size_t i = 0; i < n; i++) {
                const size_t at = ((size_t)q * n + i) * 2;
                const double *sum = sums + at * SM_LANES + l;
                point[at] += (re * sum[0] - im * sum[SM_LANES]) / grid->lines;
                point[at + 1] += (re * sum[SM_LANES] + im * sum[0]) / grid->lines;
            }
        }
    }
}

sm_status sm_torus_group_half(const sm_torus_grid *grid, sm_torus_group *g, int half) {
    const size_t wide = (size_t)g->blocks * SM_LANES;
    const size_t harmonics = (size_t)grid->points_per_group * grid->per_point;
    memset(g->sums, 0, sizeof(double) * wide * grid->per_point);
    memset(g->squares[half], 0, sizeof(double) * wide * (size_t)grid->contact->contacts);
    for (int block = 0; block < g->blocks; block++) {
        const sm_status status = sm_torus_march(grid, g, block, half);
        if (status != SM_OK) return status;
    }
    collect(grid, g, g->half[half]);
    for (size_t k = 0; k < harmonics; k++) g->fresh[k] = g->half[0][k] + g->half[1][k];
    return sm_all_finite(g->fresh, harmonics) ? SM_OK : SM_NOT_FINITE;
}

void sm_torus_group_mean_square(const sm_torus_grid *grid, const sm_torus_group *g, size_t p,
                                double *mean_square) {
    const int n = grid->contact->contacts, lines = grid->lines;
    for (int i = 0; i < n; i++) {
        double sum = 0.0;
        for (int lane = (int)p * lines; lane < ((int)p + 1) * lines; lane++) {
            const int at = (lane / SM_LANES * n + i) * SM_LANES + lane % SM_LANES;
            sum += g->squares[0][at] + g->squares[1][at];
        }
        mean_square[i] = sum / ((double)grid->steps * lines);
    }
}

/* ---- between periods ----------------------------------------------------------------- */

void sm_torus_group_turn(const sm_torus_grid *grid, sm_torus_group *g) {
    const double c = cos(SM_TWO_PI * grid->ratio), s = sin(SM_TWO_PI * grid->ratio);
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
static void exchange_lines(const sm_torus_grid *grid, sm_torus_group *g, size_t p, int back) {
    const size_t n = (size_t)grid->contact->contacts, lines = (size_t)grid->lines;
    double *x = g->line_state, *angle = x + n * lines;
    for (size_t line = 0; line < lines; line++) {
        const size_t lane = p * lines + line, block = lane / SM_LANES, l = lane % SM_LANES;
        for (size_t i = 0; i < n; i++) {
            double *in_lane = g->lanes[block].x + i * SM_LANES + l;
            double *in_line = x + i * lines + line;
            *(back ? in_lane : in_line) = *(back ? in_line : in_lane);
        }
        angle[line] = g->phase[block * 2 * SM_LANES + l];
        angle[lines + line] = g->phase[(block * 2 + 1) * SM_LANES + l];
    }
}

static void accelerate(const sm_torus_grid *grid, sm_torus_group *g, size_t points) {
    const double *angle = g->line_state + (size_t)(grid->contact->contacts * grid->lines);
    for (size_t p = 0; p < points; p++) {
        if (g->track[p].done) continue;
        exchange_lines(grid, g, p, 0);
        if (sm_accelerate(&g->faster[p], g->track[p].slow, angle, angle + grid->lines,
                          g->line_state)) {
            exchange_lines(grid, g, p, 1);
            sm_progress_restart(&g->track[p]);
        }
    }
}

static void relax(const sm_torus_grid *grid, sm_torus_group *g) {
    const size_t per_order = 2 * (size_t)grid->contact->contacts;
    for (size_t k = 0; k < (size_t)grid->points_per_group * grid->per_point; k++) {
        const double part = grid->relaxation[(k / per_order) % (size_t)grid->orders_count];
        g->answered[k] += part * (g->fresh[k] - g->answered[k]);
    }
}

/* answer = 2 H_q P_q: the force of the modes' non-resonant answer to x_c. */
static void set_answer(const sm_torus_grid *grid, sm_torus_group *g) {
    const size_t n = (size_t)grid->contact->contacts;
    for (size_t k = 0; k < (size_t)(grid->points_per_group * grid->orders_count); k++) {
        const double *H = grid->feedback + k % (size_t)grid->orders_count * n * n * 2;
        for (size_t i = 0; i < n; i++, H += 2 * n) {
            const double *P = g->answered + k * n * 2;
            double *force = g->answer + (k * n + i) * 2;
            force[0] = force[1] = 0.0;
            for (size_t j = 0; j < 2 * n; j += 2) {
                force[0] += 2.0 * (H[j] * P[j] - H[j + 1] * P[j + 1]);
                force[1] += 2.0 * (H[j] * P[j + 1] + H[j + 1] * P[j]);
            }
        }
    }
}

/* pull = answer exp(i m t_B0) */
static void set_pull(const sm_torus_grid *grid, sm_torus_group *g) {
    const size_t n = (size_t)grid->contact->contacts;
    for (int lane = 0; lane < g->blocks * SM_LANES; lane++) {
        const size_t block = (size_t)(lane / SM_LANES), l = (size_t)(lane % SM_LANES);
        const double *point = g->answer + (size_t)(lane / grid->lines) * grid->per_point;
        const double *phase = g->phase + block * 2 * SM_LANES;
        double *pull = g->pull + block * SM_LANES * grid->per_point;
        for (int q = 0; q < grid->orders_count; q++) {
            double re, im;
            power(phase[l], phase[SM_LANES + l], grid->orders[2 * q + 1], &re, &im);
            for (size_t i = 0; i < n; i++) {
                const size_t at = ((size_t)q * n + i) * 2;
                pull[at * SM_LANES + l] = point[at] * re - point[at + 1] * im;
                pull[(at + 1) * SM_LANES + l] = point[at] * im + point[at + 1] * re;
            }
        }
    }
}

void sm_torus_group_next(const sm_torus_grid *grid, sm_torus_group *g, size_t points, int half) {
    if (half == 1) {
        sm_torus_group_turn(grid, g);
        accelerate(grid, g, points);
    }
    if (!g->pull) return;
    relax(grid, g);
    set_answer(grid, g);
    set_pull(grid, g);
}

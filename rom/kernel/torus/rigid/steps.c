/* Time steps of rigid contacts on phase lines, eqs. (12), (13), and the harmonics of eq. (14).
 *
 * Lanes are marched by the stages of contact/stage/tr_bdf2.h under the forces of the modes. The
 * mean of x exp(-i (n t_A + m t_B)) is a sum over steps in each lane, then over lines. Forces and
 * sums of SM_TOGETHER steps are computed in one pass over the harmonics. The search for periodic
 * motion (periodic/search.c) and growth.c call it through sm_torus_law. */
#include "torus/rigid/group.h"

#include "base/check.h"
#include "contact/stage/tr_bdf2.h"

#define COARSE_HALVES 3 /* the half period from rest, and a whole period */

/* Computes u = -2 Re sum_j L_j a_j exp(i t_j) in each lane, `steps` after the period's start. */
SM_INLINE void load_forcing(const int lanes, const sm_contact *contact, const double *carrier,
                            double steps, const sm_torus_group *g, size_t at,
                            double *restrict u) {
    const double *restrict a = g->a + at, *restrict b = g->b + at;
    const double *restrict a_step = g->a_step + at, *restrict b_step = g->b_step + at;
    const double *restrict c = sm_phases_power(&g->phases, 1) + at;
    const double *restrict s = c + g->phases.wide;
    const int n = contact->contacts;
    for (int i = 0; i < n; i++) {
        const double *L = contact->coupling + 2 * i;
        const double force_a = -2.0 * (L[0] * carrier[0] - L[1] * carrier[1]);
        SM_SIMD
        for (int l = 0; l < lanes; l++) u[i * lanes + l] = force_a * (a[l] + steps * a_step[l]);
        if (contact->modes == 1) continue;
        L = contact->coupling + 2 * (n + i);
        /* Re(L exp(i (t_B0 + ratio t_A))) = p cos t_B0 - q sin t_B0 */
        const double p = -2.0 * (L[0] * carrier[2] - L[1] * carrier[3]);
        const double q = -2.0 * (L[1] * carrier[2] + L[0] * carrier[3]);
        SM_SIMD
        for (int l = 0; l < lanes; l++)
            u[i * lanes + l] += (b[l] + steps * b_step[l])
                                * (p * c[l] - q * s[l]);
    }
}

/* Adds Re sum_q reaction_q exp(i (n + m ratio) t_A) to u at 2 SM_TOGETHER stages. */
SM_INLINE void add_reaction(const int lanes, const sm_torus_grid *grid, const double *phasor,
                            const double *reaction, double *restrict u) {
    const int n = grid->contact->contacts, orders = grid->orders_count;
    const size_t row = (size_t)n * (size_t)lanes, column = 2 * (size_t)orders;
    for (int i = 0; i < n; i++)
        for (int stage = 0; stage < 2 * SM_TOGETHER; stage += 4) {
            double sum[4][SM_LANES] = {{0.0}}; /* stays in registers */
            const double *restrict t = phasor + (size_t)stage * column;
            for (int q = 0; q < orders; q++, t += 2) {
                const double *restrict re = reaction + (size_t)(q * n + i) * 2 * lanes;
                const double *restrict im = re + lanes;
                SM_SIMD
                for (int l = 0; l < lanes; l++) {
                    sum[0][l] = (sum[0][l] + re[l] * t[0]) - im[l] * t[1];
                    sum[1][l] = (sum[1][l] + re[l] * t[column]) - im[l] * t[column + 1];
                    sum[2][l] = (sum[2][l] + re[l] * t[2 * column]) - im[l] * t[2 * column + 1];
                    sum[3][l] = (sum[3][l] + re[l] * t[3 * column]) - im[l] * t[3 * column + 1];
                }
            }
            for (int k = 0; k < 4; k++) {
                double *restrict to = u + (size_t)(stage + k) * row + (size_t)(i * lanes);
                for (int l = 0; l < lanes; l++) to[l] += sum[k][l];
            }
        }
}

/* Computes the modal forces u (2 SM_TOGETHER stages, N_c, lanes) from step k on. */
SM_INLINE void compute_forcing(const int lanes, const sm_torus_grid *grid, const sm_torus_group *g,
                     int block, int k, double *u) {
    const size_t at = (size_t)block * (size_t)lanes, first = 2 * (size_t)k;
    const size_t row = (size_t)grid->contact->contacts * (size_t)lanes;
    for (size_t stage = 0; stage < 2 * SM_TOGETHER; stage++)
        load_forcing(lanes, grid->contact, grid->carrier + 4 * (first + stage),
                     sm_stage_place(first + stage), g, at, u + stage * row);
    if (g->reaction)
        add_reaction(lanes, grid, grid->phasor + 2 * (size_t)grid->orders_count * first,
                     g->reaction + at * grid->per_point, u);
}

/* Adds the displacements (SM_TOGETHER, N_c, lanes) of the steps from k on, times their weights, to
 * the sums. */
SM_INLINE void add_harmonics(const int lanes, const sm_torus_grid *grid, int k,
                             const double *all_x, double *sums) {
    const int n = grid->contact->contacts, orders = grid->orders_count;
    const size_t row = (size_t)n * (size_t)lanes, column = 2 * (size_t)orders;
    for (int q = 0; q < orders; q++) {
        const double *w = grid->weight + column * (size_t)k + 2 * q;
        for (int i = 0; i < n; i++) {
            double *restrict sum = sums + ((size_t)q * (size_t)n + (size_t)i) * 2 * lanes;
            const double *restrict x = all_x + (size_t)i * lanes;
            SM_SIMD
            for (int l = 0; l < lanes; l++) {
                sum[l] = sum[l] + w[0] * x[l] + w[column] * x[row + l]
                         + w[2 * column] * x[2 * row + l] + w[3 * column] * x[3 * row + l];
                sum[lanes + l] = sum[lanes + l] + w[1] * x[l] + w[column + 1] * x[row + l]
                                 + w[2 * column + 1] * x[2 * row + l]
                                 + w[3 * column + 1] * x[3 * row + l];
            }
        }
    }
}

/* Marches a block of `lanes` (a literal) through a number of steps: adds x exp(-i (n + m ratio) t_A) /
 * grid->steps to the sums of its lanes, and x^2 to their squares. */
SM_INLINE sm_status march(const int lanes, const sm_torus_grid *grid, const sm_torus_group *g,
                          int block, int steps) {
    const sm_stepper *s = &grid->stepper;
    const int n = s->contacts;
    const size_t row = (size_t)n * (size_t)lanes;
    double *sums = g->sums + (size_t)block * (size_t)lanes * grid->per_point;
    double *squares = g->squares + (size_t)block * row;
    sm_lanes m = g->lanes[block];
    for (int k = 0; k < steps; k += SM_TOGETHER) {
        memset(g->displacement, 0, SM_TOGETHER * row * sizeof(double));
        compute_forcing(lanes, grid, g, block, k, g->forcing);
        for (int step = 0; step < SM_TOGETHER && k + step < steps; step++) {
            for (int stage = 0; stage < 2; stage++) {
                m.u = g->forcing + (size_t)(2 * step + stage) * row;
                SM_TRY(n == 1   ? sm_stage(1, lanes, s, &m, stage)
                       : n == 2 ? sm_stage(2, lanes, s, &m, stage)
                                : sm_stage(n, lanes, s, &m, stage));
            }
            memcpy(g->displacement + (size_t)step * row, m.x, row * sizeof(double));
            SM_SIMD
            for (size_t i = 0; i < row; i++) squares[i] += m.x[i] * m.x[i];
        }
        add_harmonics(lanes, grid, k, g->displacement, sums);
    }
    return SM_OK;
}

/* Marches a block of SM_FEW_LANES lanes. */
SM_HOT static sm_status march_few(const sm_torus_grid *grid, const sm_torus_group *g, int block,
                                  int steps) {
    return march(SM_FEW_LANES, grid, g, block, steps);
}

/* Marches a block of SM_LANES lanes. */
SM_HOT static sm_status march_many(const sm_torus_grid *grid, const sm_torus_group *g, int block,
                                   int steps) {
    return march(SM_LANES, grid, g, block, steps);
}

/* Returns the sum of `count` numbers, a power of two. Halves are added to each other, so that the
 * order of the additions does not depend on the width of the vectors. */
SM_INLINE double sum_of(size_t count, double *restrict x) {
    for (size_t half = count / 2; half > 0; half /= 2) {
        SM_SIMD
        for (size_t l = 0; l < half; l++) x[l] += x[half + l];
    }
    return x[0];
}

/* Computes the harmonics of each point: Y = weight * sum over its lanes of sums exp(-i m t_B0). */
SM_HOT static void compute_harmonics(const sm_torus_grid *grid, const sm_torus_group *g,
                                     double weight) {
    const size_t n = (size_t)grid->contact->contacts, lanes = (size_t)grid->lanes;
    const size_t lines = (size_t)grid->lines, own = lines < lanes ? lines : lanes;
    memset(g->Y, 0, sizeof(double) * (size_t)grid->points_per_group * grid->per_point);
    for (int block = 0; block < g->blocks; block++)
        for (int q = 0; q < grid->orders_count; q++) {
            const int m = grid->orders[2 * q + 1];
            const double *restrict c = sm_phases_power(&g->phases, m) + (size_t)block * lanes;
            const double *restrict sine = c + g->phases.wide, sign = m < 0 ? -1.0 : 1.0;
            for (size_t at = (size_t)q * n * 2; at < (size_t)(q + 1) * n * 2; at += 2) {
                const double *restrict sum =
                    g->sums + (size_t)block * lanes * grid->per_point + at * lanes;
                double re[SM_LANES], im[SM_LANES];
                SM_SIMD
                for (size_t l = 0; l < lanes; l++) {
                    const double s = sign * sine[l];
                    re[l] = c[l] * sum[l] + s * sum[lanes + l];
                    im[l] = c[l] * sum[lanes + l] - s * sum[l];
                }
                for (size_t l = 0; l < lanes; l += own) {
                    double *point = g->Y + ((size_t)block * lanes + l) / lines * grid->per_point;
                    point[at] += weight * sum_of(own, re + l);
                    point[at + 1] += weight * sum_of(own, im + l);
                }
            }
        }
}

/* Computes the modal forces in each lane at the period's start: reaction = 2 R exp(i m t_B0). */
SM_HOT static void set_reaction(const sm_torus_grid *grid, sm_torus_group *g) {
    const size_t n = (size_t)grid->contact->contacts, lanes = (size_t)grid->lanes;
    const size_t lines = (size_t)grid->lines, own = lines < lanes ? lines : lanes;
    for (int block = 0; block < g->blocks; block++)
        for (int q = 0; q < grid->orders_count; q++) {
            const int m = grid->orders[2 * q + 1];
            const double *restrict c = sm_phases_power(&g->phases, m) + (size_t)block * lanes;
            const double *restrict sine = c + g->phases.wide, sign = m < 0 ? -1.0 : 1.0;
            for (size_t at = (size_t)q * n * 2; at < (size_t)(q + 1) * n * 2; at += 2) {
                double *restrict reaction =
                    g->reaction + (size_t)block * lanes * grid->per_point + at * lanes;
                for (size_t first = 0; first < lanes; first += own) {
                    const double *point =
                        g->response + ((size_t)block * lanes + first) / lines * grid->per_point;
                    const double re = 2.0 * point[at], im = 2.0 * point[at + 1];
                    SM_SIMD
                    for (size_t l = first; l < first + own; l++) {
                        const double s = sign * sine[l];
                        reaction[l] = re * c[l] - im * s;
                        reaction[lanes + l] = re * s + im * c[l];
                    }
                }
            }
        }
}

/* Computes the mean squares of all points over a number of steps. */
static void compute_mean_squares(const sm_torus_grid *grid, const sm_torus_group *g, int steps) {
    const int n = grid->contact->contacts, lines = grid->lines, points = grid->points_per_group;
    memset(g->mean_square, 0, sizeof(double) * (size_t)(points * n));
    for (int lane = 0; lane < points * lines; lane++)
        for (int i = 0; i < n; i++) {
            const int at = (lane / grid->lanes * n + i) * grid->lanes + lane % grid->lanes;
            g->mean_square[lane / lines * n + i] += g->squares[at] / ((double)steps * lines);
        }
}

/* Sets the amplitudes of each lane at the start of a period, and their growth per step. */
static void set_amplitudes(const sm_torus_grid *grid, sm_torus_group *g, const sm_march *m) {
    static const double none[SM_MODES] = {0.0};
    for (int lane = 0; lane < g->blocks * grid->lanes; lane++) {
        const size_t p = (size_t)(lane / grid->lines);
        const double *amplitude = sm_march_amplitudes(m, p);
        const double *growth = m->growth ? m->growth + sm_march_place(m, p) : none;
        g->a[lane] = m->part * amplitude[0] + m->elapsed * growth[0];
        g->a_step[lane] = growth[0] / grid->steps;
        if (grid->contact->modes == 1) continue;
        g->b[lane] = m->part * amplitude[1] + m->elapsed * growth[1];
        g->b_step[lane] = growth[1] / grid->steps;
    }
}

/* Reverses the signs of displacements and velocities after half a period. Friction is odd: the next
 * half period is then a repetition of the last one. */
static void reverse_signs(const sm_rigid_lines *r) {
    const size_t size = (size_t)r->grid.contact->contacts * (size_t)r->grid.lanes;
    for (int block = 0; block < r->group.blocks; block++) {
        const sm_lanes *l = &r->group.lanes[block];
        double *odd[] = {l->x, l->v, l->stage_v[0], l->stage_v[1], l->inertia};
        for (size_t k = 0; k < sizeof odd / sizeof *odd; k++)
            for (size_t i = 0; i < size; i++) odd[k][i] = -odd[k][i];
    }
}

sm_status sm_rigid_period(sm_march *m) {
    sm_rigid_lines *r = m->lines;
    sm_torus_group *g = &r->group;
    const int coarse_halves = r->coarse.steps < r->grid.steps ? COARSE_HALVES : 0;
    const sm_torus_grid *grid = r->half && r->marched < coarse_halves ? &r->coarse : &r->grid;
    const int steps = m->steps = grid->steps / (r->half ? 2 : 1);
    const size_t wide = (size_t)g->blocks * (size_t)grid->lanes;
    m->marches = ++r->marched;
    m->fine = r->marched - coarse_halves;
    set_amplitudes(grid, g, m);
    if (g->reaction) set_reaction(grid, g);
    memset(g->sums, 0, sizeof(double) * wide * grid->per_point);
    memset(g->squares, 0, sizeof(double) * wide * (size_t)grid->contact->contacts);
    for (int block = 0; block < g->blocks; block++) {
        SM_TRY(grid->lanes == SM_FEW_LANES ? march_few(grid, g, block, steps)
                                           : march_many(grid, g, block, steps));
    }
    compute_harmonics(grid, g, (double)grid->steps / steps / grid->lines);
    compute_mean_squares(grid, g, steps);
    sm_phases_turn(&g->phases, r->half ? 0.5 * (grid->ratio - 1.0) : grid->ratio);
    if (r->half) reverse_signs(r);
    return sm_all_finite(g->Y, (size_t)grid->points_per_group * grid->per_point) ? SM_OK
                                                                                 : SM_NOT_FINITE;
}

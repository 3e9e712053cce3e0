/* Periodic motion of elastic contacts on the torus, by characteristics.
 *
 * As for rigid contacts (torus.c) `lines` phase lines with t_B0 = 2 pi p / lines are marched period
 * by period of mode A, and modes with them (marched.h). What else the modes respond to the
 * harmonics of one period draws the contacts in the next: a fixed point, which Anderson's
 * acceleration finds also where plain passes diverge.
 */
#include "torus/fixed_point/elastic.h"

#include <stdlib.h>

#include "base/block.h"
#include "base/check.h"
#include "base/exact_sum.h"
#include "contact/elastic/reversal.h"
#include "contact/elastic/solve.h"
#include "torus/grid.h"
#include "torus/fixed_point/marched.h"
#include "torus/fixed_point/search.h"

#define MOST_AVERAGED 16
#define LEAST 1e-3 /* of the displacement of contacts that stick: the solver takes no less */

typedef struct {
    const sm_contact *contact;
    const sm_torus_task *task;
    size_t n, lines, steps, orders, remembered;
    double ratio;              /* omega_B / omega_A */
    double *flexibility;       /* (N_c, N_c) R */
    double *turn;              /* (steps, orders, 2): exp(i (n + m ratio) t_A) */
    double *phase;             /* (2, lines): cos and sin of t_B0 */
    double *drawn;             /* (orders, N_c, 2, lines): harmonics of u along the lines */
    double *sums;              /* (orders, N_c, 2, lines): of y exp(-i (n + m ratio) t_A) */
    double *u, *y, *last_u;    /* (N_c, lines) */
    double *x, *memory;        /* (lines, N_c), (lines, remembered) */
    double *before[2];         /* (lines, N_c) x one and two steps before */
    int follows;               /* the response is that of a point before */
    double *begun;             /* (lines, remembered) memory as the period began */
    size_t shift;              /* line p ends a period where p + shift began it; 0: nowhere */
    double *own_u;             /* (N_c) of one line */
    double *square;            /* (N_c) sum of y^2 */
    double *Y, *last_Y;        /* (orders, N_c, 2) harmonics of this and of the last period */
    double *response, *change; /* (orders, N_c, 2) the modes' response, and what it is off by */
    double *mean;              /* (orders, N_c, 2) and (N_c): of harmonics and squares */
    sm_elastic_solver solver;
    sm_marched marched;
    sm_fixed_point search;
    double *block;
} problem;

static size_t per_point(const problem *t) { return t->orders * t->n * 2; }

/* Lines are closed where the ratio is a multiple of 1 / lines. */
static size_t shift_of(double ratio, size_t lines) {
    const double turns = ratio * (double)lines, whole = nearbyint(turns);
    return fabs(turns - whole) < 1e-9 * turns ? (size_t)fmod(whole, (double)lines) : 0;
}

static sm_status make(problem *t, const sm_contact *contact, const sm_torus_task *task) {
    const size_t n = (size_t)contact->contacts, lines = (size_t)task->lines;
    const size_t steps = (size_t)task->steps, orders = (size_t)task->orders_count;
    const size_t all = orders * n * 2;
    *t = (problem){.contact = contact, .task = task, .n = n, .lines = lines, .steps = steps,
                   .orders = orders, .remembered = sm_elastic_memory(contact->elastic)};
    t->ratio = contact->modes == 2 ? task->rates[1] / task->rates[0] : 0.0;
    t->shift = shift_of(t->ratio, lines);
    const size_t solver = sm_elastic_solver_size(contact->elastic, contact->contacts);
    const size_t size = n * n + steps * orders * 2 + 2 * lines + 2 * all * lines
                        + 6 * n * lines + 2 * lines * t->remembered + 3 * n + 5 * all
                        + sm_fixed_point_size(all)
                        + sm_marched_size(contact->response, lines) + solver;
    double *memory = t->block = calloc(size, sizeof(double));
    if (!memory) return SM_NO_MEMORY;
    t->flexibility = sm_take(&memory, n * n);
    t->turn = sm_take(&memory, steps * orders * 2);
    t->phase = sm_take(&memory, 2 * lines);
    t->drawn = sm_take(&memory, all * lines);
    t->sums = sm_take(&memory, all * lines);
    t->u = sm_take(&memory, n * lines);
    t->y = sm_take(&memory, n * lines);
    t->last_u = sm_take(&memory, n * lines);
    t->x = sm_take(&memory, n * lines);
    for (int k = 0; k < 2; k++) t->before[k] = sm_take(&memory, n * lines);
    t->memory = sm_take(&memory, lines * t->remembered);
    t->begun = sm_take(&memory, lines * t->remembered);
    t->own_u = sm_take(&memory, n);
    t->square = sm_take(&memory, n);
    t->Y = sm_take(&memory, all);
    t->last_Y = sm_take(&memory, all);
    t->response = sm_take(&memory, all);
    t->change = sm_take(&memory, all);
    t->mean = sm_take(&memory, all + n);
    sm_fixed_point_place(&t->search, all, sm_take(&memory, sm_fixed_point_size(all)));
    sm_marched_place(&t->marched, contact->response, n, lines,
                     sm_take(&memory, sm_marched_size(contact->response, lines)));
    sm_elastic_solver_place(&t->solver, contact->elastic, contact->contacts, t->flexibility,
                            memory);
    for (size_t k = 0; k < n * n; k++) t->flexibility[k] = -contact->stiffness[k];
    for (size_t k = 0; k < steps; k++)
        for (size_t q = 0; q < orders; q++) {
            const int32_t *order = task->orders + 2 * q;
            const double angle = SM_TWO_PI * (double)(k + 1) / (double)steps
                                 * (order[0] + order[1] * t->ratio);
            t->turn[2 * (k * orders + q)] = cos(angle);
            t->turn[2 * (k * orders + q) + 1] = sin(angle);
        }
    return SM_OK;
}

/* change = H Y + held - response; the largest of it [m]. */
static double find_change(problem *t) {
    const size_t n = t->n;
    const double *H = t->contact->response ? t->contact->response->dynamic_stiffness : NULL;
    double largest = 0.0;
    if (!H) return 0.0;
    const double *held = t->contact->response->held;
    for (size_t q = 0; q < t->orders; q++)
        for (size_t i = 0; i < n; i++, H += 2 * n) {
            const double *Y = t->Y + 2 * q * n;
            const size_t at = 2 * (q * n + i);
            double re = -t->response[at] + (held ? held[at] : 0.0);
            double im = -t->response[at + 1] + (held ? held[at + 1] : 0.0);
            for (size_t k = 0; k < 2 * n; k += 2) {
                re += H[k] * Y[k] - H[k + 1] * Y[k + 1];
                im += H[k] * Y[k + 1] + H[k + 1] * Y[k];
            }
            t->change[at] = re;
            t->change[at + 1] = im;
            largest = fmax(largest, hypot(re, im));
        }
    return largest;
}

/* Contacts at rest. */
static void start_again(problem *t) {
    for (size_t p = 0; p < t->lines; p++) {
        t->phase[p] = cos(SM_TWO_PI * (double)p / (double)t->lines);
        t->phase[t->lines + p] = sin(SM_TWO_PI * (double)p / (double)t->lines);
    }
    memset(t->last_u, 0, t->n * t->lines * sizeof(double));
    memset(t->x, 0, t->n * t->lines * sizeof(double));
    for (int k = 0; k < 2; k++) memset(t->before[k], 0, t->n * t->lines * sizeof(double));
    memset(t->memory, 0, t->lines * t->remembered * sizeof(double));
    sm_marched_start(&t->marched);
}

/* Contacts at rest, and the response that the point is to begin with. */
static void start(problem *t) {
    const size_t all = per_point(t);
    start_again(t);
    memset(t->response, 0, all * sizeof(double));
    memset(t->Y, 0, all * sizeof(double));
    const sm_modal_response *response = t->contact->response;
    if (!response || !response->start) return;
    memcpy(t->Y, response->start, all * sizeof(double));
    find_change(t);
    memcpy(t->response, t->change, all * sizeof(double));
}

/* Harmonics of u along the lines: of the modes at their carriers, and of their response. */
static void draw(problem *t, const double *amplitude) {
    const size_t n = t->n, lines = t->lines;
    for (size_t q = 0; q < t->orders; q++) {
        const int32_t *order = t->task->orders + 2 * q;
        for (size_t i = 0; i < n; i++) {
            double re = 2.0 * t->response[2 * (q * n + i)];
            double im = 2.0 * t->response[2 * (q * n + i) + 1];
            for (int j = 0; j < t->contact->modes; j++) {
                if (order[0] != (j == 0) || order[1] != (j == 1)) continue;
                const double *L = t->contact->coupling + 2 * ((size_t)j * n + i);
                re -= 2.0 * L[0] * amplitude[j];
                im -= 2.0 * L[1] * amplitude[j];
            }
            double *to = t->drawn + 2 * (q * n + i) * lines;
            for (size_t p = 0; p < lines; p++) {
                double c, s;
                sm_torus_power(t->phase[p], t->phase[lines + p], order[1], &c, &s);
                to[p] = re * c - im * s;
                to[lines + p] = re * s + im * c;
            }
        }
    }
}

/* u (N_c, lines) at a step. */
static void displace(problem *t, size_t step) {
    const size_t lines = t->lines;
    memset(t->u, 0, t->n * lines * sizeof(double));
    for (size_t q = 0; q < t->orders; q++) {
        const double c = t->turn[2 * (step * t->orders + q)];
        const double s = t->turn[2 * (step * t->orders + q) + 1];
        for (size_t i = 0; i < t->n; i++) {
            const double *restrict re = t->drawn + 2 * (q * t->n + i) * lines;
            const double *restrict im = re + lines;
            double *restrict u = t->u + i * lines;
            SM_SIMD
            for (size_t p = 0; p < lines; p++) u[p] += re[p] * c - im[p] * s;
        }
    }
}

/* y (N_c, lines) at a step. */
static sm_status react(problem *t) {
    const size_t n = t->n, lines = t->lines;
    for (size_t p = 0; p < lines; p++) {
        double *x = t->x + p * n, *memory = t->memory + p * t->remembered;
        double *last = t->before[0] + p * n, *last_but_one = t->before[1] + p * n;
        memcpy(last_but_one, last, n * sizeof(double));
        memcpy(last, x, n * sizeof(double));
        for (size_t i = 0; i < n; i++) t->own_u[i] = t->u[i * lines + p];
        sm_marched_displace(&t->marched, p, t->own_u);
        for (size_t i = 0; i < n; i++) {
            x[i] += t->own_u[i] - t->last_u[i * lines + p]; /* as if nothing slipped */
            t->last_u[i * lines + p] = t->own_u[i];
        }
        const sm_status status = sm_elastic_solve(&t->solver, t->own_u, memory, x);
        if (status != SM_OK) return status;
        memcpy(memory, t->solver.next, t->remembered * sizeof(double));
        const double *const steps[3] = {last_but_one, last, x};
        sm_elastic_reverse(t->contact->elastic, steps, memory);
        sm_marched_advance(&t->marched, p, t->solver.y);
        for (size_t i = 0; i < n; i++) {
            const double y = t->solver.y[i];
            t->y[i * lines + p] = y;
            t->square[i] += y * y;
        }
    }
    return SM_OK;
}

static void add_harmonics(problem *t, size_t step, double weight) {
    const size_t lines = t->lines;
    for (size_t q = 0; q < t->orders; q++) {
        const double c = weight * t->turn[2 * (step * t->orders + q)];
        const double s = weight * t->turn[2 * (step * t->orders + q) + 1];
        for (size_t i = 0; i < t->n; i++) {
            double *restrict re = t->sums + 2 * (q * t->n + i) * lines;
            double *restrict im = re + lines;
            const double *restrict y = t->y + i * lines;
            SM_SIMD
            for (size_t p = 0; p < lines; p++) {
                re[p] += y[p] * c;
                im[p] -= y[p] * s;
            }
        }
    }
}

/* Means over steps and lines. The mean itself is (0, 0): of two conjugates one half. */
static void collect(problem *t) {
    const size_t lines = t->lines;
    for (size_t q = 0; q < t->orders; q++) {
        const int32_t *order = t->task->orders + 2 * q;
        const double weight = (order[0] == 0 && order[1] == 0 ? 0.5 : 1.0)
                              / ((double)t->steps * (double)lines);
        for (size_t i = 0; i < t->n; i++) {
            const double *re = t->sums + 2 * (q * t->n + i) * lines, *im = re + lines;
            double *Y = t->Y + 2 * (q * t->n + i);
            Y[0] = Y[1] = 0.0;
            for (size_t p = 0; p < lines; p++) {
                double c, s;
                sm_torus_power(t->phase[p], t->phase[lines + p], -order[1], &c, &s);
                Y[0] += weight * (re[p] * c - im[p] * s);
                Y[1] += weight * (re[p] * s + im[p] * c);
            }
        }
    }
}

/* Phases at the end of a period of mode A. */
static void turn_lines(problem *t) {
    const double c = cos(SM_TWO_PI * t->ratio), s = sin(SM_TWO_PI * t->ratio);
    for (size_t p = 0; p < t->lines; p++) {
        const double re = t->phase[p], im = t->phase[t->lines + p];
        t->phase[p] = re * c - im * s;
        t->phase[t->lines + p] = re * s + im * c;
    }
}

/* What line p remembers at the end of a period is what line p + shift began it with, once the motion
 * is periodic. A slider that has not moved on a line brings that on at once from the last line
 * before on which it has, or else from the mean of them all: it could rest anywhere. */
static void carry_over(problem *t, size_t slider) {
    const size_t lines = t->lines, stride = t->remembered;
    double *now = t->memory + slider, mean = 0.0;
    const double *begun = t->begun + slider;
    for (size_t p = 0; p < lines; p++) mean += now[p * stride] / (double)lines;
    for (size_t p = 0; p < lines; p++) {
        size_t from = p;
        do from = (from + lines - t->shift) % lines;
        while (from != p && now[from * stride] == begun[from * stride]);
        if (now[p * stride] != begun[p * stride]) continue;
        now[p * stride] = from == p ? mean : now[from * stride];
    }
}

static void carry_sliders_over(problem *t) {
    const sm_elastic *elastic = t->contact->elastic;
    size_t at = 0;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        const int count = element->law == SM_SLIDERS ? element->sliders : element->tangents;
        for (size_t k = 0; k < (size_t)count; k++) carry_over(t, at + k);
        at += (size_t)sm_element_memory(element);
    }
}

/* One period of mode A: from the response to the harmonics Y. */
static sm_status march(problem *t, const double *amplitude) {
    draw(t, amplitude);
    memset(t->sums, 0, per_point(t) * t->lines * sizeof(double));
    memset(t->square, 0, t->n * sizeof(double));
    memcpy(t->begun, t->memory, t->lines * t->remembered * sizeof(double));
    for (size_t k = 0; k < t->steps; k++) {
        displace(t, k);
        const sm_status status = react(t);
        if (status != SM_OK) return status;
        add_harmonics(t, k, 1.0);
    }
    collect(t);
    turn_lines(t);
    if (t->shift > 0) carry_sliders_over(t);
    return sm_all_finite(t->Y, per_point(t)) && sm_all_finite(t->square, t->n) ? SM_OK
                                                                               : SM_NOT_FINITE;
}

static double largest_difference(const double *a, const double *b, size_t count) {
    double largest = 0.0;
    for (size_t k = 0; k < count; k++) largest = fmax(largest, fabs(a[k] - b[k]));
    return largest;
}

/* Displacement and force [m], [N] that the modes bring to contacts that stick. */
static void scales(const problem *t, const double *amplitude, double *displacement,
                   double *force) {
    *displacement = *force = 0.0;
    for (int j = 0; j < t->contact->modes; j++) {
        const double least = t->task->smallest_scale[j];
        const double a = amplitude[j] > least ? amplitude[j] : least;
        for (size_t i = 0; i < t->n; i++) {
            const double *L = t->contact->coupling + 2 * ((size_t)j * t->n + i);
            const double moved = hypot(L[0], L[1]) * a;
            *displacement = fmax(*displacement, moved);
            *force = fmax(*force, moved * t->contact->elastic->reference[i]);
        }
    }
}

/* How far harmonics and response are from repeating, relative to what the modes bring. */
static double distance(problem *t, double displacement, double force) {
    const double change = find_change(t) / fmax(displacement, 1e-300);
    const double moved =
        largest_difference(t->Y, t->last_Y, per_point(t)) / fmax(force, 1e-300);
    return fmax(change, moved);
}

/* Harmonics and squares as means over so many periods under the same response. */
static sm_status evaluate(problem *t, const double *amplitude, int count) {
    const size_t all = per_point(t);
    memcpy(t->last_Y, t->Y, all * sizeof(double));
    if (count == 1) return march(t, amplitude);
    memset(t->mean, 0, (all + t->n) * sizeof(double));
    for (int k = 0; k < count; k++) {
        const sm_status status = march(t, amplitude);
        if (status != SM_OK) return status;
        for (size_t i = 0; i < all; i++) t->mean[i] += t->Y[i] / count;
        for (size_t i = 0; i < t->n; i++) t->mean[all + i] += t->square[i] / count;
    }
    memcpy(t->Y, t->mean, all * sizeof(double));
    memcpy(t->square, t->mean + all, t->n * sizeof(double));
    return SM_OK;
}

/* Iterates until harmonics and response repeat, or come no nearer. */
static sm_status settle(problem *t, const double *amplitude, int count, const double scale[2],
                        double *residual, int32_t *periods) {
    const sm_torus_task *task = t->task;
    sm_fixed_point_start(&t->search);
    const int32_t until = *periods + task->max_periods;
    for (int open = 1; open && *periods < until;) {
        const sm_status status = evaluate(t, amplitude, count);
        if (status != SM_OK) return status;
        *residual = distance(t, scale[0], scale[1]);
        *periods += count;
        if (*periods < 2) continue; /* the first one forgets the start */
        if (*residual <= task->tolerance) return SM_OK;
        open = sm_fixed_point_next(&t->search, *residual, t->change, t->response);
    }
    return SM_OK;
}

/* From small amplitudes, where the response is that of contacts that stick, up to the point's. */
static sm_status climb(problem *t, const double *amplitude, const double scale[2],
                       double *residual, int32_t *periods) {
    double some[SM_MODES] = {0.0}, reached = 0.0;
    for (size_t rung = 0; rung < SM_RUNGS; rung++) {
        const double part = SM_LADDER[rung];
        for (size_t i = 0; i < per_point(t); i++)
            t->response[i] = reached > 0.0 ? t->response[i] * part / reached : 0.0;
        for (int j = 0; j < t->contact->modes; j++) some[j] = part * amplitude[j];
        const sm_status status = settle(t, some, 1, scale, residual, periods);
        if (status != SM_OK) return status;
        reached = part;
    }
    return SM_OK;
}

static sm_status solve_point(problem *t, size_t point) {
    const sm_torus_task *task = t->task;
    const size_t all = per_point(t);
    const double *amplitude = task->amplitudes + point * (size_t)t->contact->modes;
    double scale[2], residual = INFINITY;
    int32_t periods = 0;
    scales(t, amplitude, &scale[0], &scale[1]);
    t->solver.least = LEAST * scale[0];
    const int begun = t->contact->response && t->contact->response->start;
    sm_status status = SM_OK;
    if (t->follows) {
        start_again(t);
        status = settle(t, amplitude, 1, scale, &residual, &periods);
    }
    if (status == SM_OK && residual > SM_ALMOST) {
        start(t);
        status = settle(t, amplitude, 1, scale, &residual, &periods);
    }
    if (status == SM_OK && residual > SM_ALMOST && !begun)
        status = climb(t, amplitude, scale, &residual, &periods);
    for (int count = 4; count <= MOST_AVERAGED && status == SM_OK; count *= 4)
        if (residual > task->tolerance)
            status = settle(t, amplitude, count, scale, &residual, &periods);
    if (status != SM_OK) return status;
    if (residual > task->tolerance) {
        status = evaluate(t, amplitude, MOST_AVERAGED);
        if (status != SM_OK) return status;
        residual = distance(t, scale[0], scale[1]);
        periods += MOST_AVERAGED;
    }
    memcpy(task->harmonics + point * all, t->Y, all * sizeof(double));
    for (size_t i = 0; i < t->n; i++)
        task->mean_square[point * t->n + i] = t->square[i] / ((double)t->steps * (double)t->lines);
    if (!sm_all_finite(t->Y, all) || !sm_all_finite(t->square, t->n)) return SM_NOT_FINITE;
    t->follows = residual <= SM_ALMOST && !begun;
    task->residual[point] = residual;
    task->marched[point] = periods * task->steps;
    return SM_OK;
}

sm_status sm_torus_elastic(const sm_contact *contact, const sm_torus_task *task) {
    problem t;
    sm_status status = make(&t, contact, task);
    for (size_t point = 0; point < task->points && status == SM_OK; point++)
        status = solve_point(&t, point);
    free(t.block);
    return status;
}

/* From rest, `settling` periods and one in which the hat rises, through the amplitudes, to the end
 * of the period in which it falls. */
static sm_status grow_through(problem *t, size_t point, const double *growth, int settling) {
    const size_t modes = (size_t)t->contact->modes, all = per_point(t);
    const double *amplitude = t->task->amplitudes + point * modes, *by = growth + point * modes;
    double *harmonics = t->task->harmonics + point * all;
    double now[SM_MODES] = {0.0}, moved, force;
    for (size_t j = 0; j < modes; j++) now[j] = fabs(amplitude[j]) + (settling + 1) * fabs(by[j]);
    scales(t, now, &moved, &force);
    t->solver.least = LEAST * moved;
    start(t);
    memset(harmonics, 0, all * sizeof(double));
    for (int period = -settling - 1; period < 1; period++) {
        memset(t->sums, 0, all * t->lines * sizeof(double));
        for (size_t k = 0; k < t->steps; k++) {
            const double elapsed = period + (double)(k + 1) / (double)t->steps; /* periods */
            const double hat = 1.0 - fabs(elapsed);
            for (size_t j = 0; j < modes; j++) now[j] = amplitude[j] + elapsed * by[j];
            draw(t, now);
            displace(t, k);
            const sm_status status = react(t);
            if (status != SM_OK) return status;
            if (hat > 0.0) add_harmonics(t, k, hat);
        }
        collect(t);
        for (size_t i = 0; i < all; i++) harmonics[i] += t->Y[i];
        turn_lines(t);
    }
    return sm_all_finite(harmonics, all) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_torus_elastic_growing(const sm_contact *contact, const sm_torus_task *task,
                                   const double *growth, int settling) {
    problem t;
    sm_status status = make(&t, contact, task);
    for (size_t point = 0; point < task->points && status == SM_OK; point++)
        status = grow_through(&t, point, growth, settling);
    free(t.block);
    return status;
}

/* Periodic motion of elastic contacts on the torus, by characteristics.
 *
 * As for rigid contacts (torus.c) `lines` phase lines with t_B0 = 2 pi p / lines are marched period
 * by period of mode A, and modes with them (marched.h). What else the modes respond to the
 * harmonics of one period draws the contacts in the next: a fixed point, which Anderson's
 * acceleration finds also where plain passes diverge.
 */
#include "torus/torus.h"

#include <stdlib.h>

#include "base/check.h"
#include "contact/elastic/reversal.h"
#include "contact/elastic/solve.h"
#include "torus/fixed_point/marched.h"
#include "torus/fixed_point/phase_lines.h"
#include "torus/fixed_point/search.h"
#include "torus/periodic/sliders.h"

#define MOTIONS 7
/* Convergence tolerance for slider harmonics that are not requested, relative to `tolerance`, and
 * its bound: where a contact slips on few lines, they keep changing by the error of the grid.
 * Not for contacts that open: they have several motions, and the search would stop between them. */
#define NOT_REQUESTED 32.0
#define NOT_REQUESTED_MOST 3e-3
#define LEAST 1e-3 /* of the displacement of contacts that stick: the solver takes no less */

typedef struct {
    const sm_contact *contact;
    const sm_torus_task *task;
    size_t n, remembered, requested; /* the first numbers of Y are requested */
    sm_phase_lines lines;      /* u and y along them */
    double *flexibility;       /* (N_c, N_c) R */
    double *drawing;           /* (orders, N_c, 2) harmonics of u */
    double *motion;            /* (MOTIONS, lines, N_c): */
    double *x, *last_u;
    double *last_y, *last_off; /* y and residual of the last step, for the solver */
    double *before[2];         /* x without what the contact itself gives way, one and two steps
                                  before */
    double *correction;            /* correction of y at the last step: see reversal.h */
    double *memory;            /* (lines, remembered) */
    int32_t *yielded;          /* (lines) whether contacts did not stick at the step before */
    int follows;               /* the response of the point before is a good start */
    double *at_start;             /* (lines, remembered) memory as the period began */
    size_t taken;              /* steps of the point so far */
    int half;                  /* of a period is marched, and what then changes its sign */
    size_t shift;              /* line p ends it where p + shift began it; 0: nowhere */
    sm_places places;          /* of what is remembered, where it `lingers` */
    double *gives;             /* (N_c) see sm_reversal */
    double *own_u, *own_x, *own_z, *own_y, *own_correction; /* (N_c) of one line */
    double *square;            /* (N_c) sum of y^2 */
    double *Y, *last_Y;        /* (orders, N_c, 2) harmonics of this and of the last period */
    double *response, *change; /* (orders, N_c, 2) the modes' response, and what it is off by; then
                                  memory by places, and what that is off by */
    double *mean;              /* (orders, N_c, 2) and (N_c): of harmonics and squares */
    sm_elastic_solver solver;
    sm_marched marched;
    sm_fixed_point search;
    double *block;
} problem;

static size_t per_point(const problem *t) { return t->lines.orders * t->n * 2; }

/* Steps of the march from one set of harmonics to the next. */
static size_t marched_steps(const problem *t) { return t->lines.steps / (t->half ? 2 : 1); }

/* By how many lines their ends lie behind their beginnings; 0 where they are not closed, the ratio
 * no multiple of 1 / lines, or the ends of half a period lie between the lines. */
static size_t shift_of(const problem *t, int half) {
    const double lines = (double)t->lines.lines, turns = t->lines.ratio * lines;
    const double whole = nearbyint(turns), by = half ? 0.5 * (whole - lines) : whole;
    if (fabs(turns - whole) >= 1e-9 * turns || by != nearbyint(by)) return 0;
    return (size_t)(fmod(by, lines) + lines) % t->lines.lines;
}

/* Under forces with odd harmonics alone, sliders repeat half a period with opposite sign. */
static int is_odd(const problem *t) {
    if (!t->solver.slides) return 0;
    for (size_t q = 0; q < t->lines.orders; q++)
        if ((t->lines.order[2 * q] + t->lines.order[2 * q + 1]) % 2 == 0) return 0;
    return t->lines.steps % 2 == 0;
}

/* A slider forgets its position as soon as it slides. One that slides in two directions keeps a part
 * of it for many periods: then the memory of the contacts is among the unknowns. */
static int lingers(const problem *t) {
    const int closed = t->contact->modes == 1 || shift_of(t, 0) > 0;
    return closed && sm_elastic_slides_in_two(t->contact->elastic);
}

/* Sets the march to half periods if they suffice, else to whole ones. */
static void march_by(problem *t, int half) {
    t->half = half && is_odd(t) && (t->contact->modes == 1 || shift_of(t, 1) > 0);
    t->shift = shift_of(t, t->half);
}

static void place(problem *t, sm_block *block) {
    const sm_contact *contact = t->contact;
    const size_t n = t->n, lines = t->lines.lines, all = per_point(t);
    const size_t unknowns = all + sm_places_size(&t->places);
    sm_phase_lines_place(&t->lines, block);
    t->flexibility = sm_take(block, n * n);
    t->motion = sm_take(block, 0);
    double **motion[MOTIONS] = {&t->x,         &t->last_u,    &t->last_y, &t->last_off,
                                &t->before[0], &t->before[1], &t->correction};
    for (int k = 0; k < MOTIONS; k++) *motion[k] = sm_take(block, n * lines);
    t->yielded = (void *)sm_take(block, sm_doubles(lines * sizeof(int32_t)));
    t->memory = sm_take(block, lines * t->remembered);
    t->at_start = sm_take(block, lines * t->remembered);
    double **own[] = {&t->gives, &t->own_u, &t->own_x,          &t->own_z,
                      &t->own_y, &t->square, &t->own_correction};
    for (size_t k = 0; k < sizeof own / sizeof *own; k++) *own[k] = sm_take(block, n);
    double **harmonics[] = {&t->drawing, &t->Y, &t->last_Y};
    for (size_t k = 0; k < sizeof harmonics / sizeof *harmonics; k++)
        *harmonics[k] = sm_take(block, all);
    t->response = sm_take(block, unknowns);
    t->change = sm_take(block, unknowns);
    t->mean = sm_take(block, all + n);
    sm_fixed_point_place(&t->search, unknowns, block);
    sm_marched_place(&t->marched, contact->response, n, t->lines.stride, block);
    sm_elastic_solver_place(&t->solver, contact->elastic, contact->contacts, t->flexibility,
                            block);
}

static sm_status make(problem *t, const sm_contact *contact, const sm_torus_task *task) {
    const size_t n = (size_t)contact->contacts, lines = (size_t)task->grid->lines;
    const size_t orders = (size_t)task->grid->orders_count;
    const size_t requested = contact->response ? (size_t)contact->response->asked : 0;
    *t = (problem){.contact = contact, .task = task, .n = n,
                   .remembered = sm_elastic_memory(contact->elastic),
                   .requested = 2 * n * (requested > 0 ? requested : orders)};
    const double ratio = contact->modes == 2 ? task->grid->rates[1] / task->grid->rates[0] : 0.0;
    t->lines = (sm_phase_lines){.contacts = n, .orders = orders, .lines = lines,
                                .steps = (size_t)task->grid->steps, .order = task->grid->orders,
                                .ratio = ratio};
    t->places = (sm_places){.lines = lines, .size = lingers(t) ? t->remembered : 0};
    sm_block block = {NULL, 0};
    place(t, &block);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    t->block = block.memory;
    place(t, &block);
    for (size_t k = 0; k < n * n; k++) t->flexibility[k] = -contact->stiffness[k];
    if (t->solver.slides)
        for (size_t i = 0; i < n; i++) t->gives[i] = t->flexibility[i * n + i];
    return SM_OK;
}

/* change = H Y + held - response; the largest of it [m]. */
static double find_change(problem *t) {
    const sm_modal_response *response = t->contact->response;
    double largest = 0.0;
    if (!response || !response->dynamic_stiffness) return 0.0;
    sm_respond(response, t->lines.orders, t->n, t->Y, t->change);
    for (size_t k = 0; k < per_point(t); k += 2) {
        t->change[k] -= t->response[k];
        t->change[k + 1] -= t->response[k + 1];
        largest = fmax(largest, hypot(t->change[k], t->change[k + 1]));
    }
    return largest;
}

/* Contacts at rest. */
static void start_again(problem *t) {
    const size_t lines = t->lines.lines;
    sm_phase_lines_start(&t->lines);
    t->places.turned = 0;
    memset(t->motion, 0, MOTIONS * t->n * lines * sizeof(double));
    memset(t->yielded, 0, lines * sizeof(int32_t));
    memset(t->memory, 0, lines * t->remembered * sizeof(double));
    sm_marched_start(&t->marched);
}

/* Contacts at rest, and the response and motion of modes to harmonics Y; to none: NULL. */
static void start(problem *t, const double *Y) {
    const size_t all = per_point(t);
    start_again(t);
    memset(t->response, 0, all * sizeof(double));
    memset(t->Y, 0, all * sizeof(double));
    if (!Y) return;
    memcpy(t->Y, Y, all * sizeof(double));
    sm_marched_begin(&t->marched, &t->lines, t->Y);
    if (t->solver.jenkins)
        sm_place_sliders(&t->lines, t->contact->elastic->reference, t->Y, t->memory);
    find_change(t);
    memcpy(t->response, t->change, all * sizeof(double));
}

/* Harmonics of u along the lines: of the modes at their carriers, and of their response. */
static void draw(problem *t, const double *amplitude) {
    const size_t n = t->n;
    for (size_t k = 0; k < per_point(t); k++) t->drawing[k] = 2.0 * t->response[k];
    for (size_t q = 0; q < t->lines.orders; q++)
        for (int j = 0; j < t->contact->modes; j++) {
            const int32_t *order = t->task->grid->orders + 2 * q;
            if (order[0] != (j == 0) || order[1] != (j == 1)) continue;
            const double *L = t->contact->coupling + 2 * (size_t)j * n;
            for (size_t k = 0; k < 2 * n; k++)
                t->drawing[2 * q * n + k] -= 2.0 * L[k] * amplitude[j];
        }
    sm_phase_lines_draw(&t->lines, t->drawing);
}

/* Corrects the sliders that turned back between the last two steps of a line, and y for it. */
static void reverse(problem *t, size_t p, double *memory) {
    const size_t n = t->n;
    const sm_reversal reversal = {
        .x = t->own_x, .z = {t->before[1] + p * n, t->before[0] + p * n, t->own_z},
        .gives = t->gives, .now = t->solver.slides ? t->own_y : NULL, .before = t->own_correction};
    sm_elastic_reverse(t->contact->elastic, &reversal, memory);
}

/* y of a line under the u of a step, both (N_c) with so many between them; y without, too. */
static sm_status react(problem *t, size_t p, const double *u, double *y, double *y_of_line) {
    const size_t n = t->n, stride = t->lines.stride;
    double *x = t->x + p * n, *last_u = t->last_u + p * n, *memory = t->memory + p * t->remembered;
    double *last_y = t->last_y + p * n, *correction = t->correction + p * n;
    double *last = t->before[0] + p * n, *last_but_one = t->before[1] + p * n;
    memcpy(t->own_x, x, n * sizeof(double));
    for (size_t i = 0; i < n; i++) {
        t->own_u[i] = u[i * stride];
        x[i] += t->own_u[i] - last_u[i]; /* as if nothing slipped */
        last_u[i] = t->own_u[i];
    }
    const sm_status status =
        sm_elastic_follow(&t->solver, t->own_u, memory, x, last_y, t->last_off + p * n);
    if (status != SM_OK) return status;
    memcpy(t->own_y, t->solver.y, n * sizeof(double));
    memset(t->own_correction, 0, n * sizeof(double));
    if (t->solver.slides && t->solver.yielding > 0)
        sm_elastic_begin(&t->solver, t->own_x, memory, t->own_y);
    memcpy(memory, t->solver.next, t->remembered * sizeof(double));
    for (size_t i = 0; i < n; i++) t->own_z[i] = x[i] - t->gives[i] * t->solver.y[i];
    if (t->yielded[p]) reverse(t, p, memory);
    t->yielded[p] = t->solver.yielding > 0;
    memcpy(last_but_one, last, n * sizeof(double));
    memcpy(last, t->own_z, n * sizeof(double));
    for (size_t i = 0; i < n; i++) {
        /* the correction of the step before is added now: for the modes once; for means over steps
         * by linear extrapolation through this step and the last */
        y[i * stride] = t->own_y[i] + t->own_correction[i];
        y_of_line[i] = t->own_y[i] + 2.0 * t->own_correction[i] - correction[i];
        correction[i] = t->own_correction[i];
        t->square[i] += y_of_line[i] * y_of_line[i];
    }
    return SM_OK;
}

/* y along the lines at some steps. */
static sm_status react_along(problem *t, size_t count) {
    const size_t all = t->n * t->lines.stride, row = t->lines.row;
    for (size_t k = 0; k < count; k++) {
        double *u = t->lines.u + k * all, *y = t->lines.y + k * all;
        double *y_of_line = t->lines.y_of_line + k * t->lines.lines * row;
        sm_marched_displace(&t->marched, u);
        for (size_t p = 0; p < t->lines.lines; p++) {
            const sm_status status = react(t, p, u + p, y + p, y_of_line + p * row);
            if (status != SM_OK) return status;
        }
        sm_marched_advance(&t->marched, y);
    }
    return SM_OK;
}

static void negate(double *values, size_t count) {
    for (size_t k = 0; k < count; k++) values[k] = -values[k];
}

/* What the contacts come to half a period later begins the next half with another sign. */
static void turn_round(problem *t) {
    negate(t->motion, MOTIONS * t->n * t->lines.lines);
    negate(t->memory, t->lines.lines * t->remembered);
    negate(t->marched.state, sm_marched_size(t->contact->response, t->lines.stride));
}

/* A period of mode A, or half of one: from the response to the harmonics Y. */
static sm_status march(problem *t, const double *amplitude) {
    static const double weights[SM_TOGETHER] = {1.0, 1.0, 1.0, 1.0};
    const size_t steps = marched_steps(t);
    draw(t, amplitude);
    sm_phase_lines_clear(&t->lines);
    memset(t->square, 0, t->n * sizeof(double));
    memcpy(t->at_start, t->memory, t->lines.lines * t->remembered * sizeof(double));
    for (size_t k = 0; k < steps; k += SM_TOGETHER) {
        const size_t left = steps - k;
        const size_t count = left < SM_TOGETHER ? left : SM_TOGETHER;
        sm_phase_lines_displace(&t->lines, k, count);
        const sm_status status = react_along(t, count);
        if (status != SM_OK) return status;
        sm_phase_lines_add(&t->lines, k, count, weights);
    }
    sm_phase_lines_collect(&t->lines, steps, t->Y);
    for (size_t i = 0; i < t->n; i++) t->square[i] /= (double)(steps * t->lines.lines);
    t->taken += steps;
    sm_phase_lines_turn(&t->lines, t->half);
    t->places.turned = (t->places.turned + t->shift) % t->lines.lines;
    if (t->half || t->shift > 0) {
        const sm_period period = {t->lines.lines, t->remembered, t->shift, t->half, t->at_start};
        sm_carry_sliders_over(t->contact->elastic, &period, t->memory);
    }
    if (t->half) turn_round(t);
    return sm_all_finite(t->Y, per_point(t)) && sm_all_finite(t->square, t->n) ? SM_OK
                                                                               : SM_NOT_FINITE;
}

/* Displacement and force [m], [N] that the modes bring to contacts that stick. */
static void scales(const problem *t, const double *amplitude, double *displacement,
                   double *force) {
    *displacement = *force = 0.0;
    for (int j = 0; j < t->contact->modes; j++) {
        const double a = fmax(amplitude[j], t->task->grid->smallest_scale[j]);
        for (size_t i = 0; i < t->n; i++) {
            const double *L = t->contact->coupling + 2 * ((size_t)j * t->n + i);
            const double moved = hypot(L[0], L[1]) * a;
            *displacement = fmax(*displacement, moved);
            *force = fmax(*force, moved * t->contact->elastic->reference[i]);
        }
    }
}

/* The change of harmonics and response over a period, relative to the displacement and force that
 * the modes cause; relative to the force deficit where contacts slide so far that it is larger. */
static double distance(problem *t, double displacement, double force) {
    const size_t all = per_point(t), requested = t->solver.slides ? t->requested : all;
    const double least = t->task->grid->tolerance / NOT_REQUESTED_MOST;
    const double others = fmin(fmax(1.0 / NOT_REQUESTED, least), 1.0);
    const double change = find_change(t) / fmax(displacement, 1e-300);
    double moved = 0.0, largest = fmax(force, 1e-300);
    for (size_t k = 0; k < all; k++) {
        moved = fmax(moved, fabs(t->Y[k] - t->last_Y[k]) * (k < requested ? 1.0 : others));
        largest = fmax(largest, fabs(t->Y[k]));
    }
    return fmax(change, moved / largest);
}

/* Harmonics and mean squares over so many marches under the same response. */
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

/* Iterates until harmonics and response repeat or the residual stops falling. */
static sm_status iterate(problem *t, const double *amplitude, int count, const double scale[2],
                        double *residual) {
    const sm_torus_task *task = t->task;
    double *at_start = t->response + per_point(t), *off = t->change + per_point(t);
    sm_fixed_point_start(&t->search);
    int32_t marches = 0;
    for (int open = 1; open && marches < task->grid->max_periods; marches += count) {
        sm_places_take(&t->places, t->memory, at_start);
        const sm_status status = evaluate(t, amplitude, count);
        if (status != SM_OK) return status;
        *residual = distance(t, scale[0], scale[1]);
        if (t->taken < 2 * marched_steps(t)) continue; /* the first one forgets the start */
        if (*residual <= task->grid->tolerance) return SM_OK;
        sm_places_take(&t->places, t->memory, off);
        for (size_t k = 0; k < sm_places_size(&t->places); k++) off[k] -= at_start[k];
        open = sm_fixed_point_next(&t->search, *residual, t->change, t->response);
        sm_places_give(&t->places, at_start, t->memory);
    }
    return SM_OK;
}

/* Returns whether the residual is so small that means over periods will converge. */
static int almost(const problem *t, double residual) {
    return residual <= fmax(SM_ALMOST, t->task->grid->tolerance);
}

/* Continues the point from small amplitudes, at which the contacts stick, to its own. */
static sm_status continue_from_rest(problem *t, const double *amplitude, const double scale[2],
                       double *residual) {
    double some[SM_MODES] = {0.0}, reached = 0.0;
    for (size_t rung = 0; rung < SM_RUNGS; rung++) {
        const double part = SM_LADDER[rung];
        for (size_t i = 0; i < per_point(t); i++)
            t->response[i] = reached > 0.0 ? t->response[i] * part / reached : 0.0;
        for (int j = 0; j < t->contact->modes; j++) some[j] = part * amplitude[j];
        const sm_status status = iterate(t, some, 1, scale, residual);
        if (status != SM_OK) return status;
        reached = part;
    }
    return SM_OK;
}

/* Solves a point by half periods or whole ones. Starts are the initial guess or the point before,
 * then the common start, then small amplitudes; close to the motion, means over periods follow. */
static sm_status solve_by(problem *t, int half, size_t point, const double *amplitude,
                           const double scale[2], double *residual) {
    const sm_modal_response *response = t->contact->response;
    const double *at_start = response ? response->start : NULL;
    sm_status status = SM_OK;
    march_by(t, half);
    if (t->task->points->near || t->follows) {
        if (t->task->points->near)
            start(t, t->task->points->near + point * per_point(t));
        else
            start_again(t);
        status = iterate(t, amplitude, 1, scale, residual);
    }
    if (status == SM_OK && !almost(t, *residual)) {
        start(t, at_start);
        status = iterate(t, amplitude, 1, scale, residual);
    }
    if (t->half && *residual > t->task->grid->tolerance) return status;
    if (status == SM_OK && !almost(t, *residual) && !at_start)
        status = continue_from_rest(t, amplitude, scale, residual);
    for (int count = 4; count <= SM_MOST_AVERAGED && status == SM_OK; count *= 4)
        if (*residual > t->task->grid->tolerance)
            status = iterate(t, amplitude, count, scale, residual);
    if (status == SM_OK && *residual > t->task->grid->tolerance) {
        status = evaluate(t, amplitude, SM_MOST_AVERAGED);
        *residual = distance(t, scale[0], scale[1]);
    }
    return status;
}

static sm_status solve_point(problem *t, size_t point) {
    const sm_torus_task *task = t->task;
    const size_t all = per_point(t);
    const double *amplitude = task->points->amplitudes + point * (size_t)t->contact->modes;
    double scale[2], residual = INFINITY;
    scales(t, amplitude, &scale[0], &scale[1]);
    t->solver.least = LEAST * scale[0];
    t->taken = 0;
    sm_status status = solve_by(t, 1, point, amplitude, scale, &residual);
    if (status == SM_OK && t->half && residual > task->grid->tolerance)
        status = solve_by(t, 0, point, amplitude, scale, &residual);
    if (status != SM_OK) return status;
    memcpy(task->motion->harmonics + point * all, t->Y, all * sizeof(double));
    memcpy(task->motion->mean_square + point * t->n, t->square, t->n * sizeof(double));
    if (!sm_all_finite(t->Y, all) || !sm_all_finite(t->square, t->n)) return SM_NOT_FINITE;
    t->follows = almost(t, residual) && !(t->contact->response && t->contact->response->start);
    task->motion->residual[point] = residual;
    task->motion->marched[point] = (int32_t)t->taken;
    return SM_OK;
}

sm_status sm_torus_elastic(const sm_contact *contact, const sm_torus_task *task) {
    problem t;
    sm_status status = make(&t, contact, task);
    for (size_t point = 0; point < task->points->count && status == SM_OK; point++)
        status = solve_point(&t, point);
    free(t.block);
    return status;
}

/* From rest, `before` periods and one in which the hat rises, through the amplitudes, to the end
 * of the period in which it falls. */
static sm_status grow_through(problem *t, size_t point, const double *growth, int before) {
    const size_t modes = (size_t)t->contact->modes, all = per_point(t);
    const double *amplitude = t->task->points->amplitudes + point * modes;
    const double *by = growth + point * modes;
    double *harmonics = t->task->motion->harmonics + point * all;
    double now[SM_MODES] = {0.0}, moved, force;
    for (size_t j = 0; j < modes; j++) now[j] = fabs(amplitude[j]) + (before + 1) * fabs(by[j]);
    scales(t, now, &moved, &force);
    t->solver.least = LEAST * moved;
    march_by(t, 0);
    start(t, NULL);
    memset(harmonics, 0, all * sizeof(double));
    for (int period = -before - 1; period < 1; period++) {
        sm_phase_lines_clear(&t->lines);
        for (size_t k = 0; k < t->lines.steps; k++) {
            const double elapsed = period + (double)(k + 1) / (double)t->lines.steps; /* periods */
            const double hat = 1.0 - fabs(elapsed);
            for (size_t j = 0; j < modes; j++) now[j] = amplitude[j] + elapsed * by[j];
            draw(t, now);
            sm_phase_lines_displace(&t->lines, k, 1);
            const sm_status status = react_along(t, 1);
            if (status != SM_OK) return status;
            if (hat > 0.0) sm_phase_lines_add(&t->lines, k, 1, &hat);
        }
        sm_phase_lines_collect(&t->lines, t->lines.steps, t->Y);
        for (size_t i = 0; i < all; i++) harmonics[i] += t->Y[i];
        sm_phase_lines_turn(&t->lines, 0);
    }
    return sm_all_finite(harmonics, all) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_torus_elastic_growing(const sm_contact *contact, const sm_torus_task *task,
                                   const double *growth, int before) {
    problem t;
    sm_status status = make(&t, contact, task);
    for (size_t point = 0; point < task->points->count && status == SM_OK; point++)
        status = grow_through(&t, point, growth, before);
    free(t.block);
    return status;
}

#include "torus/elastic/elastic_lines.h"

#include <math.h>
#include <stdlib.h>

#include "base/check.h"
#include "contact/elastic/reversal.h"

/* Returns the doubles of the harmonics of y. */
static size_t harmonics_size(const sm_elastic_lines *e) {
    return 2 * e->lines.orders * e->lines.contacts;
}

/* ---- closed phase lines ---------------------------------------------------------------- */

/* Returns the number of lines from the start of a line to its end. It is 0 if the ratio is no
 * multiple of 1 / lines (open lines), or if half a period ends between two lines. */
static size_t shift_of(const sm_elastic_lines *e, int half) {
    const double lines = (double)e->lines.lines, turns = e->lines.ratio * lines;
    const double whole = nearbyint(turns), by = half ? 0.5 * (whole - lines) : whole;
    if (fabs(turns - whole) >= SM_ROUNDING_TOLERANCE * turns || by != nearbyint(by)) return 0;
    return (size_t)(fmod(by, lines) + lines) % e->lines.lines;
}

/* Chooses half or whole periods: sm_torus_law.by_halves. */
static int by_halves(sm_march *m, int half) {
    sm_elastic_lines *e = m->lines;
    /* if all harmonics are odd, sliders repeat with opposite sign after half a period */
    e->half = half && e->solver.slides && sm_is_odd(m->task->grid)
              && (e->contact->modes == 1 || shift_of(e, 1) > 0);
    e->shift = shift_of(e, e->half);
    return e->half;
}

/* Copies the memory (lines, memory_size) to or from the order in which the lines first started. */
static void exchange_memory(sm_march *m, double *by_place, int back) {
    const sm_elastic_lines *e = m->lines;
    for (size_t p = 0; p < e->lines.lines; p++) {
        double *of_line = e->memory + p * e->memory_size;
        double *place = by_place + (p + e->turned) % e->lines.lines * e->memory_size;
        memcpy(back ? of_line : place, back ? place : of_line, e->memory_size * sizeof(double));
    }
}

/* ---- start ----------------------------------------------------------------------------- */

void sm_elastic_lines_start(sm_elastic_lines *e, double displacement) {
    const size_t lines = e->lines.lines;
    e->solver.resolved = SM_LEAST_RESOLVED * displacement;
    e->turned = 0;
    sm_phases_start(&e->lines.phases);
    memset(e->history, 0, SM_HISTORIES * e->lines.contacts * lines * sizeof(double));
    memset(e->slipped, 0, lines * sizeof(int32_t));
    memset(e->memory, 0, lines * e->memory_size * sizeof(double));
    sm_marched_start(&e->marched);
}

/* Starts the contacts at a point: sm_torus_law.start. */
static void start(sm_march *m, const double *Y) {
    sm_elastic_lines *e = m->lines;
    const sm_scales scales =
        sm_scales_at(m->contact, sm_march_amplitudes(m, 0), m->task->grid->smallest_scale);
    sm_elastic_lines_start(e, scales.response);
    if (!Y) return;
    sm_marched_begin(&e->marched, &e->lines, Y);
    if (e->solver.slides) sm_place_sliders(e, Y);
}

/* ---- steps ----------------------------------------------------------------------------- */

void sm_elastic_lines_displace(sm_elastic_lines *e, const double *amplitude, const double *R) {
    const size_t n = e->lines.contacts, row = e->lines.row;
    for (size_t q = 0; q < e->lines.orders; q++) {
        double *re = e->lines.harmonics + 2 * q * row, *im = re + row;
        for (size_t i = 0; i < n; i++) {
            re[i] = R ? 2.0 * R[2 * (q * n + i)] : 0.0;
            im[i] = R ? 2.0 * R[2 * (q * n + i) + 1] : 0.0;
        }
        for (int j = 0; j < e->contact->modes; j++) {
            const int32_t *order = e->lines.order + 2 * q;
            const double *L = e->contact->coupling + 2 * (size_t)j * n;
            if (order[0] != (j == 0) || order[1] != (j == 1)) continue;
            for (size_t i = 0; i < n; i++) {
                re[i] -= 2.0 * L[2 * i] * amplitude[j];
                im[i] -= 2.0 * L[2 * i + 1] * amplitude[j];
            }
        }
    }
}

/* Corrects the sliders that turned back around the last step of line p, and y. */
static void reverse(sm_elastic_lines *e, size_t p) {
    const size_t at = p * e->lines.contacts;
    const sm_reversal reversal = {
        .x = e->x_before, .z = {e->stuck_x[1] + at, e->stuck_x[0] + at, e->own_stuck_x},
        .compliance = e->compliance, .now = e->solver.slides ? e->own_y : NULL,
        .before = e->own_correction};
    sm_elastic_reverse(e->contact->elastic, &reversal, e->memory + p * e->memory_size);
}

/* Solves a step of line p for its force deficit y under u. Entries of u and y for two contacts are
 * `stride` doubles apart; y_mean (N_c) includes the corrections for means over steps. */
static sm_status step_line(sm_elastic_lines *e, size_t p, const double *u, double *y,
                           double *y_mean) {
    const size_t n = e->lines.contacts, stride = e->lines.stride, at = p * n;
    double *x = e->x + at, *last_u = e->u + at, *memory = e->memory + p * e->memory_size;
    double *correction = e->correction + at;
    memcpy(e->x_before, x, n * sizeof(double));
    for (size_t i = 0; i < n; i++) {
        e->own_u[i] = u[i * stride];
        x[i] += e->own_u[i] - last_u[i]; /* as if nothing slipped */
        last_u[i] = e->own_u[i];
    }
    SM_TRY(sm_elastic_follow(&e->solver, e->own_u, memory, x, e->y + at));
    memcpy(e->own_y, e->solver.y, n * sizeof(double));
    memset(e->own_correction, 0, n * sizeof(double));
    if (e->solver.slides && e->solver.yielding > 0)
        sm_elastic_begin(&e->solver, e->x_before, memory, e->own_y);
    memcpy(memory, e->solver.next, e->memory_size * sizeof(double));
    for (size_t i = 0; i < n; i++) e->own_stuck_x[i] = x[i] - e->compliance[i] * e->solver.y[i];
    if (e->slipped[p]) reverse(e, p);
    sm_bound_sliders(e, p, x);
    e->slipped[p] = e->solver.yielding > 0;
    memcpy(e->stuck_x[1] + at, e->stuck_x[0] + at, n * sizeof(double));
    memcpy(e->stuck_x[0] + at, e->own_stuck_x, n * sizeof(double));
    for (size_t i = 0; i < n; i++) {
        /* the correction of the previous step is added now: once for the modes; for means over
         * steps by linear extrapolation through both steps */
        y[i * stride] = e->own_y[i] + e->own_correction[i];
        y_mean[i] = e->own_y[i] + 2.0 * e->own_correction[i] - correction[i];
        correction[i] = e->own_correction[i];
        e->square[i] += y_mean[i] * y_mean[i];
    }
    return SM_OK;
}

sm_status sm_elastic_lines_step(sm_elastic_lines *e, size_t first, size_t count, double weight) {
    const size_t all = e->lines.contacts * e->lines.stride, row = e->lines.row;
    sm_phase_lines_displace(&e->lines, first, count);
    for (size_t k = 0; k < count; k++) {
        double *u = e->lines.u + k * all, *y = e->lines.y + k * all;
        double *y_mean = e->lines.y_mean + k * e->lines.lines * row;
        sm_marched_displace(&e->marched, u);
        for (size_t p = 0; p < e->lines.lines; p++) {
            SM_TRY(step_line(e, p, u + p, y + p, y_mean + p * row));
        }
        sm_marched_advance(&e->marched, y);
    }
    if (weight > 0.0) sm_phase_lines_add(&e->lines, first, count, weight);
    return SM_OK;
}

/* ---- periods --------------------------------------------------------------------------- */

/* Changes the sign of numbers. */
static void negate(double *values, size_t count) {
    for (size_t k = 0; k < count; k++) values[k] = -values[k];
}

/* Starts the next period: turns the phases and carries sliders over. After half a period, odd
 * motion has the opposite sign. */
static void turn(sm_elastic_lines *e) {
    const size_t lines = e->lines.lines;
    sm_phases_turn(&e->lines.phases, e->half ? 0.5 * (e->lines.ratio - 1.0) : e->lines.ratio);
    e->turned = (e->turned + e->shift) % lines;
    if (e->half || e->shift > 0) sm_carry_sliders_over(e);
    sm_place_stuck_sliders(e);
    if (!e->half) return;
    negate(e->history, SM_HISTORIES * e->lines.contacts * lines);
    negate(e->memory, lines * e->memory_size);
    negate(e->marched.state, sm_marched_size(e->contact->response, e->lines.stride));
}

/* Integrates the contacts over a period: sm_torus_law.period. */
static sm_status march_period(sm_march *m) {
    sm_elastic_lines *e = m->lines;
    const size_t n = e->lines.contacts, steps = e->lines.steps / (e->half ? 2 : 1);
    const double *at = sm_march_amplitudes(m, 0);
    double amplitude[SM_MODES] = {0.0};
    for (int j = 0; j < e->contact->modes; j++) amplitude[j] = m->part * at[j];
    sm_elastic_lines_displace(e, amplitude, m->response);
    sm_phase_lines_clear(&e->lines);
    memset(e->square, 0, n * sizeof(double));
    for (size_t k = 0; k < 2 * (size_t)e->contact->elastic->elements; k++)
        e->bounds[k] = -INFINITY;
    memcpy(e->memory_at_start, e->memory, e->lines.lines * e->memory_size * sizeof(double));
    for (size_t k = 0; k < steps; k += SM_TOGETHER) {
        const size_t left = steps - k;
        SM_TRY(sm_elastic_lines_step(e, k, left < SM_TOGETHER ? left : SM_TOGETHER, 1.0));
    }
    m->steps = (int32_t)steps;
    sm_phase_lines_collect(&e->lines, steps, e->Y);
    for (size_t i = 0; i < n; i++) e->square[i] /= (double)(steps * e->lines.lines);
    turn(e);
    return sm_all_finite(e->Y, harmonics_size(e)) && sm_all_finite(e->square, n) ? SM_OK
                                                                                 : SM_NOT_FINITE;
}

/* ---- memory ---------------------------------------------------------------------------- */

/* Returns the doubles of memory that are unknowns of periodic motion. A slider forgets its position
 * when it slides; in two directions its initial position decays over many periods. */
static size_t memory_unknowns(const sm_elastic_lines *e) {
    const int closed = e->contact->modes == 1 || shift_of(e, 0) > 0;
    return closed && sm_elastic_slides_in_two(e->contact->elastic) ? e->lines.lines * e->memory_size
                                                                   : 0;
}

/* Returns the periods of an evaluation. Under two tones, sliders with forces at rest follow their
 * bounds within a few periods; before that, the search takes their motion for the response of the
 * modes. Of 1, 2 and 4, four periods make the shortest search in all on the wedge damper of
 * tests/rom/contact/test_wedge_damper.py. */
static int settling(const sm_elastic_lines *e) {
    const sm_elastic *elastic = e->contact->elastic;
    if (e->contact->modes == 1 || memory_unknowns(e) > 0) return 1;
    for (int32_t k = 0; k < elastic->elements; k++)
        if (sm_placed(&elastic->element[k]) && elastic->element[k].tangential_preload[0] != 0.0)
            return 4;
    return 1;
}

/* Takes the arrays from a block, or counts them. */
static void place(sm_elastic_lines *e, sm_block *block) {
    const sm_contact *contact = e->contact;
    const size_t n = e->lines.contacts, lines = e->lines.lines;
    sm_phase_lines_place(&e->lines, block);
    e->flexibility = sm_take(block, n * n);
    e->history = sm_take(block, 0);
    SM_TAKE_EACH(block, n * lines, &e->x, &e->u, &e->y, &e->stuck_x[0], &e->stuck_x[1],
                 &e->correction);
    e->slipped = (void *)sm_take(block, sm_doubles(lines * sizeof(int32_t)));
    e->memory = sm_take(block, lines * e->memory_size);
    e->memory_at_start = sm_take(block, lines * e->memory_size);
    e->bounds = sm_take(block, 2 * (size_t)contact->elastic->elements);
    e->last_bounds = sm_take(block, 4 * (size_t)contact->elastic->elements * lines);
    double **rows[] = {&e->compliance, &e->x_before,       &e->own_u, &e->own_stuck_x,
                       &e->own_y,  &e->own_correction, &e->square};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) *rows[k] = sm_take(block, n);
    e->Y = sm_take(block, harmonics_size(e));
    e->response = sm_take(block, harmonics_size(e) + memory_unknowns(e));
    sm_marched_place(&e->marched, contact->response, n, e->lines.stride, block);
    sm_elastic_solver_place(&e->solver, contact->elastic, contact->contacts, e->flexibility,
                            block);
}

/* Frees the lines: sm_torus_law.release. */
static void release(sm_march *m) {
    sm_elastic_lines *e = m->lines;
    if (e) free(e->block);
    free(e);
}

sm_status sm_elastic_make(sm_march *m) {
    static const sm_torus_law law = {start,           march_period, by_halves,
                                     exchange_memory, NULL,         release};
    const sm_contact *contact = m->contact;
    const sm_discretisation *grid = m->task->grid;
    const size_t n = (size_t)contact->contacts;
    sm_elastic_lines *e = m->lines = calloc(1, sizeof *e);
    m->law = &law;
    if (!e) return SM_NO_MEMORY;
    *e = (sm_elastic_lines){
        .contact = contact, .memory_size = sm_elastic_memory(contact->elastic),
        .lines = {.contacts = n, .orders = (size_t)grid->orders_count,
                  .lines = (size_t)grid->lines, .steps = (size_t)grid->steps,
                  .order = grid->orders,
                  .ratio = contact->modes == 2 ? grid->rates[1] / grid->rates[0] : 0.0}};
    sm_block block = {NULL, 0};
    place(e, &block);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    e->block = block.memory;
    place(e, &block);
    for (size_t k = 0; k < n * n; k++) e->flexibility[k] = -contact->stiffness[k];
    for (size_t i = 0; i < n && e->solver.slides; i++)
        e->compliance[i] = e->flexibility[i * n + i];
    m->points = 1;
    m->memory = memory_unknowns(e);
    m->settling = settling(e);
    m->response = e->response;
    m->Y = e->Y;
    m->square = e->square;
    const int requested = contact->response ? contact->response->requested : 0;
    m->requested = (size_t)(requested > 0 && e->solver.slides ? requested : grid->orders_count);
    return SM_OK;
}

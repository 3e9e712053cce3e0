#include "contact/elastic/solve.h"

#include <string.h>

#include "base/block.h"
#include "base/check.h"
#include "contact/elastic/equations.h"

#define MOST_NEWTON 40
#define HALVINGS 6
#define MOST_PIECES 65536
#define MOST_TRIES 1000
#define MOST_CREEP 400
#define MOST_HELD 4.0
#define STARTS 5
#define TOLERANCE 1e-11 /* of the displacements */
#define ROWS 4          /* of R whose sums are formed together */
#define STICKING 1e-14  /* of the reference stiffness: what the tangent may lack of it */
#define ROUNDING 1e-15

/* Where else solutions are looked for: normal displacements, relative to all others. */
static const double START[STARTS] = {0.0, -1.0, 1.0, -1e3, 1e3};

/* fmax, but for NaN: a call costs more than the comparison. */
SM_INLINE double larger(double a, double b) { return b > a ? b : a; }

static size_t integers(int contacts, const sm_elastic *elastic) {
    return sm_doubles((2 * (size_t)contacts + (size_t)elastic->elements) * sizeof(int32_t));
}

size_t sm_elastic_solver_size(const sm_elastic *elastic, int contacts) {
    const size_t n = (size_t)contacts;
    return n * (9 + SM_MOST_COLUMNS + n) + sm_elastic_memory(elastic) + integers(contacts, elastic);
}

void sm_elastic_solver_place(sm_elastic_solver *s, const sm_elastic *elastic, int contacts,
                             const double *flexibility, double *memory) {
    const size_t n = (size_t)contacts;
    *s = (sm_elastic_solver){.elastic = elastic, .contacts = contacts, .scale = 1.0,
                             .flexibility = flexibility};
    double **rows[] = {&s->f, &s->y, &s->residual, &s->step, &s->trial, &s->start, &s->right};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) *rows[k] = sm_take(&memory, n);
    s->lack = sm_take(&memory, SM_MOST_COLUMNS * n);
    s->matrix = sm_take(&memory, n * n);
    s->piece = sm_take(&memory, 2 * n);
    s->next = sm_take(&memory, sm_elastic_memory(elastic));
    s->active = (void *)memory;
    s->owner = s->active + n;
    s->state = s->owner + n;
    for (int32_t e = 0; e < elastic->elements; e++)
        for (int k = 0; k < sm_element_columns(&elastic->element[e]); k++)
            s->owner[elastic->element[e].column[k]] = e;
}

/* f, y and lack at the contact DOF of sliders, and what they remember; whether they stick. */
SM_INLINE int evaluate_sliders(sm_elastic_solver *s, int32_t e, const double *memory,
                               const double *x, double *next) {
    const sm_element *element = &s->elastic->element[e];
    const int32_t i = element->column[0];
    const double reference = s->elastic->reference[i];
    double tangent;
    sm_contact_state state;
    s->f[i] = sm_sliders_evaluate(s->elastic, element, s->scale, x[i], memory, &tangent, &state,
                                  next);
    s->y[i] = reference * x[i] - s->f[i];
    s->state[e] = (int32_t)state;
    s->lack[(size_t)i * SM_MOST_COLUMNS] = reference - tangent;
    return fabs(reference - tangent) <= STICKING * reference;
}

/* The same of another element; adds the contact DOFs that do not stick to the active ones. */
static int evaluate_element(sm_elastic_solver *s, int32_t e, const double *memory,
                            const double *x, double *next, int active) {
    const sm_element *element = &s->elastic->element[e];
    const int columns = sm_element_columns(element);
    sm_element_force at;
    sm_element_evaluate(s->elastic, element, s->scale, x, memory, &at, next);
    s->state[e] = (int32_t)at.state;
    for (int k = 0; k < columns; k++) {
        const int32_t i = element->column[k];
        const double reference = s->elastic->reference[i];
        double *lack = s->lack + (size_t)i * SM_MOST_COLUMNS;
        int sticks = 1;
        s->f[i] = at.force[k];
        s->y[i] = reference * x[i] - at.force[k];
        for (int j = 0; j < columns; j++) {
            lack[j] = (j == k ? reference : 0.0) - at.tangent[k][j];
            sticks &= fabs(lack[j]) <= STICKING * reference;
        }
        if (!sticks) s->active[active++] = i;
    }
    return active;
}

/* f, y, next, state and lack at x; the number of contact DOFs that do not stick. */
SM_INLINE int evaluate(sm_elastic_solver *s, const double *memory, const double *x) {
    const sm_elastic *elastic = s->elastic;
    double *next = s->next;
    int active = 0;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        const int remembered = sm_element_memory(element);
        if (element->law != SM_SLIDERS)
            active = evaluate_element(s, e, memory, x, next, active);
        else if (!evaluate_sliders(s, e, memory, x, next))
            s->active[active++] = element->column[0];
        memory += remembered;
        next += remembered;
    }
    return active;
}

/* residual = x - R y - u; its largest entry. R is symmetric: its rows are its columns. */
SM_INLINE double find_residual(sm_elastic_solver *s, const double *u, const double *x) {
    const size_t n = (size_t)s->contacts;
    double largest = 0.0;
    size_t first = 0;
    if (n >= SM_MANY_EQUATIONS) {
        for (size_t i = 0; i < n; i++) s->residual[i] = x[i] - u[i];
        first = sm_subtract_many(n, s->flexibility, NULL, n, s->y, s->residual);
        for (size_t i = 0; i < first; i++) largest = larger(largest, fabs(s->residual[i]));
    }
    for (; first < n; first += ROWS) {
        const size_t count = n - first < ROWS ? n - first : ROWS;
        const double *restrict row = s->flexibility + first;
        double sum[ROWS] = {0.0}; /* stays in registers */
        if (count == ROWS) {
            for (size_t k = 0; k < n; k++, row += n) {
                SM_SIMD
                for (size_t i = 0; i < ROWS; i++) sum[i] += row[i] * s->y[k];
            }
        } else {
            for (size_t k = 0; k < n; k++, row += n)
                for (size_t i = 0; i < count; i++) sum[i] += row[i] * s->y[k];
        }
        for (size_t i = 0; i < count; i++) {
            const double residual = x[first + i] - u[first + i] - sum[i];
            s->residual[first + i] = residual;
            largest = larger(largest, fabs(residual));
        }
    }
    return largest;
}

/* A step from the residual: ((1 + held) I - R lack) step = -residual, Newton's where held = 0. With
 * z = lack step, which is not zero at active DOFs alone: ((1 + held) I - lack R) z = -lack residual,
 * (1 + held) step = R z - residual. */
SM_HOT_ONE static int find_step(sm_elastic_solver *s, int active, double held) {
    const size_t n = (size_t)s->contacts, m = (size_t)active;
    for (size_t a = 0; a < m; a++) {
        const size_t i = (size_t)s->active[a];
        const sm_element *element = &s->elastic->element[s->owner[i]];
        const double *lack = s->lack + i * SM_MOST_COLUMNS;
        double *row = s->matrix + a * m;
        s->right[a] = 0.0;
        for (size_t b = 0; b < m; b++) row[b] = 0.0;
        row[a] = 1.0 + held;
        for (int k = 0; k < sm_element_columns(element); k++) {
            const double *restrict from = s->flexibility + (size_t)element->column[k] * n;
            const double by = lack[k];
            if (by == 0.0) continue;
            s->right[a] -= by * s->residual[element->column[k]];
            for (size_t b = 0; b < m; b++) row[b] -= by * from[s->active[b]];
        }
    }
    if (!sm_eliminate(m, s->matrix, s->right)) return 0;
    size_t done = 0;
    if (n >= SM_VECTOR) {
        memcpy(s->step, s->residual, n * sizeof(double));
        done = sm_subtract_many(n, s->flexibility, s->active, m, s->right, s->step);
        for (size_t i = 0; i < done; i++) s->step[i] /= -(1.0 + held);
    }
    for (size_t i = done; i < n; i++) {
        double sum = -s->residual[i];
        for (size_t a = 0; a < m; a++)
            sum += s->flexibility[i * n + (size_t)s->active[a]] * s->right[a];
        s->step[i] = sum / (1.0 + held);
    }
    return 1;
}

/* x moved along the step until the residual falls; its new size. */
SM_INLINE double search(sm_elastic_solver *s, const double *u, const double *memory, double *x,
                     double size, int *active) {
    const size_t n = (size_t)s->contacts;
    double part = 1.0, now = size;
    for (int halving = 0; halving <= HALVINGS; halving++, part *= 0.5) {
        for (size_t i = 0; i < n; i++) s->trial[i] = x[i] + part * s->step[i];
        *active = evaluate(s, memory, s->trial);
        now = find_residual(s, u, s->trial);
        if (now <= (1.0 - 0.1 * part) * size) break;
    }
    memcpy(x, s->trial, n * sizeof(double));
    return now;
}

/* The residual that counts as none, relative to u, to x and to where x came from: u may be zero
 * where sliders hold x elsewhere, and both may be. */
SM_INLINE double tolerated(const sm_elastic_solver *s, const double *u, const double *x) {
    double scale = s->least;
    for (int i = 0; i < s->contacts; i++)
        scale = larger(scale, larger(fabs(u[i]), larger(fabs(x[i]), fabs(s->start[i]))));
    return larger(TOLERANCE * scale, s->rounding);
}

/* What rounding makes of preloads and gaps, as displacements. */
static double rounding_of(const sm_elastic *elastic, double scale) {
    double largest = 0.0;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        if (element->law != SM_FRICTIONAL) continue;
        const double preload = scale * element->preload / element->normal_stiffness;
        largest = larger(largest, larger(preload, element->gap));
    }
    return ROUNDING * largest;
}

SM_HOT_ONE static sm_status newton(sm_elastic_solver *s, const double *u, const double *memory, double *x) {
    int active = evaluate(s, memory, x);
    double size = find_residual(s, u, x);
    for (int iteration = 0; iteration < MOST_NEWTON; iteration++) {
        if (size <= tolerated(s, u, x)) return SM_OK;
        if (!isfinite(size)) return SM_NOT_FINITE;
        if (!find_step(s, active, 0.0)) return SM_NOT_CONVERGED;
        size = search(s, u, memory, x, size, &active);
    }
    return size <= tolerated(s, u, x) ? SM_OK : SM_NOT_CONVERGED;
}

/* Where Newton's steps go round in circles: u is brought up in ever smaller pieces. That arrives
 * wherever the solution is unique, as it is for sliders, and for friction that is not strong. */
static sm_status in_pieces(sm_elastic_solver *s, const double *u, const double *memory,
                           double *x) {
    const size_t n = (size_t)s->contacts;
    evaluate(s, memory, s->start);
    find_residual(s, u, s->start); /* the start solves for u + residual */
    double done = 0.0, piece = 0.5;
    double *part_u = s->piece, *start_u = part_u + n;
    for (size_t i = 0; i < n; i++) start_u[i] = u[i] + s->residual[i];
    memcpy(x, s->start, n * sizeof(double));
    for (int tries = 0; done < 1.0; tries++) {
        if (tries == MOST_TRIES) return SM_NOT_CONVERGED;
        const double to = fmin(1.0, done + piece);
        for (size_t i = 0; i < n; i++) part_u[i] = start_u[i] + to * (u[i] - start_u[i]);
        const sm_status status = newton(s, part_u, memory, x);
        if (status == SM_NOT_FINITE) return status;
        if (status == SM_OK) {
            done = to;
            piece *= 2.0;
            memcpy(s->start, x, n * sizeof(double));
        } else {
            piece *= 0.5;
            if (piece < 1.0 / MOST_PIECES) return status;
            memcpy(x, s->start, n * sizeof(double));
        }
    }
    return SM_OK;
}

/* Strong friction may jam and let go at once: there the way ends, and x jumps. It creeps by
 * dx/dt = -residual, in implicit steps of 1 / held that grow as the residual falls. */
static sm_status creep(sm_elastic_solver *s, const double *u, const double *memory, double *x) {
    const size_t n = (size_t)s->contacts;
    int active = evaluate(s, memory, x);
    double size = find_residual(s, u, x), held = MOST_HELD;
    for (int iteration = 0; iteration < MOST_CREEP; iteration++) {
        if (size <= tolerated(s, u, x)) return SM_OK;
        if (!isfinite(size)) return SM_NOT_FINITE;
        if (!find_step(s, active, held)) return SM_NOT_CONVERGED;
        for (size_t i = 0; i < n; i++) x[i] += s->step[i];
        active = evaluate(s, memory, x);
        const double now = find_residual(s, u, x);
        held = fmin(MOST_HELD, held * now / size);
        size = now;
    }
    return SM_NOT_CONVERGED;
}

/* x = u, as if all stuck, but with contacts moved in their normal direction. */
static void elsewhere(sm_elastic_solver *s, const double *u, double normal, double *x) {
    const sm_elastic *elastic = s->elastic;
    const double moved = normal * tolerated(s, u, u) / TOLERANCE;
    memcpy(x, u, (size_t)s->contacts * sizeof(double));
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        if (element->law == SM_FRICTIONAL) x[element->column[element->tangents]] += moved;
    }
}

sm_status sm_elastic_solve(sm_elastic_solver *s, const double *u, const double *memory,
                           double *x) {
    memcpy(s->start, x, (size_t)s->contacts * sizeof(double));
    s->rounding = rounding_of(s->elastic, s->scale);
    sm_status status = newton(s, u, memory, x);
    if (status == SM_NOT_CONVERGED) status = in_pieces(s, u, memory, x);
    if (status == SM_NOT_CONVERGED) status = creep(s, u, memory, x);
    for (int start = 0; status == SM_NOT_CONVERGED && start < STARTS; start++) {
        elsewhere(s, u, START[start], x);
        status = newton(s, u, memory, x);
        if (status == SM_NOT_CONVERGED) status = creep(s, u, memory, x);
    }
    return status;
}

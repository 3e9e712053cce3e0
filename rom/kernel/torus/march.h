/* A march along phase lines: what a contact law provides, and what its drivers use.
 *
 * The modes act on the contacts with forces (elastic contacts: displacements)
 *   2 Re (-sum_j L_j a_j exp(i t_j) + sum_nm R_nm exp(i (n t_A + m t_B))).
 * A march of one period of mode A under the response R gives the harmonics Y of the motion
 * (elastic contacts: of the force deficit); periodic motion has R = H Y + held, see
 * sm_modal_response.
 */
#ifndef SLIPMODE_MARCH_H
#define SLIPMODE_MARCH_H

#include "slipmode.h"

/* What is computed: the arguments of sm_torus_harmonics. */
typedef struct {
    const sm_discretisation *grid;
    const sm_torus_points *points;
    const sm_torus_motion *motion;
} sm_torus_task;

typedef struct sm_march sm_march;

/* A contact law on phase lines. */
typedef struct {
    /* Contacts at rest at the points; elastic ones as in motion with harmonics Y (orders, N_c, 2),
     * if it is not NULL. */
    void (*start)(sm_march *march, const double *Y);
    /* Marches through a period, or half of one, under the response: sets what is `of the last
     * period`. */
    sm_status (*period)(sm_march *march);
    /* Chooses half periods, if `half` and they suffice, or whole ones, and sets `plain`; returns
     * which. */
    int (*by_halves)(sm_march *march, int half);
    /* Copies the memory of the contacts there, or back. NULL if `memory` is 0. */
    void (*exchange_memory)(sm_march *march, double *memory, int back);
    /* After a period of point p: extrapolates displacements that converge slowly, if that is
     * `wanted` and enough is known; returns whether it did. NULL: does not. */
    int (*extrapolate)(sm_march *march, size_t p, int wanted);
    void (*release)(sm_march *march);
} sm_torus_law;

struct sm_march {
    const sm_contact *contact;
    const sm_torus_task *task;
    const sm_torus_law *law;
    void *lines;         /* sm_rigid_lines or sm_elastic_lines */
    size_t points;       /* that are marched side by side */
    size_t memory;       /* doubles of a point's memory, if it is an unknown, or 0 */
    size_t requested;    /* the first harmonics, whose tolerance is not relaxed */
    int plain;           /* half periods of rigid contacts: the response takes a part of its change
                            after each, not a combination of several */
    const double *relaxation; /* (orders) that part */
    size_t first, count; /* points of the task that are marched now */
    double part;         /* of their amplitudes */
    double *response;    /* (points, orders N_c 2 + memory) R */
    /* of the last period: */
    const double *Y;      /* (points, orders, N_c, 2) */
    const double *square; /* (points, N_c) mean square of the motion */
    int32_t steps;        /* along each line */
    int marches, fine;    /* if `plain`: since the start; of these, on the grid itself */
};

/* Doubles of the harmonics of a point. */
static inline size_t sm_march_harmonics(const sm_march *march) {
    return 2 * (size_t)march->task->grid->orders_count * (size_t)march->contact->contacts;
}

/* Amplitudes of a point of the march; spare ones repeat the last point of the task. */
static inline const double *sm_march_amplitudes(const sm_march *march, size_t p) {
    const sm_torus_points *points = march->task->points;
    const size_t at = march->first + p < points->count ? march->first + p : points->count - 1;
    return points->amplitudes + at * (size_t)march->contact->modes;
}

/* Sizes of the contact motion and of the forces (elastic contacts: displacements) that the modes
 * alone cause, at a point's amplitudes or at smallest_scale, whichever are larger. Rigid contacts
 * move by 2 |L_j| a_j / K_ii without friction; elastic contacts that stick have half the peak of
 * the force. */
typedef struct {
    double of_mode[SM_MODES]; /* motion by each mode; elastic contacts: 0 */
    double motion, response;  /* largest motion, largest force (displacement) */
} sm_scales;

sm_scales sm_scales_at(const sm_contact *contact, const double *amplitude,
                       const double *smallest_scale);
/* The size that harmonic (n, m) is measured by. */
double sm_scale_of(const sm_scales *scales, const int32_t *order);

/* Largest difference of harmonics (orders_count, N_c, 2), relative to the scales; 0 without
 * any. */
double sm_relative_distance(const sm_march *march, const sm_scales *scales, const double *one,
                            const double *other);
/* Whether all orders are odd and the steps even, as half periods with opposite sign need. */
int sm_is_odd(const sm_discretisation *grid);

/* R = H Y + held, of so many harmonics Y (orders, N_c, 2). */
void sm_respond(const sm_contact *contact, const double *Y, double *R);

/* Makes the march of a law: `points`, `memory`, `requested` and the arrays. Release it also after
 * a failure. */
sm_status sm_rigid_make(sm_march *march);
sm_status sm_elastic_make(sm_march *march);

/* Solves all points of the task: periodic/search.c. */
sm_status sm_torus_search(sm_march *march);

/* Checks of arguments: the contacts and how finely they are resolved; finite amplitudes or growths
 * (points, modes), and that the results at so many points fit. */
sm_status sm_torus_check(const sm_contact *contact, const sm_discretisation *grid);
sm_status sm_torus_check_points(const sm_contact *contact, size_t points, const double *values,
                                int32_t orders_count);

#endif

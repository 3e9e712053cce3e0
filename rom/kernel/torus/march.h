/* A march along phase lines, eq. (13): the functions of a contact law, and the data of a march.
 * The modes act on the contacts with forces (elastic contacts: displacements)
 *   2 Re (-sum_j L_j a_j exp(i t_j) + sum_nm R_nm exp(i (n t_A + m t_B))).
 * A march of one period of mode A under the response R gives the harmonics Y of the motion
 * (elastic contacts: of the force deficit). Periodic motion has R = H Y + prescribed force. */
#ifndef SLIPMODE_MARCH_H
#define SLIPMODE_MARCH_H

#include "base/check.h"

/* Ratio of successive changes above which convergence is slow, and extrapolated [-]: the limit is then
 * farther away than the last change. */
#define SM_SLOW_RATIO 0.5

/* The arguments of sm_torus_harmonics. */
typedef struct {
    const sm_discretisation *grid;
    const sm_torus_points *points;
    const sm_torus_motion *motion;
} sm_torus_task;

typedef struct sm_march sm_march;

/* The functions of a contact law on phase lines. */
typedef struct {
    /* Sets the contacts of all points to rest; elastic ones to motion with harmonics
     * Y (orders, N_c, 2), unless Y is NULL. */
    void (*start)(sm_march *march, const double *Y);
    /* Marches through a period, or half a period, under the response; sets `Y` to `fine`. */
    sm_status (*period)(sm_march *march);
    /* Chooses half periods if `half` and the motion is odd, else whole periods; sets `plain`.
     * Returns 1 for half periods. */
    int (*by_halves)(sm_march *march, int half);
    /* Copies the memory of the contacts to `memory`, or from there if `back`. NULL if the march has
     * memory = 0. */
    void (*exchange_memory)(sm_march *march, double *memory, int back);
    /* After a period of point p: extrapolates displacements that converge slowly to their limit,
     * if `wanted` and if two changes are known. Returns whether it did. NULL: `plain` is 0. */
    int (*extrapolate)(sm_march *march, size_t p, int wanted);
    /* Frees the lines. */
    void (*release)(sm_march *march);
} sm_torus_law;

struct sm_march {
    const sm_contact *contact;
    const sm_torus_task *task;
    const sm_torus_law *law;
    void *lines;         /* sm_rigid_lines or sm_elastic_lines */
    size_t points;       /* capacity: points that are marched side by side */
    size_t memory;       /* doubles of the memory of a point, if it is unknown; else 0 */
    int settling;        /* periods of an evaluation, in which memory that is not unknown settles */
    size_t requested;    /* the first harmonics, whose tolerance is not relaxed */
    int plain;           /* 1: half periods of rigid contacts with relaxed iterations of the
                            response; 0: whole periods with Anderson's acceleration */
    const double *relaxation; /* (orders) relaxation factors of these iterations */
    size_t first, count; /* points first ... first + count - 1 of the task are marched */
    double part;         /* factor of their amplitudes, 1 except in a continuation */
    const double *growth; /* (points, modes) of the task, rigid contacts: growth of the amplitudes
                             in a period; NULL: none */
    double elapsed;      /* of a growth: periods since the amplitudes were as given */
    double *response;    /* (points, orders N_c 2 + memory) R, then the memory */
    /* results of the last period: */
    const double *Y;      /* (points, orders, N_c, 2) */
    const double *square; /* (points, N_c) mean square of the motion */
    int32_t steps;        /* along each line */
    int marches, fine;    /* if `plain`: half periods since the start, and on the fine grid */
};

/* Returns the number of doubles of the harmonics of a point. */
static inline size_t sm_march_harmonics(const sm_march *march) {
    return 2 * (size_t)march->task->grid->orders_count * (size_t)march->contact->contacts;
}

/* Returns the index of point p of the march in arrays (points, modes) of the task. Unused places
 * repeat the last point. */
static inline size_t sm_march_place(const sm_march *march, size_t p) {
    const size_t count = march->task->points->count, at = march->first + p;
    return (at < count ? at : count - 1) * (size_t)march->contact->modes;
}

/* Returns the amplitudes of a point of the march. */
static inline const double *sm_march_amplitudes(const sm_march *march, size_t p) {
    return march->task->points->amplitudes + sm_march_place(march, p);
}

/* Contact motion and forces (elastic contacts: displacements) due to the modes alone, at the
 * amplitudes of a point or at smallest_scale, whichever are larger. Rigid contacts move by
 * 2 |L_j| a_j / K_ii without friction; the scale of sticking elastic contacts is half the peak
 * force. */
typedef struct {
    double of_mode[SM_MODES]; /* motion due to each mode; elastic contacts: 0 */
    double motion, response;  /* largest motion, largest force (displacement) */
} sm_scales;

/* Computes the scales at the amplitudes of a point. */
sm_scales sm_scales_at(const sm_contact *contact, const double *amplitude,
                       const double *smallest_scale);
/* Returns the scale of harmonic (n, m). */
double sm_scale_of(const sm_scales *scales, const int32_t *order);

/* Returns the largest difference of harmonics (orders_count, N_c, 2), relative to their scales; 0
 * if the modes cause no motion. */
double sm_relative_distance(const sm_march *march, const sm_scales *scales, const double *one,
                            const double *other);
/* Returns whether all harmonics are odd and the number of steps is even: then half a period
 * determines the other half, with opposite sign. */
int sm_is_odd(const sm_discretisation *grid);

/* Computes the response R = H Y + prescribed force of the modes to harmonics Y (orders, N_c, 2). */
void sm_respond(const sm_contact *contact, const double *Y, double *R);

/* Makes the march of rigid contacts: `points`, `memory`, `requested` and the arrays. The caller
 * releases it also after a failure. */
sm_status sm_rigid_make(sm_march *march);
/* Makes the march of elastic contacts in the same way. */
sm_status sm_elastic_make(sm_march *march);

/* Checks the contacts and the discretisation. */
sm_status sm_torus_check(const sm_contact *contact, const sm_discretisation *grid);
/* Checks all arguments of sm_torus_harmonics. */
sm_status sm_torus_check_task(const sm_contact *contact, const sm_torus_task *task);
/* Checks that amplitudes or growths (points, modes) are finite, and that the size of the harmonics
 * at all points can be represented. */
sm_status sm_torus_check_points(const sm_contact *contact, size_t points, const double *values,
                                int32_t orders_count);

#endif

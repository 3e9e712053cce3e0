/* slipmode: the numerical core of Python and the FMU. Equation numbers refer to the source paper.
 *   - matrices are row-major; complex numbers are (re, im) pairs of doubles;
 *   - modal displacement q_j = a_j exp(i theta_j) + c.c., theta_j' = Omega_j;
 *   - S_j(|a_A|, |a_B|) = Q_j |a_j| is the tabulated friction term of mode j, eq. (20);
 *   - no globals; memory is taken only by functions whose name ends in _create;
 *   - functions that check arguments or can fail return an sm_status, whose text is sm_message(). */
#ifndef SLIPMODE_H
#define SLIPMODE_H

#include <stddef.h>
#include <stdint.h>

#if defined(SM_HIDDEN) || (defined(_WIN32) && !defined(SM_EXPORT))
#define SM_API
#elif defined(_WIN32)
#define SM_API __declspec(dllexport)
#else
#define SM_API __attribute__((visibility("default")))
#endif

#define SM_MODES 2         /* the method has amplitude equations for one or two modes */
#define SM_COMBINATIONS 16 /* largest number of combination resonances of a slow flow */
#define SM_MOST_FIELDS (2 * (SM_MODES + SM_COMBINATIONS + 1)) /* largest number of table columns */
#define SM_RATE_CORRECTIONS (2 * SM_MODES * SM_MODES)         /* columns of the rate correction */

typedef enum {
    SM_OK = 0,
    SM_BAD_ARGUMENT,   /* a size, sign or order is not allowed */
    SM_NOT_FINITE,     /* an input or a computed state is NaN or infinite */
    SM_NO_MEMORY,
    SM_NOT_CONVERGED,  /* an implicit step or an iteration did not reach its tolerance */
    SM_OUTSIDE_TABLE,  /* an amplitude is outside the friction table */
    SM_STEP_TOO_SMALL  /* the slow flow cannot meet its tolerance */
} sm_status;

SM_API const char *sm_message(sm_status status);

/* ---- friction and the contact problem ------------------------------------------------ */

typedef enum { SM_TANH = 0, SM_COULOMB = 1, SM_ELASTIC = 2 } sm_law;

/* Elastic contacts are springs while they stick. Each has a law on one to three contact DOFs. */
typedef enum { SM_SLIDERS = 0, SM_FRICTIONAL = 1 } sm_element_law;
typedef enum { SM_STICK = 0, SM_SLIP = 1, SM_OPEN = 2 } sm_contact_state;

typedef struct {
    int32_t law;                   /* sm_element_law */
    int32_t column[3];             /* contact DOFs: tangential ones, then the normal */
    int32_t first_slider, sliders; /* SM_SLIDERS: its Jenkins elements, which act in parallel */
    int32_t tangents;              /* SM_FRICTIONAL: 1 or 2 tangential directions */
    double friction;               /* mu */
    double preload;                /* normal force at rest [N] */
    double tangential_preload[2];  /* tangential force at rest, at most mu times the normal one [N] */
    double tangential_stiffness, normal_stiffness; /* [N/m] */
    double gap;                    /* normal displacement at which the contact closes [m] */
} sm_element;

typedef struct {
    int32_t elements, sliders;
    const sm_element *element;
    const double *slider;    /* (sliders, 2) limit [N], stiffness [N/m] */
    const double *reference; /* (N_c) stiffness of the stuck contacts in the modes [N/m] */
} sm_elastic;

/* Returns the number of doubles of the memory of the contacts: positions of their sliders and last
 * displacements [m], 0 at rest. */
SM_API size_t sm_elastic_memory(const sm_elastic *elastic);

/* Computes the forces (N_c), without preload, on contacts that move to displacements x (N_c), and
 * updates their memory. */
SM_API sm_status sm_elastic_force(const sm_elastic *elastic, int32_t contacts, const double *x,
                                  double *memory, double *force);

/* Computes the static displacements x (N_c) of the contacts and the forces on them, without
 * preload, in one step from rest. If all contacts stick their displacement is `displacement` (N_c);
 * their displacement per force deficit of the reference springs is `flexibility` (N_c, N_c).
 * SM_NOT_CONVERGED if there is no equilibrium. */
SM_API sm_status sm_elastic_equilibrium(const sm_elastic *elastic, int32_t contacts,
                                        const double *flexibility, const double *displacement,
                                        double *x, double *force);

/* A combination resonance: a harmonic (n, m) of the contact motion whose frequency n Omega_A + m
 * Omega_B is near the carrier of a mode. It drives this mode by T = -L^T P_nm. */
typedef struct {
    int32_t mode, n, m;
} sm_combination;

/* The response of the modes to harmonics of the contact motion other than their carrier. */
typedef struct {
    int32_t orders_count;
    const int32_t *orders; /* (orders_count, 2) harmonics (n, m) */
    /* The caller uses the first `requested` harmonics; 0: all. On the torus, other harmonics of
     * sliders have a larger tolerance, because they matter only by the response of the modes. */
    int32_t requested;
    /* (orders_count, N_c, N_c, 2) H_nm(nu): force on the contacts per P_nm, a symmetric matrix.
     * For the torus; along a trajectory the segments contain the force. */
    const double *dynamic_stiffness;
    /* Modes that are integrated together with elastic contacts, in the time steps of the torus.
     * Their response is not in K and H. The force on mode k is g = projection_k y. In a step
     * from y_0 to y_1 its displacement p and velocity v become
     *   p_1 = advance_k (p_0, v_0, g_0, g_1),  v_1 = advance_k+4 (p_0, v_0, g_0, g_1),
     * except that the part of g_1 in p_1 is in K. */
    int32_t marched;
    const double *projection; /* (marched, N_c) */
    const double *advance;    /* (marched, 8) */
    /* (orders_count, marched, 2, 2) p and v at t = 0 per harmonic of g in periodic motion. */
    const double *periodic;
    /* (orders_count, N_c, 2) initial guess of the harmonics at every point; NULL: 0. */
    const double *start;
    /* (orders_count, N_c, 2) prescribed force on the contacts, for the torus; NULL: none. */
    const double *prescribed;
} sm_modal_response;

/* [M x'' +] D x' + K x + g(x') = -2 Re sum_j L_j a_j exp(i theta_j): eq. (12), with inertia and
 * damping of the contacts.
 *
 * Elastic contacts have the dual problem, x(y) + K y = -2 Re sum_j L_j a_j exp(i theta_j), with
 * the force deficit y of their reference springs and K = -(flexibility of the structure): y
 * replaces the contact displacement. */
typedef struct {
    int32_t contacts;        /* N_c; 0 only in a component of an SM_ELASTIC model */
    int32_t modes;           /* 1 or 2 */
    int32_t law;             /* sm_law */
    double alpha;            /* regularisation velocity of the tanh law [m/s] */
    const double *limit;     /* (N_c) friction limits mu N [N] */
    const double *stiffness; /* (N_c, N_c) K */
    const double *damping;   /* (N_c, N_c) D */
    const double *coupling;  /* (modes, N_c, 2) L_j at the carrier */
    const double *mass;      /* (N_c, N_c) M; NULL: massless */
    const sm_modal_response *response; /* NULL: the modes move at their carrier alone */
    const sm_elastic *elastic; /* SM_ELASTIC; no mass, no damping then */
} sm_contact;

SM_API sm_status sm_contact_check(const sm_contact *contact);

/* Discretisation of the torus of the phases t_A, t_B: `lines` phase lines with `steps` time steps
 * per period of mode A, and the Fourier coefficients of the motion that are computed. */
typedef struct {
    const double *rates;     /* (modes) carrier frequencies [rad/s] */
    int32_t steps;           /* 4 or more */
    int32_t lines;           /* 1 or more; for rigid contacts a power of 2 */
    int32_t orders_count;
    const int32_t *orders;   /* (orders_count, 2) harmonics (n, m), one of each pair +-(n, m); the
                                harmonics of contact->response must be the same */
    double tolerance;        /* largest change of a harmonic of periodic motion, relative to the
                                frictionless displacement of the contacts by its mode */
    const double *smallest_scale; /* (modes) smallest amplitudes for this displacement */
    int32_t max_periods;     /* of mode A, 1 to 2000 */
} sm_discretisation;

/* Points of the amplitude plane at which the motion is computed. */
typedef struct {
    size_t count;
    const double *amplitudes; /* (count, modes), >= 0 */
    /* (count, orders_count, N_c, 2) initial guess of the harmonics, for elastic contacts and for
     * strong responses of the modes to rigid contacts. If the search fails it starts again from
     * contact->response->start, then from rest. NULL: for elastic contacts, the harmonics of the
     * previous point. */
    const double *guess;
} sm_torus_points;

/* Periodic motion at the points. */
typedef struct {
    double *harmonics;   /* (count, orders_count, N_c, 2) P_nm */
    double *mean_square; /* (count, N_c) of the displacement. The mean square of the harmonics that
                            are not computed is mean_square - 2 sum |P_nm|^2. */
    double *residual;    /* (count) estimated distance from periodicity at the end of the march. It
                            exceeds the tolerance after max_periods, or if discretisation errors
                            persist: harmonics and mean_square are then means, and this is the
                            distance of the last harmonics from the mean. */
    int32_t *marched;    /* (count) time steps along each line */
} sm_torus_motion;

/* Computes the harmonics of periodic contact motion on the torus, eqs. (13), (14), by
 * characteristics. */
SM_API sm_status sm_torus_harmonics(const sm_contact *contact, const sm_discretisation *grid,
                                    const sm_torus_points *points, const sm_torus_motion *motion);

/* Computes the harmonics of the contact motion under growing amplitudes, for the rate correction
 * of S_j: over two periods of mode A, after a march from rest, with `amplitudes` in the middle of
 * these periods. The difference of two results is the effect of the growth. The modes respond at
 * their carrier only.
 *   amplitudes, growth (points, modes): the growth is per period of mode A
 *   harmonics          (points, orders_count, N_c, 2), weighted by a hat over the two periods */
SM_API sm_status sm_torus_growing(const sm_contact *contact, const sm_discretisation *grid,
                                  size_t points, const double *amplitudes, const double *growth,
                                  double *harmonics);

/* ---- motion of the contacts along a slow trajectory ----------------------------------- */

/* A segment of slow time in which all inputs are linear in time. */
typedef struct {
    double start, duration;                    /* [s] */
    double amplitude_start[2 * SM_MODES];      /* a_j at the start */
    double amplitude_end[2 * SM_MODES];        /* a_j at the end */
    double rate_start[2 * SM_MODES];           /* da_j/dt at the start */
    double rate_end[2 * SM_MODES];             /* da_j/dt at the end */
    double angle[SM_MODES];                    /* theta_j at the start [rad] */
    double frequency[SM_MODES];                /* Omega_j at the start [rad/s] */
    double frequency_rate[SM_MODES];           /* dOmega_j/dt [rad/s^2] */
    /* (response->orders_count, N_c, 2) G_nm at the start and the end, or NULL: the force of the
     * modes on the contacts is Re sum G_nm exp(i (n theta_A + m theta_B)) [N] */
    const double *reaction_start, *reaction_end;
} sm_segment;

/* Samples of the contact motion at increasing times; arrays (count, N_c), NULL: not requested. */
typedef struct {
    size_t count;
    const double *times;
    double *displacement, *velocity, *force;
} sm_contact_samples;

/* Integrates the contact motion over consecutive segments, from displacement `start_x` (N_c; NULL:
 * 0) at the start of the first segment. */
SM_API sm_status sm_contact_motion(const sm_contact *contact, size_t segments,
                                   const sm_segment *segment, const double *start_x,
                                   int32_t steps_per_period, const sm_contact_samples *samples);

/* Signals that are sums of harmonics with slowly varying coefficients:
 *   x_s(t) = 2 Re (sum_j shape_js a_j exp(i theta_j)
 *                  + sum_q c_qs exp(i (n_q theta_A + m_q theta_B)))
 * with the a_j of the segments; c is linear in time between their ends. */
typedef struct {
    int32_t modes;             /* 1 or 2 */
    int32_t orders_count;
    const int32_t *orders;     /* (orders_count, 2) */
    size_t signals;
    const double *shape;       /* (modes, signals) */
    const double *coefficient; /* (segments + 1, signals, 2, orders_count): real, imaginary */
} sm_harmonic_sum;

/* Computes the signals at increasing times inside consecutive segments: motion (samples,
 * signals). */
SM_API sm_status sm_harmonic_motion(const sm_harmonic_sum *sum, size_t segments,
                                    const sm_segment *segment, size_t samples,
                                    const double *times, double *motion);

#include "slipmode_slow.h"
#include "slipmode_component.h"
#include "slipmode_full.h"
#include "slipmode_tone.h"

#endif

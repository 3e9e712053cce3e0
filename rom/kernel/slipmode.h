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

/* ---- friction tables ------------------------------------------------------------------ */

/* Bicubic Hermite surface of S_j, of the terms T_k of combination resonances, and of two powers.
 * First power: friction power less the power from the modes and the forces. Second power: power
 * from the forces of steady states to the contacts, without the power through their shift of the
 * amplitudes. For one mode: count_b = 1 and node_b = NULL. values (count_a, count_b, 4, 2 (modes +
 * combinations + power)): value, d/da, d/db, d2/dadb of (Re, Im) of each S_j, of each T_k, then of
 * the two powers. */
typedef struct {
    int32_t modes;
    int32_t combinations;
    int32_t power; /* 1: the powers are tabulated; 0: all power from the modes is friction power */
    int32_t count_a, count_b;
    const double *node_a, *node_b;
    const double *values;
    /* (count_a, count_b, 4, 2 modes modes) values and slopes as in `values`: the rate correction
     * R_jk = dS_j / d(d|a_k|/dt), by mode j and k. NULL: 0. */
    const double *rate_correction;
    /* as rate_correction: dS_j / dOmega_k at the carriers of the table. NULL: 0. */
    const double *detuning;
} sm_table;

SM_API sm_status sm_table_check(const sm_table *table);
/* Computes all columns s (points, 2 (modes + combinations + power)) at amplitudes (points, modes).
 * SM_OUTSIDE_TABLE beyond the last node. */
SM_API sm_status sm_table_lookup(const sm_table *table, size_t points, const double *amplitudes,
                                 double *s);

/* ---- slow flow ------------------------------------------------------------------------ */

/* Amplitude equations (18), (19) in the frame of the forcing:
 *   mass_j a_j' + stiffness_j a_j = F_j exp(i ph_j)/2 + Q_j a_j [+ combination resonances]. */
typedef struct {
    int32_t paper;              /* 1: carrier at the natural frequency; 0: at the forcing */
    double natural[SM_MODES];   /* omega_j [rad/s] */
    double damping[SM_MODES];   /* phi_j^T C phi_j [1/s]; < 0: self-excited */
    sm_table table;
    double carrier[SM_MODES];   /* of a table with `detuning` [rad/s] */
    double coupling_ratio[SM_MODES][2][2]; /* c_0 and c_1, complex: L_j(nu) =
                                   (1 + c_0 + i nu c_1) L_j(carrier) */
    double off_resonance[SM_MODES][2];  /* shift s_j: the effective amplitude is
                                           a_j + s_j F_j exp(i ph_j) */
    double cross_response[SM_MODES][SM_MODES][2]; /* [k][j]: off-resonance response of mode k per
                                             F_j exp(i ph_j) of another mode j; 0 for k = j */
    double other_modes[SM_MODES][2][2];  /* displacement of the DOFs loaded by force j due to all
                                            other modes: per F_j exp(i ph_j), and per a_j */
    sm_combination combination[SM_COMBINATIONS]; /* the first table.combinations are used */
    double ratio; /* Omega_B / Omega_A of modes on one tone: the effect of their combination
                     resonances is constant in steady motion; 0: a tone for each mode */
} sm_slow_flow;

/* Inputs over a step: value at its start and rate of change during it. */
typedef struct {
    double force[SM_MODES], force_rate[SM_MODES];         /* modal F_j [N kg^-1/2] */
    double frequency[SM_MODES], frequency_rate[SM_MODES]; /* Omega_j [rad/s] */
    double phase[SM_MODES], phase_rate[SM_MODES];         /* of the force [rad], [rad/s] */
    double limit_scale, limit_scale_rate; /* s: friction limits / limits of the table, > 0 [-],
                                             [1/s]. Not 1 only for homogeneous laws, where
                                             S(|a|; s mu N) = s S(|a| / s; mu N) */
    double angle[SM_MODES];   /* theta_j at the start [rad]; a component sets its own angles */
} sm_inputs;

/* Computes da_j/dt and the powers (2) of input and friction, `elapsed` seconds after the inputs'
 * start. */
SM_API sm_status sm_slow_flow_rate(const sm_slow_flow *flow, const sm_inputs *inputs,
                                   double elapsed, const double *amplitude, double *rate,
                                   double *powers);

/* Amplitudes (modes, 2) and inputs, or changes of both. */
typedef struct {
    const double *amplitude;
    const sm_inputs *inputs;
} sm_slow_point;

/* Computes the first-order changes of rates and powers along a direction in amplitudes and all
 * inputs. */
SM_API sm_status sm_slow_flow_directional(const sm_slow_flow *flow, const sm_slow_point *at,
                                          const sm_slow_point *along, double *d_rate,
                                          double *d_powers);

/* Computes da_j/dt at many points, each with its inputs: amplitude, rate (points, modes, 2).
 * SM_OUTSIDE_TABLE if a point is outside the table: its rate is NaN, the other rates are valid. */
SM_API sm_status sm_slow_flow_rates(const sm_slow_flow *flow, size_t points,
                                    const sm_inputs *inputs, const double *amplitude,
                                    double *rate);

/* Computes the terms that balance in steady motion, without a'' and without the combination
 * resonances, whose mean over time is zero:
 *   balance  (points, 4, modes, 2): mass_j, stiffness_j, Q_j a_j and da_j/dt
 *   jacobian (points, 2 modes, 2 modes) of da_j/dt by (Re, Im) of the amplitudes; NULL: none
 * SM_OUTSIDE_TABLE if a point is outside the table: its terms are NaN. */
SM_API sm_status sm_slow_flow_balance(const sm_slow_flow *flow, size_t points,
                                      const sm_inputs *inputs, const double *amplitude,
                                      double *balance, double *jacobian);

/* ---- solution curves ------------------------------------------------------------------- */

#define SM_CURVE_UNKNOWNS 10 /* largest number of unknowns k */

/* Computes F (k) and its Jacobian (k, k + 1) at z = (y (k), p). Any status but SM_OK means that F
 * is not defined there. */
typedef sm_status (*sm_curve_rates)(const void *of, const double *z, double *F, double *J);

/* A curve F(y, p) = 0, scaled so that 1 is a large change of each unknown. A point on the curve is
 * a row of doubles: z (k + 1), tangent (k + 1) of length 1, dF/dy (k, k). */
typedef struct {
    int32_t unknowns;    /* k */
    double largest_step; /* between two points */
    sm_curve_rates rates;
    const void *of;      /* first argument of rates */
    double noise;        /* error of z due to errors of the rates: 0 if they are exact */
} sm_curve;

/* Numbers of points on both sides of the start. closed: the last point is followed by the first. */
typedef struct {
    size_t before, after;
    int32_t closed;
} sm_branch;

/* Traces the curve through a solution near `start`, with the same p. This solution becomes
 * points[most - 1] of 2 most - 1. Each side has at most `most` points and ends at p = 0, at p = 1,
 * where F is not defined, or at the start, if the curve is closed. SM_NOT_CONVERGED: there is no
 * solution near `start`. */
SM_API sm_status sm_curve_branch(const sm_curve *curve, const double *start, size_t most,
                                 double *points, sm_branch *branch);
/* Computes the point of the curve near a guess (k + 1), in the plane through the guess with the
 * normal (k + 1). The product of its tangent and `onward` (k + 1) is positive. SM_NOT_CONVERGED:
 * there is no such point. */
SM_API sm_status sm_curve_point_near(const sm_curve *curve, const double *guess,
                                     const double *normal, const double *onward, double *point);

/* Replaces z (k + 1) by a solution with the same p, which may be far from z. SM_NOT_CONVERGED: no
 * solution is found. */
SM_API sm_status sm_curve_solved(const sm_curve *curve, double *z);

/* Returns 1 if a solution z lies on a branch of `points` rows, `stride` doubles from row to row. */
SM_API int32_t sm_curve_passes(int32_t unknowns, size_t points, size_t stride, const double *row,
                               const double *z);
/* Returns 1 if the steady state of a row is stable: all small deviations decay. */
SM_API int32_t sm_curve_is_stable(int32_t unknowns, const double *row);

/* A slow flow under inputs that change along a straight line. */
typedef struct {
    const sm_slow_flow *flow;
    const sm_inputs *inputs; /* (2): at p = 0 and 1; force, frequency and limit_scale change */
    double scale[SM_MODES];  /* of amplitudes: y = a / (scale limit_scale), F = y' */
} sm_forced;

/* Creates the curve of the steady states, with the terms of sm_slow_flow_balance. The curve refers
 * to `forced`. */
SM_API sm_status sm_forced_curve(const sm_forced *forced, double largest_step, sm_curve *curve);
/* Finds steady states z (found, k + 1) of the curve, at most `most`, at `sections` >= 2 values of p
 * from 0 to 1. Searches start from many amplitudes up to `scale` with phases that balance the
 * forces. */
SM_API sm_status sm_forced_solutions(const sm_forced *forced, int32_t sections, size_t most,
                                     double *z, size_t *found);

/* ---- the step-able component ----------------------------------------------------------- */

typedef struct sm_component sm_component;

/* Motion at communication points. The response of the modes to harmonics (n, m) of the contact
 * motion acts on the contacts with the force Re sum G_nm exp(i (n theta_A + m theta_B)), and moves
 * the elastic outputs by Re sum E_nm exp(...). G and E are linear between the nodes of the friction
 * table. Elastic outputs are x = 2 Re sum_j (modes_out_j a_j + forces_out_j F_j exp(i phase_j))
 * exp(i theta_j) + contacts_out x_c + E. */
typedef struct {
    int32_t wanted;              /* 1: contact motion can be read at communication points */
    int32_t elastic;             /* number of elastic outputs */
    const double *modes_out;     /* (elastic, modes, 2) */
    const double *forces_out;    /* (elastic, modes, 2): by the other modes, off resonance */
    const double *contacts_out;  /* (elastic, N_c) */
    int32_t orders_count;        /* harmonics that the modes respond to, 0 or more */
    const int32_t *orders;       /* (orders_count, 2) */
    const double *reaction;          /* (count_a, count_b, orders_count, N_c, 2) G_nm [N] */
    const double *response;        /* (count_a, count_b, orders_count, elastic, 2) E_nm [m] */
    int32_t steps_per_period;    /* of the faster carrier */
    double memory_periods;       /* memory of the contacts: an integration starts at most so many
                                    periods of the slower carrier before a communication point */
} sm_motion;

/* Creates a component. Arrays of the arguments are not copied and must outlive the component. */
SM_API sm_status sm_component_create(const sm_slow_flow *flow, const sm_contact *contact,
                                     const sm_motion *motion, double tolerance,
                                     sm_component **component);
/* Checks the arguments of a component, except its tolerance. */
SM_API sm_status sm_component_check(const sm_slow_flow *flow, const sm_contact *contact,
                                    const sm_motion *motion);
/* Creates a component from arguments that sm_component_check has accepted. Damping and
 * motion.wanted may have changed since. */
SM_API sm_status sm_component_checked_create(const sm_slow_flow *flow, const sm_contact *contact,
                                             const sm_motion *motion, double tolerance,
                                             sm_component **component);
SM_API void sm_component_free(sm_component *component);
/* Sets the state at `time`: amplitudes (modes, 2), angles 0, energy 0, contacts at rest. */
SM_API sm_status sm_component_reset(sm_component *component, double time,
                                    const double *amplitude);
/* Sets the amplitudes (modes, 2) at the present time and angles, for instance after an event. */
SM_API sm_status sm_component_set_amplitude(sm_component *component, const double *amplitude);
/* Sets the inputs from the present time on. SM_BAD_ARGUMENT if the limits are scaled but the law is
 * not homogeneous: tanh, gaps. */
SM_API sm_status sm_component_set_inputs(sm_component *component, const sm_inputs *inputs);
/* Advances by `duration` > 0. On any status but SM_OK the state is as before the call. An amplitude
 * outside the table after a change of force is limited to the edge of the table. */
SM_API sm_status sm_component_step(sm_component *component, double duration);
/* Advances by one internal step, or by several very short ones, at most by `most` > 0. `taken` is
 * the time by which the state has advanced. */
SM_API sm_status sm_component_advance(sm_component *component, double most, double *taken);

/* Outputs without motion: time, (Re, Im) of a_A and a_B, theta_A, theta_B, input power, power and
 * energy dissipated at the contacts. Outputs of a mode that the model does not have are 0. */
#define SM_OUTPUTS_FIXED 10
/* Returns the number of outputs: SM_OUTPUTS_FIXED; with motion.wanted also x_c, v_c, f_c (3 N_c)
 * and the elastic displacements. */
SM_API size_t sm_component_output_count(const sm_component *component);
/* Compute all outputs, and the first SM_OUTPUTS_FIXED outputs. */
SM_API sm_status sm_component_outputs(sm_component *component, double *outputs);
SM_API sm_status sm_component_slow_outputs(const sm_component *component, double *outputs);
/* Computes the other outputs; elastic displacements if `elastic`. The contacts are integrated from
 * their last output on, or over their memory. SM_BAD_ARGUMENT unless motion.wanted. */
SM_API sm_status sm_component_motion(sm_component *component, int elastic, double *motion);

/* Computes x_c, v_c, f_c (3 N_c) and the elastic displacements at given amplitudes that have
 * changed at `rate` (modes, 2 each) over the memory of the contacts; `inputs` with their angles.
 * `smooth`: with equal steps, so that the result is a smooth function of the arguments, for
 * derivatives. The state does not change. SM_BAD_ARGUMENT unless motion.wanted. */
SM_API sm_status sm_component_recent_motion(sm_component *component, const sm_inputs *inputs,
                                            const double *amplitude, const double *rate,
                                            int smooth, double *motion);

/* Makes `steps` steps with inputs[k] over durations[k], and computes the outputs (steps,
 * output_count) after each. `done` is the number of steps by which the state has advanced. If the
 * contact motion after a step cannot be computed, its outputs are NaN, and the step is the last. */
SM_API sm_status sm_component_run(sm_component *component, size_t steps, const double *durations,
                                  const sm_inputs *inputs, double *outputs, size_t *done);

/* Rows of a trace, and its progress: `done` steps and `elapsed` seconds of the next one, 0 in the
 * first call. */
typedef struct {
    size_t capacity, count; /* largest number of rows; rows written by this call */
    double *outputs;        /* (capacity, output_count) */
    size_t done;
    double elapsed;
} sm_trace;

/* Makes the steps of sm_component_run with outputs after each internal step. It returns when the
 * steps are done or all rows are written; the next call continues. */
SM_API sm_status sm_component_trace(sm_component *component, size_t steps, const double *durations,
                                    const sm_inputs *inputs, sm_trace *trace);

/* Returns the number of doubles of the state, which contains no addresses. */
SM_API size_t sm_component_state_count(const sm_component *component);
/* Writes the state; sets the state. */
SM_API sm_status sm_component_get_state(const sm_component *component, double *state);
SM_API sm_status sm_component_set_state(sm_component *component, const double *state);
/* Returns the numbers of accepted and rejected internal steps since creation. */
SM_API void sm_component_work(const sm_component *component, uint64_t *accepted,
                              uint64_t *rejected);

#include "slipmode_full.h"
#include "slipmode_tone.h"

#endif

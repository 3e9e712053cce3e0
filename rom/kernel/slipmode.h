/* slipmode: the numerical core shared by the Python packages and the FMU.
 *
 * Conventions
 *   - matrices are row-major; complex numbers are (re, im) pairs of doubles;
 *   - modal displacement q_j = a_j exp(i theta_j) + c.c., theta_j' = Omega_j;
 *   - S_j(|a_A|, |a_B|) = Q_j |a_j| is the tabulated friction term of mode j, eq. (20);
 *   - no globals; memory is taken only by functions whose name ends in _create;
 *   - every entry returns an sm_status; sm_message() says it in words.
 */
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

#define SM_MODES 2 /* the method treats one or two forced modes */
#define SM_COMBINATIONS 16  /* combination resonances that a slow flow may have at most */
#define SM_MOST_FIELDS (2 * (SM_MODES + SM_COMBINATIONS + 1)) /* of a table */
#define SM_RATE_CORRECTIONS (2 * SM_MODES * SM_MODES)             /* of a table of two modes */

typedef enum {
    SM_OK = 0,
    SM_BAD_ARGUMENT,   /* a size, sign or order that is not allowed */
    SM_NOT_FINITE,     /* NaN or infinity in an input or in a computed state */
    SM_NO_MEMORY,
    SM_NOT_CONVERGED,  /* the implicit contact step did not reach its tolerance */
    SM_OUTSIDE_TABLE,  /* an amplitude left what is tabulated */
    SM_STEP_TOO_SMALL  /* the slow flow cannot meet its tolerance */
} sm_status;

SM_API const char *sm_message(sm_status status);

/* ---- friction and the contact problem ------------------------------------------------ */

typedef enum { SM_TANH = 0, SM_COULOMB = 1, SM_ELASTIC = 2 } sm_law;

/* Elastic contacts: springs while they stick, each with its law on one to three contact DOFs. */
typedef enum { SM_SLIDERS = 0, SM_FRICTIONAL = 1 } sm_element_law;
typedef enum { SM_STICK = 0, SM_SLIP = 1, SM_OPEN = 2 } sm_contact_state;

typedef struct {
    int32_t law;                   /* sm_element_law */
    int32_t column[3];             /* contact DOFs: tangential ones, then the normal */
    int32_t first_slider, sliders; /* SM_SLIDERS: Jenkins elements side by side */
    int32_t tangents;              /* SM_FRICTIONAL: 1 or 2 tangential directions */
    double friction;               /* mu */
    double preload;                /* normal force at rest [N] */
    double tangential_stiffness, normal_stiffness; /* [N/m] */
    double gap;                    /* normal displacement at which it touches [m] */
} sm_element;

typedef struct {
    int32_t elements, sliders;
    const sm_element *element;
    const double *slider;    /* (sliders, 2) limit [N], stiffness [N/m] */
    const double *reference; /* (N_c) stiffness that the structure's modes have there [N/m] */
} sm_elastic;

/* Doubles that the contacts remember: where their sliders are, where they were [m]. At rest zeros. */
SM_API size_t sm_elastic_memory(const sm_elastic *elastic);

/* Forces less preload (N_c) on contacts at displacements x (N_c). The memory is moved along, from
 * before to after the contacts get there. */
SM_API sm_status sm_elastic_force(const sm_elastic *elastic, int32_t contacts, const double *x,
                                  double *memory, double *force);

/* Static displacements x (N_c) of the contacts, and the forces on them less the preload, in one step
 * from rest. The structure moves the contacts to `displacement` (N_c) if all of them stick; its
 * `flexibility` (N_c, N_c) is that to the force deficit of the reference springs.
 * SM_NOT_CONVERGED if nothing holds the structure. */
SM_API sm_status sm_elastic_equilibrium(const sm_elastic *elastic, int32_t contacts,
                                        const double *flexibility, const double *displacement,
                                        double *x, double *force);

/* A harmonic (n, m) of the contact motion whose frequency n Omega_A + m Omega_B comes near the
 * carrier of a mode: it drives that mode by T = -L^T P_nm. */
typedef struct {
    int32_t mode, n, m;
} sm_combination;

/* How the modes respond to harmonics of the contact motion that are not their carrier. */
typedef struct {
    int32_t orders_count;
    const int32_t *orders; /* (orders_count, 2) harmonics (n, m) */
    /* The first `asked` harmonics are requested; 0: all. On the torus, the other harmonics of
     * sliders converge only as far as modes respond to them. */
    int32_t asked;
    /* (orders_count, N_c, N_c, 2) H_nm(nu): force on the contacts per P_nm, a symmetric matrix.
     * Only the torus reads it; along a trajectory the segments bring the force. */
    const double *dynamic_stiffness;
    /* Modes that are integrated along with elastic contacts, in steps of the torus; their response
     * is neither in K nor in H. The force on mode k is g = drawn_k y, and over a step from y_0 to y_1
     *   p_1 = advance_k (p_0, v_0, g_0, g_1),  v_1 = advance_k+4 (p_0, v_0, g_0, g_1),
     * except that the part of g_1 in p_1 is in K. */
    int32_t marched;
    const double *drawn;   /* (marched, N_c) */
    const double *advance; /* (marched, 8) */
    /* (orders_count, marched, 2, 2) p and v at t = 0 per harmonic of g, once they are periodic. */
    const double *periodic;
    /* (orders_count, N_c, 2) initial guess of the harmonics that the modes respond to, the same for
     * every point of the torus; NULL: 0. */
    const double *start;
    /* (orders_count, N_c, 2) harmonics of a further force on the contacts; NULL: none. Only the
     * torus reads it. */
    const double *held;
} sm_modal_response;

/* [M x'' +] D x' + K x + g(x') = -2 Re sum_j L_j a_j exp(i theta_j): eq. (12), with inertia and
 * damping of the contacts.
 *
 * Elastic contacts have the dual problem, x(y) + K y = -2 Re sum_j L_j a_j exp(i theta_j), with the
 * force deficit y of their reference springs and K = -(flexibility of the structure). Then y takes
 * the place of the contact displacement. */
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

/* How the torus of the phases t_A, t_B is discretised: `lines` phase lines of `steps` time steps per
 * period of mode A, and which Fourier coefficients of the motion are computed. */
typedef struct {
    const double *rates;     /* (modes) carrier frequencies [rad/s] */
    int32_t steps;           /* 4 or more */
    int32_t lines;           /* 1 or more; of rigid contacts a power of 2 */
    int32_t orders_count;
    const int32_t *orders;   /* (orders_count, 2) harmonic indices (n, m), one of each pair +-(n, m);
                                contact->response, if there is one, is for the same harmonics */
    /* Only sm_torus_harmonics reads what follows. */
    double tolerance;        /* largest change of a harmonic that counts as periodic, relative to the
                                frictionless displacement of the contacts by its mode */
    const double *smallest_scale; /* (modes) amplitudes whose frictionless displacement is the scale
                                where it is larger than at the point */
    int32_t max_periods;     /* of mode A, 1 to 2000 */
} sm_discretisation;

/* Points of the amplitude plane at which the motion is computed. */
typedef struct {
    size_t count;
    const double *amplitudes; /* (count, modes), >= 0 */
    const double *near;       /* (count, orders_count, N_c, 2) initial guess of the harmonics, of elastic
                                 contacts and where modes respond strongly to rigid ones; if it fails, the
                                 search starts from contact->response->start and then from rest. NULL:
                                 of elastic contacts, the harmonics of the point before */
} sm_torus_points;

/* Periodic motion at the points. */
typedef struct {
    double *harmonics;   /* (count, orders_count, N_c, 2) P_nm */
    double *mean_square; /* (count, N_c) of the displacement: the harmonics not computed have the mean
                            square mean_square - 2 sum |P_nm|^2 */
    double *residual;    /* (count) estimated distance from periodicity at the end of the march. It
                            exceeds the tolerance if max_periods was reached, or if the harmonics change
                            from period to period by the error of the grid: then they and mean_square
                            are means, and this is the distance of the last harmonics from the mean */
    int32_t *marched;    /* (count) time steps along each line */
} sm_torus_motion;

/* Harmonics of the periodic contact motion on the torus, eqs. (13) and (14), by characteristics. */
SM_API sm_status sm_torus_harmonics(const sm_contact *contact, const sm_discretisation *grid,
                                    const sm_torus_points *points, const sm_torus_motion *motion);

/* Harmonics of the contact motion while the amplitudes grow, for the rate correction of S_j: over two
 * periods of mode A, from rest through `amplitudes` in the middle of these periods. The difference of
 * two results is the effect of the growth; the modes respond at their carrier only.
 *   amplitudes, growth (points, modes): the growth is per period of mode A
 *   harmonics          (points, orders_count, N_c, 2), weighted by a hat over the two periods */
SM_API sm_status sm_torus_growing(const sm_contact *contact, const sm_discretisation *grid,
                                  size_t points, const double *amplitudes, const double *growth,
                                  double *harmonics);

/* ---- motion of the contacts along a slow trajectory ----------------------------------- */

/* A stretch of slow time on which every input is a straight line in time. */
typedef struct {
    double start, duration;                    /* [s] */
    double amplitude_start[2 * SM_MODES];      /* a_j at the start */
    double amplitude_end[2 * SM_MODES];        /* a_j at the end */
    double rate_start[2 * SM_MODES];           /* da_j/dt at the start */
    double rate_end[2 * SM_MODES];             /* da_j/dt at the end */
    double angle[SM_MODES];                    /* theta_j at the start [rad] */
    double frequency[SM_MODES];                /* Omega_j at the start [rad/s] */
    double frequency_rate[SM_MODES];           /* dOmega_j/dt [rad/s^2] */
    /* (response->orders_count, N_c, 2) G_nm at the start and the end, or NULL: the modes' response
     * acts on the contacts with Re sum G_nm exp(i (n theta_A + m theta_B)) [N] */
    const double *reaction_start, *reaction_end;
} sm_segment;

/* Samples of the contact motion at increasing times; arrays (count, N_c), NULL: not wanted. */
typedef struct {
    size_t count;
    const double *times;
    double *displacement, *velocity, *force;
} sm_contact_samples;

/* Contact motion inside consecutive segments, marched from displacement `start_x` (N_c; NULL: 0) at
 * the start of the first one. */
SM_API sm_status sm_contact_motion(const sm_contact *contact, size_t segments,
                                   const sm_segment *segment, const double *start_x,
                                   int32_t steps_per_period, const sm_contact_samples *samples);

/* Signals that are sums of harmonics with coefficients that vary slowly:
 *   x_s(t) = 2 Re (sum_j shape_js a_j exp(i theta_j) + sum_q c_qs exp(i (n_q theta_A + m_q theta_B)))
 * with the a_j of the segments, and c straight between their ends. */
typedef struct {
    int32_t modes;             /* 1 or 2 */
    int32_t orders_count;
    const int32_t *orders;     /* (orders_count, 2) */
    size_t signals;
    const double *shape;       /* (modes, signals) */
    const double *coefficient; /* (segments + 1, signals, 2, orders_count): real, imaginary */
} sm_harmonic_sum;

/* The signals at increasing times inside consecutive segments: motion (samples, signals). */
SM_API sm_status sm_harmonic_motion(const sm_harmonic_sum *sum, size_t segments,
                                    const sm_segment *segment, size_t samples,
                                    const double *times, double *motion);

/* ---- friction tables ------------------------------------------------------------------ */

/* Bicubic Hermite surface of S_j, of the combination-resonant terms T_k if there are any, and of
 * two powers if they are known. Re: friction power less the power from the modes and the forces.
 * Im: power from the forces that hold the amplitudes steady, besides their shift of the amplitudes.
 * For one mode: count_b = 1 and node_b = NULL.
 * values (count_a, count_b, 4, 2 (modes + combinations + power)):
 * value, d/da, d/db, d2/dadb of (Re, Im) of each S_j, of each T_k, of the powers. */
typedef struct {
    int32_t modes;
    int32_t combinations;
    int32_t power; /* 1: the powers are tabulated; 0: friction takes all that leaves the modes */
    int32_t count_a, count_b;
    const double *node_a, *node_b;
    const double *values;
    /* (count_a, count_b, 4, 2 modes modes): dS_j / d(d|a_k|/dt), by mode j and k, in the same way:
     * while amplitudes grow, friction is behind that of steady motion. NULL: it does not. */
    const double *rate_correction;
    /* (count_a, count_b, 4, 2 modes modes): dS_j / dOmega_k at the carriers of the table, alike.
     * NULL: S_j is the same at all forcing frequencies. */
    const double *detuning;
} sm_table;

SM_API sm_status sm_table_check(const sm_table *table);
/* All columns s (points, 2 (modes + combinations + power)) at amplitudes (points, modes).
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
    double off_resonance[SM_MODES][2];  /* effective: a_j + off_resonance_j F_j exp(i ph_j) */
    double cross_response[SM_MODES][SM_MODES][2]; /* [k][j]: displacement of mode k off resonance
                                             per F_j exp(i ph_j) of another mode, 0 for its own */
    double other_modes[SM_MODES][2][2];  /* displacement of the DOFs that force j loads, by all
                                            modes but j: per F_j exp(i ph_j), and per a_j */
    sm_combination combination[SM_COMBINATIONS];      /* table.combinations of them */
    double ratio; /* Omega_B / Omega_A of modes on one tone, whose combination resonances are
                     steady; 0: a tone for each mode */
} sm_slow_flow;

/* Inputs over a step: value at its start and rate of change during it. */
typedef struct {
    double force[SM_MODES], force_rate[SM_MODES];         /* modal F_j [N kg^-1/2] */
    double frequency[SM_MODES], frequency_rate[SM_MODES]; /* Omega_j [rad/s] */
    double phase[SM_MODES], phase_rate[SM_MODES];         /* of the force [rad], [rad/s] */
    double limit_scale, limit_scale_rate; /* friction limits relative to those of the table, > 0;
                                             other than 1 right for laws that are homogeneous,
                                             where S(|a|; s mu N) = s S(|a| / s; mu N) [-], [1/s] */
    double angle[SM_MODES];   /* theta_j at the start [rad]; the component sets it itself */
} sm_inputs;

/* da_j/dt, and the powers (2) of input and friction, `elapsed` seconds after the inputs' start. */
SM_API sm_status sm_slow_flow_rate(const sm_slow_flow *flow, const sm_inputs *inputs,
                                   double elapsed, const double *amplitude, double *rate,
                                   double *powers);

/* Amplitudes (modes, 2) and inputs, or changes of both. */
typedef struct {
    const double *amplitude;
    const sm_inputs *inputs;
} sm_slow_point;

/* First-order changes of rates and powers along a direction in amplitudes and all inputs. */
SM_API sm_status sm_slow_flow_directional(const sm_slow_flow *flow, const sm_slow_point *at,
                                          const sm_slow_point *along, double *d_rate,
                                          double *d_powers);

/* da_j/dt at many points, each with inputs of its own: amplitude, rate (points, modes, 2).
 * SM_OUTSIDE_TABLE if a point is outside the table; it is NaN then, and the others are right. */
SM_API sm_status sm_slow_flow_rates(const sm_slow_flow *flow, size_t points,
                                    const sm_inputs *inputs, const double *amplitude,
                                    double *rate);

/* What balances in steady motion, without a'' and without the combination resonances, whose mean
 * over time is zero:
 *   balance  (points, 4, modes, 2): mass_j, stiffness_j, Q_j a_j and da_j/dt
 *   jacobian (points, 2 modes, 2 modes) of da_j/dt by (Re, Im) of the amplitudes; NULL: not wanted
 * SM_OUTSIDE_TABLE if a point is outside the table; it is NaN then, and the others are right. */
SM_API sm_status sm_slow_flow_balance(const sm_slow_flow *flow, size_t points,
                                      const sm_inputs *inputs, const double *amplitude,
                                      double *balance, double *jacobian);

/* ---- solution curves ------------------------------------------------------------------- */

#define SM_CURVE_UNKNOWNS 10 /* at most */

/* F (k) and its Jacobian (k, k + 1) at z = (y (k), p); all but SM_OK: there is none. */
typedef sm_status (*sm_curve_rates)(const void *of, const double *z, double *F, double *J);

/* F(y, p) = 0, scaled so that 1 is large in each direction. A point of it is a row of doubles:
 *   z (k + 1), tangent (k + 1) of length 1, dF/dy (k, k).
 */
typedef struct {
    int32_t unknowns;    /* k */
    double largest_step; /* between two points */
    sm_curve_rates rates;
    const void *of;
    double noise; /* largest change of z by errors of the rates: 0 if they are exact */
} sm_curve;

/* Points to both sides of where it was found; closed: the last one is followed by the first. */
typedef struct {
    size_t before, after;
    int32_t closed;
} sm_branch;

/* The curve through a solution near `start`, at the same p, which becomes points[most - 1] of 2 most -
 * 1: to p = 0, p = 1, where F ends, or, then it is closed, back to where it began; at most `most` points
 * on each side. SM_NOT_CONVERGED: there is no solution close by. */
SM_API sm_status sm_curve_branch(const sm_curve *curve, const double *start, size_t most,
                                 double *points, sm_branch *branch);
/* The point of the curve near a guess (k + 1), in the plane through it with this normal (k + 1); its
 * tangent points onward (k + 1). SM_NOT_CONVERGED: there is none. */
SM_API sm_status sm_curve_point_near(const sm_curve *curve, const double *guess,
                                     const double *normal, const double *onward, double *point);

/* The solution with the p of z (k + 1), which may be far from it, and which it replaces.
 * SM_NOT_CONVERGED: none is found. */
SM_API sm_status sm_curve_solved(const sm_curve *curve, double *z);

/* 1 if a solution z lies on a branch: `points` rows that follow one another by `stride` doubles. */
SM_API int32_t sm_curve_passes(int32_t unknowns, size_t points, size_t stride, const double *row,
                               const double *z);
/* 1 if all small deviations from a point, a row, decay. */
SM_API int32_t sm_curve_is_stable(int32_t unknowns, const double *row);

/* A slow flow under inputs that change along a straight line. */
typedef struct {
    const sm_slow_flow *flow;
    const sm_inputs *inputs; /* (2): at p = 0 and 1; force, frequency and limit_scale change */
    double scale[SM_MODES];  /* of amplitudes: y = a / (scale limit_scale), F = y' */
} sm_forced;

/* Its steady states as a curve, as sm_slow_flow_balance has them. The curve refers to `forced`. */
SM_API sm_status sm_forced_curve(const sm_forced *forced, double largest_step, sm_curve *curve);
/* Steady states z (found, k + 1) of the curve, at most `most`, at `sections` >= 2 values of p from 0
 * to 1. They are searched from many amplitudes up to `scale` and all phases that balance the forces. */
SM_API sm_status sm_forced_solutions(const sm_forced *forced, int32_t sections, size_t most,
                                     double *z, size_t *found);

/* ---- the step-able component ----------------------------------------------------------- */

typedef struct sm_component sm_component;

/* Motion at the communication point. The modes respond to harmonics (n, m) of the contact motion:
 * their response acts on the contacts with Re sum G_nm exp(i (n theta_A + m theta_B)), and moves
 * the elastic outputs by Re sum E_nm exp(...); G and E are straight between the nodes of the
 * friction table. Elastic outputs are x = 2 Re sum_j (modes_out_j a_j + forces_out_j F_j
 * exp(i phase_j)) exp(i theta_j) + contacts_out x_c + E. */
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
    double memory_periods;       /* periods of the slower carrier marched before a communication
                                    point; what was marched before is continued */
} sm_motion;

/* Arrays of the arguments are not copied and must outlive the component. */
SM_API sm_status sm_component_create(const sm_slow_flow *flow, const sm_contact *contact,
                                     const sm_motion *motion, double tolerance,
                                     sm_component **component);
/* What a component is made of, whatever its tolerance. */
SM_API sm_status sm_component_check(const sm_slow_flow *flow, const sm_contact *contact,
                                    const sm_motion *motion);
/* As sm_component_create, for arguments that sm_component_check has accepted; damping and
 * motion.wanted may have changed since. */
SM_API sm_status sm_component_checked_create(const sm_slow_flow *flow, const sm_contact *contact,
                                             const sm_motion *motion, double tolerance,
                                             sm_component **component);
SM_API void sm_component_free(sm_component *component);
/* Start at `time` with amplitudes (modes, 2), angles 0, energy 0, contacts at rest. */
SM_API sm_status sm_component_reset(sm_component *component, double time,
                                    const double *amplitude);
/* Go on from amplitudes (modes, 2) that something else found, at the present time and angles. */
SM_API sm_status sm_component_set_amplitude(sm_component *component, const double *amplitude);
/* SM_BAD_ARGUMENT if the limits are scaled where the law is not homogeneous: tanh, gaps. */
SM_API sm_status sm_component_set_inputs(sm_component *component, const sm_inputs *inputs);
/* Advance by `duration` > 0. On any status but SM_OK the state is as before the call. An amplitude
 * that a change of force leaves beyond the edge of the table stays at the edge. */
SM_API sm_status sm_component_step(sm_component *component, double duration);
/* The same by one internal step, or where these are too short to matter by several, at most by
 * `most` > 0; `taken` says by how much. */
SM_API sm_status sm_component_advance(sm_component *component, double most, double *taken);

/* Outputs, packed: time, (Re, Im) of a_A and a_B, theta_A, theta_B, input power, power and energy
 * dissipated at the contacts; with motion.wanted also x_c, v_c, f_c (3 N_c) and the elastic
 * displacements. A mode that the model does not have reads 0. */
#define SM_OUTPUTS_FIXED 10
SM_API size_t sm_component_output_count(const sm_component *component);
SM_API sm_status sm_component_outputs(sm_component *component, double *outputs);
/* The SM_OUTPUTS_FIXED of them, and the rest: contacts are marched when they are read, from where
 * they were read last, or for as long as they remember; elastic displacements where `elastic`.
 * SM_BAD_ARGUMENT unless motion.wanted. */
SM_API sm_status sm_component_slow_outputs(const sm_component *component, double *outputs);
SM_API sm_status sm_component_motion(sm_component *component, int elastic, double *motion);

/* The same motion, x_c, v_c, f_c (3 N_c) and the elastic displacements, from any amplitudes that have
 * moved at `rate` (modes, 2 each) for the last periods; `inputs` with their angles. `smooth`: less
 * closely, in steps that stay the same as these change a little, for derivatives. The state stays as
 * it is. SM_BAD_ARGUMENT unless motion.wanted. */
SM_API sm_status sm_component_recent_motion(sm_component *component, const sm_inputs *inputs,
                                            const double *amplitude, const double *rate,
                                            int smooth, double *motion);

/* `steps` steps with inputs[k] over durations[k]; outputs (steps, output_count) after each.
 * `done` counts the steps by which the state has advanced. If the contact motion after one cannot be
 * computed, its outputs are NaN, and this step is the last. */
SM_API sm_status sm_component_run(sm_component *component, size_t steps, const double *durations,
                                  const sm_inputs *inputs, double *outputs, size_t *done);

/* Rows of a trace, and how far it has come: `done` steps and `elapsed` seconds of the next one, 0 in
 * the first call. */
typedef struct {
    size_t capacity, count; /* rows that there is room for; rows of this call */
    double *outputs;        /* (capacity, output_count) */
    size_t done;
    double elapsed;
} sm_trace;

/* As sm_component_run, with outputs after each internal step. It returns when the steps are done or
 * the rows are full; the next call goes on from there. */
SM_API sm_status sm_component_trace(sm_component *component, size_t steps, const double *durations,
                                    const sm_inputs *inputs, sm_trace *trace);

/* State as doubles, position-independent: time, amplitudes, angles, energy, step, contacts. */
SM_API size_t sm_component_state_count(const sm_component *component);
SM_API sm_status sm_component_get_state(const sm_component *component, double *state);
SM_API sm_status sm_component_set_state(sm_component *component, const double *state);
/* Accepted and rejected internal steps since creation. */
SM_API void sm_component_work(const sm_component *component, uint64_t *accepted,
                              uint64_t *rejected);

#include "slipmode_full.h"
#include "slipmode_tone.h"

#endif

/* Friction tables, the slow flow with them, and curves of its steady states. rom/table/ and
 * rom/slow/ call them. */
#ifndef SLIPMODE_SLOW_H
#define SLIPMODE_SLOW_H

#include "slipmode.h"

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
 *   mass_j a_j' + (stiffness_j + sum_k h_jk |a_k|^2) a_j
 *       = F_j exp(i ph_j)/2 + Q_j a_j [+ combination resonances]. */
typedef struct {
    int32_t paper;              /* 1: carrier at the natural frequency; 0: at the forcing */
    double natural[SM_MODES];   /* omega_j [rad/s] */
    double spin[SM_MODES];      /* d omega_j^2 / d Omega_j^2 [-] of a rotor whose speed follows
                                   Omega_j; omega_j is then at the carrier. 0: omega_j is constant */
    double damping[SM_MODES];   /* phi_j^T C phi_j [1/s]; < 0: self-excited */
    sm_table table;
    double carrier[SM_MODES];   /* of a table with `detuning`, or of a rotor [rad/s] */
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
    double hardening[SM_MODES][SM_MODES]; /* h_jk: nonlinear stiffness of mode j per |a_k|^2
                                             [rad^2/s^2 per kg m^2], symmetric */
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
 *   balance  (points, 4, modes, 2): mass_j, stiffness_j + sum_k h_jk |a_k|^2, Q_j a_j and da_j/dt
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

#endif

/* Slow flow of many modes on one or two tones, under a force on each, with friction by contact
 * (docs/theory.md, "Several modes on one tone"). Python (rom/slow/tone/) and the FMU call it. */
#ifndef SLIPMODE_TONE_H
#define SLIPMODE_TONE_H

#include "slipmode.h"

/* Modes in first-order form, with their poles, n contacts and K outputs. A complex vector is stored
 * as its real parts, then its imaginary parts; a matrix as its columns. */
typedef struct {
    int32_t count;            /* M */
    const double *pole;       /* (2, M) s_m [1/s] */
    const double *excitation; /* (2, M) b_m, per magnitude of the force */
    const double *conjugate;  /* (2, M) as excitation, for the complex conjugate of the force */
    const double *motion;     /* (M, 2, n) psi: displacement of the contacts per amplitude */
    const double *projection; /* (n, 2, M) l: rate of the amplitudes per force deficit */
    const double *output;     /* (M, 2, K); NULL: no outputs */
} sm_tone_modes;

/* The structure at the carrier of one tone. Slow modes a_m' = (s_m - i Omega) a_m + b_m G +
 * sum_j l_mj y_j under the complex magnitude G = F exp(i phase) of the force. Fast modes are steady
 * at the present G, y and Omega. Contacts move by x_j = sum_m psi_jm a_m + X_j G + sum_i G_ji y_i, a
 * sum over all modes. */
typedef struct {
    sm_tone_modes slow, fast;
    int32_t amplitudes;        /* number of outputs that are amplitudes of modes */
    double reference;          /* Omega of the tables [rad/s] */
    const double *flexibility; /* (n + 1, 2, n) residual G_ji without modes and `own`; then X */
    const double *own;         /* (2, n) response of a contact to its own deficit [m/N] */
    const double *output;      /* (n + 1, 2, K) outputs per y and G. K = amplitudes + elastic + 1;
                                  the last output is conj(f) x, the displacement in the direction of
                                  the force pattern f; NULL: no outputs */
} sm_tone_carrier;

/* A force deficit y depends on the present drives c, the displacements without the contact's own
 * response, at the carriers t of all tones T:
 *   c_tj = x_tj - own_tj y_tj,   y_tj = k_tj(|c_Aj|, |c_Bj|) c_tj
 * k is tabulated over log((|c_A| + |c_B|) / onset - 1), and on two tones over the angle whose squared
 * tangent is |c_B| / |c_A|. */
typedef struct {
    int32_t tones;             /* T, 1 or 2 */
    sm_tone_carrier carrier[SM_MODES]; /* the first T are used */
    int32_t contacts;          /* n, a multiple of `kinds` */
    int32_t kinds;             /* number of tables of k: contact j has table j % kinds */
    int32_t nodes, shares;     /* of the tables, 2 or more: of the logarithm, and of the angle, which
                                  has one node on one tone */
    int32_t elastic;           /* number of outputs that are displacements of DOFs */
    int32_t contact_motion;    /* 1: contact motion is an output */
    const double *stiffness;   /* (n) of sticking contacts [N/m] */
    const double *onset;       /* (kinds) |c_A| + |c_B| at which slip begins [m]; k = 0 below the
                                  first node */
    double first, spacing;     /* the logarithm at the first node, and between nodes */
    const double *secant;      /* (nodes, shares, kinds, T, 2, T, 2): real and imaginary parts of k_t;
                                  each, and on two tones its derivative by the angle per spacing;
                                  each with its derivative by the logarithm per spacing */
    double contraction;        /* |k| |G|: factor by which an iteration of y reduces its error */
} sm_tone;

typedef struct sm_tone_flow sm_tone_flow;

/* Creates a flow at rest at time 0, at the reference frequencies and without force. Arrays of the
 * tone are not copied and must outlive the flow. `tolerance` is the error of a step relative to
 * the amplitudes. */
SM_API sm_status sm_tone_create(const sm_tone *tone, double tolerance, sm_tone_flow **flow);
/* Frees a flow. */
SM_API void sm_tone_free(sm_tone_flow *flow);
/* Sets the flow to rest at `time`, with the present inputs. */
SM_API sm_status sm_tone_reset(sm_tone_flow *flow, double time);
/* Sets the inputs from now on; inputs of mode t are of tone t. If they are discontinuous,
 * the displacements are continuous. On any status but SM_OK the state is as before the call, here
 * and below: SM_NOT_CONVERGED if no force deficits were found. */
SM_API sm_status sm_tone_set_inputs(sm_tone_flow *flow, const sm_inputs *inputs);
/* Advances by `duration` > 0. */
SM_API sm_status sm_tone_step(sm_tone_flow *flow, double duration);
/* Returns the present inputs, amplitudes of the slow modes, (2, M) for each tone, and force deficits
 * (T, 2, n). */
SM_API sm_status sm_tone_present(const sm_tone_flow *flow, sm_inputs *inputs, double *amplitude,
                                 double *deficit);

/* Returns the number of outputs: time; (Re, Im) of the amplitudes; theta of each tone; input power,
 * power and energy dissipated at the contacts; with contact_motion x, v, f (3 n) at the carriers;
 * displacements of the DOFs. */
SM_API size_t sm_tone_output_count(const sm_tone_flow *flow);
/* Computes all outputs. */
SM_API sm_status sm_tone_outputs(sm_tone_flow *flow, double *outputs);
/* Computes the outputs without the motion of contacts and DOFs. */
SM_API sm_status sm_tone_slow_outputs(sm_tone_flow *flow, double *outputs);
/* Makes `steps` steps with inputs[k] over durations[k], and computes the outputs (steps,
 * output_count) after each. `done` is the number of steps by which the state has advanced. */
SM_API sm_status sm_tone_run(sm_tone_flow *flow, size_t steps, const double *durations,
                             const sm_inputs *inputs, double *outputs, size_t *done);

/* Returns the number of doubles of the state, which contains no addresses. */
SM_API size_t sm_tone_state_count(const sm_tone_flow *flow);
/* Writes the state. */
SM_API sm_status sm_tone_get_state(const sm_tone_flow *flow, double *state);
/* Sets the state. */
SM_API sm_status sm_tone_set_state(sm_tone_flow *flow, const double *state);
/* Returns the numbers of accepted and rejected internal steps since creation. */
SM_API void sm_tone_work(const sm_tone_flow *flow, uint64_t *accepted, uint64_t *rejected);

#endif

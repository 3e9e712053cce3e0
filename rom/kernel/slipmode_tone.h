/* Slow flow of one tone: amplitudes of many modes under one force, with friction by contact. */
#ifndef SLIPMODE_TONE_H
#define SLIPMODE_TONE_H

#include "slipmode.h"

/* Modes of first order, by their poles, with n contacts and K outputs. Vectors are real parts, then
 * imaginary parts; matrices are columns of these. */
typedef struct {
    int32_t count;            /* M */
    const double *pole;       /* (2, M) s_m [1/s] */
    const double *excitation; /* (2, M) b_m, per magnitude of the force */
    const double *conjugate;  /* (2, M) the same for its complex conjugate */
    const double *motion;     /* (M, 2, n) psi */
    const double *projection; /* (n, 2, M) l */
    const double *output;     /* (M, 2, K); NULL: no outputs */
} sm_tone_modes;

/* Slow modes a_m' = (s_m - i Omega) a_m + b_m G + sum_j l_mj y_j under the complex magnitude
 * G = F exp(i phase) of the force. Fast modes are steady at the present G, y and Omega. Contacts
 * move by x_j = sum_m psi_jm a_m + X_j G + sum_i G_ji y_i over all modes. Their force deficits y
 * follow their drives c at once:
 *   c_j = x_j - own_j y_j,   y_j = k_j(|c_j|) c_j */
typedef struct {
    sm_tone_modes slow, fast;
    int32_t contacts;          /* n, a multiple of `kinds` */
    int32_t kinds;             /* of contacts: contact j has table j % kinds */
    int32_t nodes;             /* of the tables, 2 or more */
    int32_t amplitudes;        /* outputs that are amplitudes of modes */
    int32_t elastic;           /* outputs after these: displacements of DOFs */
    int32_t contact_motion;    /* 1: contact motion is an output */
    double reference;          /* Omega of the tables [rad/s] */
    const double *flexibility; /* (n + 1, 2, n) G_ji of what is not a mode, less own; then X */
    const double *own;         /* (2, n) */
    const double *stiffness;   /* (n) of sticking contacts [N/m] */
    const double *output;      /* (n + 1, 2, K): by y and G. K = amplitudes + elastic + 1, the last
                                  one is what the force moves, conj(f) x; NULL: no outputs */
    double onset;              /* k = 0 up to |c| = onset (1 + past of the first node) */
    double first, spacing;     /* log(|c| / onset - 1) at the first node, and between nodes */
    const double *secant;      /* (nodes, kinds, 2, 2) k and its slope per node, real, imaginary */
    double contraction;        /* |k| |G|: how strongly contacts act on each other */
} sm_tone;

typedef struct sm_tone_flow sm_tone_flow;

/* At rest at time 0, at the reference frequency without force. Arrays of the tone are not copied and
 * must outlive the flow. `tolerance` is of a step, relative to the amplitudes. */
SM_API sm_status sm_tone_create(const sm_tone *tone, double tolerance, sm_tone_flow **flow);
SM_API void sm_tone_free(sm_tone_flow *flow);
/* At rest at `time`, with the present inputs. */
SM_API sm_status sm_tone_reset(sm_tone_flow *flow, double time);
/* The inputs of mode A from now on: `force` is F. The displacements are continuous where they jump.
 * On any status but SM_OK the state is as before the call: SM_NOT_CONVERGED if no deficits were
 * found; so in all that follows. */
SM_API sm_status sm_tone_set_inputs(sm_tone_flow *flow, const sm_inputs *inputs);
/* Advance by `duration` > 0. */
SM_API sm_status sm_tone_step(sm_tone_flow *flow, double duration);
/* The present inputs, amplitudes of the slow modes (2, M), and deficits (2, n). */
SM_API sm_status sm_tone_present(const sm_tone_flow *flow, sm_inputs *inputs, double *amplitude,
                                 double *deficit);

/* Outputs, packed: time; (Re, Im) of the amplitudes; theta; input power, power and energy dissipated
 * at the contacts; with contact_motion x, v, f (3 n) at the carrier; displacements of the DOFs. */
SM_API size_t sm_tone_output_count(const sm_tone_flow *flow);
SM_API sm_status sm_tone_outputs(sm_tone_flow *flow, double *outputs);
/* Those before the motion of contacts and DOFs. */
SM_API sm_status sm_tone_slow_outputs(sm_tone_flow *flow, double *outputs);
/* `steps` steps with inputs[k] over durations[k]; outputs (steps, output_count) after each. `done`
 * counts the steps by which the state has advanced. */
SM_API sm_status sm_tone_run(sm_tone_flow *flow, size_t steps, const double *durations,
                             const sm_inputs *inputs, double *outputs, size_t *done);

/* State as doubles, position-independent. */
SM_API size_t sm_tone_state_count(const sm_tone_flow *flow);
SM_API sm_status sm_tone_get_state(const sm_tone_flow *flow, double *state);
SM_API sm_status sm_tone_set_state(sm_tone_flow *flow, const double *state);
/* Accepted and rejected internal steps since creation. */
SM_API void sm_tone_work(const sm_tone_flow *flow, uint64_t *accepted, uint64_t *rejected);

#endif

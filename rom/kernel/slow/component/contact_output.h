/* The contact motion of a component at its communication points, eq. (12). */
#ifndef SLIPMODE_CONTACT_OUTPUT_H
#define SLIPMODE_CONTACT_OUTPUT_H

#include "slow/component/response_surface.h"
#include "slow/component/stretch_queue.h"
#include "slow/motion/contact_march.h"

/* The contacts of a component: their state, and the slow motion since then. */
typedef struct {
    sm_motion motion;
    sm_contact contact;         /* with scaled_limit as friction limits */
    sm_modal_response response; /* of `contact`: the harmonics (n, m) of `motion` */
    const double *limit;        /* (N_c) friction limits of the model [N] */
    double *scaled_limit;       /* (N_c) friction limits at the present limit scale [N] */
    double *state;              /* of the contacts where the queue begins: x_c, v_c, f_c first */
    sm_stretch_queue *queue;
    double *state_before;       /* state and queue at the start of the step of the component */
    sm_stretch_queue *queue_before;
    sm_march march;
    double *reaction[2]; /* (orders_count, N_c, 2) at the start and the end of a stretch */
} sm_contact_output;

/* Checks the arrays and numbers of the motion. */
sm_status sm_motion_check(const sm_motion *motion, const sm_contact *contact,
                          const sm_table *table);

/* Places the arrays. The output must not be moved in memory afterwards, and the arrays of motion
 * and contact must outlive it. */
void sm_contact_output_place(sm_contact_output *out, const sm_motion *motion,
                             const sm_contact *contact, sm_block *block);

/* Saves state and queue at the start of a step, or restores them if `back`: after a failure. */
void sm_contact_output_save(sm_contact_output *out, int back);

/* Adds an internal step of the slow flow that starts with inputs `begin`. */
sm_status sm_contact_output_add(sm_contact_output *out, const sm_time_step *step,
                                const sm_inputs *begin, const sm_flow_point *from,
                                const sm_flow_point *to);

/* Sets the contacts at rest. */
void sm_contact_output_reset(sm_contact_output *out);

/* Returns the number of doubles of state and queue. It does not depend on motion.wanted, which may
 * change before a state is set again. */
size_t sm_contact_output_state_count(const sm_contact_output *out);
/* Writes state and queue as doubles. */
void sm_contact_output_get_state(const sm_contact_output *out, double *values);
/* Checks the doubles of a queue in a state. */
sm_status sm_contact_output_check_state(const sm_contact_output *out, const double *values);
/* Sets state and queue from doubles. */
void sm_contact_output_set_state(sm_contact_output *out, const double *values);

/* Integrates the contacts over the queue up to the present amplitudes y and inputs. Writes x_c,
 * v_c, f_c and, if `elastic`, the elastic displacements. */
sm_status sm_contact_output_read(sm_contact_output *out, const sm_slow_flow *flow,
                                 const sm_inputs *inputs, const double *y, int elastic,
                                 double *values);

/* Integrates the contacts from rest over the memory of the contacts, with amplitudes that change at
 * `rate` and reach `at`. Writes x_c, v_c, f_c and the elastic displacements. */
sm_status sm_contact_output_recent(sm_contact_output *out, const sm_slow_flow *flow,
                                   const sm_slow_point *at, const double *rate, sm_detail detail,
                                   double *values);

/* Adds the shift of the amplitudes by the forces (docs/theory.md, "Off-resonance forces") and its
 * rate. */
void sm_add_shift(const sm_slow_flow *flow, const sm_inputs *inputs, double *amplitude,
                  double *rate);
/* Computes elastic displacements x from amplitudes y and contact motion (x_c, v_c, f_c). */
void sm_elastic_output(const sm_contact_output *out, const sm_slow_flow *flow,
                       const sm_inputs *inputs, const double *y, const double *contact, double *x);

#endif

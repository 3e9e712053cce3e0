/* The contact motion of a component at its communication points.
 *
 * Contacts are marched where they are read: until then the slow motion waits in a queue. It has
 * room for as long as contacts remember, so that unread ones cost next to nothing.
 */
#ifndef SLIPMODE_CONTACT_OUTPUT_H
#define SLIPMODE_CONTACT_OUTPUT_H

#include "slow/component/stretch_queue.h"
#include "slow/instant.h"
#include "slow/motion/contact_march.h"

/* What the modes respond to the harmonics of the contacts, tabulated over the amplitude plane.
 *
 * Straight between the nodes of a friction table: the response is a few per cent of the motion, so
 * that a surface of higher order would gain nothing.
 */

/* Where in a table the contacts are, and how their harmonics are rotated and scaled. */
typedef struct {
    size_t node[4];
    double weight[4];          /* of those nodes, times the scale of the friction limits */
    sm_complex unit[SM_MODES]; /* exp(i arg) of the effective amplitude; 0 at rest */
} sm_response_point;

/* At amplitudes y under `inputs`, to which `instant` is set. Equal arguments give equal bits. */
sm_response_point sm_response_point_at(const sm_slow_flow *flow, sm_instant *instant,
                                       const sm_inputs *inputs, const double *y);

/* Of `width` signals with harmonics `values` (nodes, orders, width, 2):
 * their coefficients (orders, width, 2) there, */
void sm_response_coefficients(const sm_response_point *point, int count, const int32_t *orders,
                              size_t width, const double *values, double *coefficient);
/* and their sums Re sum c_nm exp(i (n theta_A + m theta_B)), added to signal (width). */
void sm_response_add_sums(const sm_response_point *point, int count, const int32_t *orders,
                          size_t width, const double *values, const sm_complex carrier[SM_MODES],
                          double *signal);

typedef struct {
    sm_motion motion;
    sm_contact contact;        /* its limits are scaled_limit */
    sm_modal_response response;    /* of the contact: the orders of the motion */
    const double *limit;       /* (N_c) friction limits of the model */
    double *scaled_limit;      /* (N_c) as they are in the march */
    double *state;             /* of the march, where the queue begins: x_c, v_c, f_c first */
    sm_stretch_queue *queue;
    struct {                   /* both as a step of the component found them: */
        int first, count, whole; /* 1: the rest is there as well */
        sm_stretch last;
        sm_inputs end;
        sm_stretch_queue *queue;
        double *state;
    } before;
    sm_instant instant;
    sm_march march;
    double *reaction[2]; /* (orders_count, N_c, 2) at the start and the end of a stretch */
    int reaction_known;            /* 1: reaction[1] is that of the inputs and amplitudes here */
    sm_inputs reaction_inputs;
    double reaction_amplitude[2 * SM_MODES];
} sm_contact_output;

sm_status sm_motion_check(const sm_motion *motion, const sm_contact *contact,
                          const sm_table *table);

/* The output does not move then; arrays of motion and contact outlive it. */
void sm_contact_output_place(sm_contact_output *out, const sm_motion *motion,
                             const sm_contact *contact, sm_block *block);

/* Begins a step, */
void sm_contact_output_begin(sm_contact_output *out);
/* adds a stretch that ends with inputs `end`, */
sm_status sm_contact_output_add(sm_contact_output *out, const sm_slow_flow *flow,
                                const sm_stretch *stretch, const sm_inputs *end);
/* and keeps the step, or restores the queue as it was before. */
void sm_contact_output_commit(sm_contact_output *out, const sm_slow_flow *flow);
void sm_contact_output_abandon(sm_contact_output *out);

/* Contacts at rest, and all of it as doubles: as many where the motion is not wanted, for whether
 * it is may change before a state is put back. */
void sm_contact_output_reset(sm_contact_output *out);
size_t sm_contact_output_state_count(const sm_contact_output *out);
void sm_contact_output_get_state(const sm_contact_output *out, double *values);
sm_status sm_contact_output_check_state(const sm_contact_output *out, const double *values);
void sm_contact_output_set_state(sm_contact_output *out, const double *values);

/* x_c, v_c, f_c and, if `elastic`, elastic displacements: at the present, */
sm_status sm_contact_output_read(sm_contact_output *out, const sm_slow_flow *flow,
                                 const sm_inputs *inputs, const double *y, int elastic,
                                 double *values);
/* or after a march from rest with amplitudes that move at `rate`. */
sm_status sm_contact_output_recent(sm_contact_output *out, const sm_slow_flow *flow,
                                   const sm_slow_point *at, const double *rate, sm_detail detail,
                                   double *values);

#endif

/* The contact motion of a component at its communication points. */
#ifndef SLIPMODE_CONTACT_OUTPUT_H
#define SLIPMODE_CONTACT_OUTPUT_H

#include "slow/instant.h"
#include "slow/motion/contact_motion.h"

/* Between two instants of a step: inputs with their angles, amplitudes and their rates. */
typedef struct {
    double duration;
    const sm_inputs *start, *end;
    const double *y, *rate, *y_end, *rate_end;
} sm_slow_stretch;

typedef struct {
    sm_motion motion;
    sm_contact contact;        /* its limits are scaled_limit */
    sm_modal_response response;    /* of the contact: the orders of the motion */
    const double *limit;       /* (N_c) friction limits of the model */
    double *scaled_limit;      /* (N_c) as they are in the march */
    double *state;             /* of the march at the communication point: x_c, v_c, f_c first */
    sm_elastic elastic;        /* of the contact, where its law is that */
    sm_march march;
    double *reaction[2]; /* (orders_count, N_c, 2) at the start and the end of a stretch */
    int reaction_known;            /* 1: reaction[1] is that of the inputs and amplitudes here */
    sm_inputs reaction_inputs;
    double reaction_amplitude[2 * SM_MODES];
} sm_contact_output;

sm_status sm_motion_check(const sm_motion *motion, const sm_contact *contact,
                          const sm_table *table);

/* Copies what it needs to `memory`, of so many doubles, zeros; the output does not move then. */
size_t sm_contact_output_size(const sm_motion *motion, const sm_contact *contact,
                              const sm_table *table);
void sm_contact_output_place(sm_contact_output *out, const sm_motion *motion,
                             const sm_contact *contact, const sm_table *table, double *memory);

/* Seconds for which the contacts remember. */
double sm_contact_output_memory(const sm_contact_output *out, const sm_inputs *inputs);
/* A march begins at the state, */
void sm_contact_output_begin(sm_contact_output *out);
/* goes on over a stretch but for its first `from` seconds, */
sm_status sm_contact_output_march(sm_contact_output *out, const sm_slow_flow *flow,
                                  sm_instant *instant, const sm_slow_stretch *stretch,
                                  double from);
/* and its end becomes the state. */
void sm_contact_output_keep(sm_contact_output *out);

/* x_c, v_c, f_c and elastic displacements: of the state, */
void sm_contact_output_read(const sm_contact_output *out, const sm_slow_flow *flow,
                            sm_instant *instant, const sm_inputs *inputs, const double *y,
                            double *values);
/* or marched to the present from rest, the amplitudes moving at `rate`. */
sm_status sm_contact_output_recent(sm_contact_output *out, const sm_slow_flow *flow,
                                   sm_instant *instant, const sm_inputs *inputs, const double *y,
                                   const double *rate, double *values);

#endif

/* A component over a small model, and what it was made of. */
#ifndef TEST_COMPONENT_H
#define TEST_COMPONENT_H

#include "fixtures.h"

#define ELASTIC 3
#define ORDERS 3 /* harmonics that the modes respond to */
#define COUNT_A 4
#define COUNT_B 5

typedef struct {
    table t;
    problem p;
    sm_slow_flow flow;
    sm_motion motion;
    double *modes_out, *forces_out, *contacts_out, *reaction, *response, tolerance;
    int32_t orders[2 * ORDERS];
    sm_component *component;
    size_t outputs, state; /* numbers of them */
} model;

/* `m` must stay where it is, until free_model. */
void new_model(model *m, int modes, int contacts, int wanted);
void free_model(model *m);
sm_status create_again(void *m); /* with what the model holds now */

#endif

/* A component over a small model, and what it was made of. */
#ifndef TEST_COMPONENT_H
#define TEST_COMPONENT_H

#include "fixtures.h"

#define ELASTIC 3
#define ORDERS 3 /* harmonics that the modes respond to */

typedef struct {
    table t;
    problem p;
    sm_slow_flow flow;
    sm_motion motion;
    double *modes_out, *forces_out, *contacts_out, *reaction, *response, tolerance;
    int32_t *orders;
    size_t reactions, responses; /* numbers of them */
    sm_component *component;
    size_t outputs, state; /* numbers of them */
} model;

model new_model(int modes, int contacts, int wanted);
void free_model(model *m);
/* sm_component_create with what the model holds; frees what it creates. */
sm_status create_once(void *m);

#endif

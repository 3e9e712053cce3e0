/* An instance in a random sequence of calls, and how calls on it are judged. */
#ifndef TEST_SEQUENCE_H
#define TEST_SEQUENCE_H

#include "driver.h"

enum { INSTANTIATED = 1, INITIALIZATION = 2, EVENTS = 4, CONTINUOUS = 8, STEPPING = 16, ENDED = 32,
       STEP_EVENTS = 64 };
#define RUNNING (EVENTS | CONTINUOUS | STEPPING | STEP_EVENTS)
#define TUNABLE (EVENTS | STEPPING | STEP_EVENTS)
#define EXCHANGE (EVENTS | CONTINUOUS)

typedef struct {
    void *c;
    int interface;
    int events; /* Co-Simulation with event mode and early returns */
    unsigned state;
    double time;
} instance;

extern const fmu_model *model; /* of this sequence */

/* Judges the status of a call: `legal` calls succeed, or for `discard` may be discarded; others
 * are refused. */
void judge(status got, int legal, int discard, long messages_before, const char *what);
static inline int in(const instance *i, unsigned states) { return (i->state & states) != 0; }

double hostile_number(void);
/* A value that is allowed for the variable, and mostly sensible. */
double good_value(const fmu_variable *v);

/* Random calls about variables: sequence_variables.c; */
void set_reals(instance *i);
void get_reals(instance *i);
void get_floats(instance *i);
void directional(instance *i);
void output_derivatives(instance *i);
void other_types(instance *i);
/* of Model Exchange and about events: sequence_exchange.c; */
void exchange(instance *i);
/* and about saved states: sequence_states.c. */
void save(instance *i);
void restore(instance *i);
void serialize(instance *i);
void free_saved(void *c); /* the states saved so far, by any instance */
/* The state of an instance as bytes from malloc. */
unsigned char *bytes_of(instance *i, size_t *size);

#endif

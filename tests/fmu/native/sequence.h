/* Random numbers, the calls under test, an instance in a sequence of calls, and judgement. */
#ifndef TEST_SEQUENCE_H
#define TEST_SEQUENCE_H

#include "calls.h"
#include "resources/model.h"

extern const calls *fmi; /* of this sequence: FMI 2.0 or 3.0 */
extern message_log messages;

uint32_t random_bits(void);
int below(int count);
double uniform(void); /* in [0, 1) */

void fail(const char *file, int line, const char *what, const char *condition);
#define CHECK(condition, what) \
    do { \
        if (!(condition)) fail(__FILE__, __LINE__, (what), #condition); \
    } while (0)

/* Some 25 calls on several instances of the model that FOLDER holds. */
void run_sequence(const fmu_model *of, const char *folder, const char *token);
/* One file flipped in a bit, cut short, longer, or missing: no instance, and the file is named. */
void run_damage(const char *folder, const char *token);

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
void call_directional(instance *i);
void call_output_derivatives(instance *i);
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

/* The calls of FMI 2.0 and 3.0 behind one set of names, so that a test runs through both. */
#ifndef TEST_CALLS_H
#define TEST_CALLS_H

#include <stddef.h>
#include <stdint.h>

typedef enum { OK, WARNING, DISCARD, ERROR } status;

/* Messages that the FMUs logged so far; the last of them. */
typedef struct {
    long count;
    status last_status;
    char last[600];
} message_log;

typedef struct {
    const char *version;
    int has_event_mode; /* in Co-Simulation */
    /* `interface`: 0 Model Exchange, 1 Co-Simulation, 2 with event mode and early returns */
    void *(*instantiate)(int interface, const char *name, const char *token, const char *folder,
                         message_log *log);
    void (*free_instance)(void *c);
    status (*set_logging)(void *c, int on, size_t count, const char *const *categories);
    status (*enter_initialization)(void *c, double tolerance, double start, double stop);
    status (*exit_initialization)(void *c);
    status (*terminate)(void *c);
    status (*reset)(void *c);
    status (*get_real)(void *c, const uint32_t *vr, size_t count, double *value);
    status (*set_real)(void *c, const uint32_t *vr, size_t count, const double *value);
    status (*get_enumeration)(void *c, const uint32_t *vr, size_t count, int32_t *value);
    status (*get_boolean)(void *c, const uint32_t *vr, size_t count, int *value);
    status (*set_boolean)(void *c, const uint32_t *vr, size_t count, const int *value);
    status (*get_state)(void *c, void **state);
    status (*set_state)(void *c, void *state);
    status (*free_state)(void *c, void **state);
    status (*serialized_size)(void *c, void *state, size_t *size);
    status (*serialize)(void *c, void *state, void *bytes, size_t size);
    status (*deserialize)(void *c, const void *bytes, size_t size, void **state);
    status (*step)(void *c, double time, double step, double *reached);
    status (*enter_steps)(void *c);
    status (*enter_events)(void *c);
    status (*update_discrete)(void *c, int *states_changed);
    status (*enter_continuous)(void *c);
    status (*completed_step)(void *c, int arguments);
    status (*set_time)(void *c, double time);
    status (*set_states)(void *c, const double *states, size_t count);
    status (*get_states)(void *c, double *states, size_t count);
    status (*get_derivatives)(void *c, double *derivatives, size_t count);
    status (*get_nominals)(void *c, double *nominals, size_t count);
    status (*get_indicators)(void *c, size_t count);
    status (*directional)(void *c, const uint32_t *unknown, size_t unknowns,
                          const uint32_t *known, size_t knowns, const double *seed,
                          double *sensitivity);
    /* or NULL */
    status (*adjoint)(void *c, const uint32_t *unknown, size_t unknowns, const uint32_t *known,
                      size_t knowns, const double *seed, double *sensitivity);
    status (*output_derivatives)(void *c, const uint32_t *vr, size_t count, const int32_t *order,
                                 double *value);
} calls;

extern const calls fmi2_calls, fmi3_calls;

#endif

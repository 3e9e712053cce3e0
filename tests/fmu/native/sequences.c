/* Random sequences of legal and illegal calls on several instances.
 *
 * It is known here which state an instance is in and which calls are allowed there, so that every
 * status can be judged. Whatever is not OK must have been logged, and a call that was refused must
 * leave no trace in the state.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"

#define INSTANCES 3
#define SAVED 3
#define CALLS 25 /* of a sequence */

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

typedef struct {
    void *state;
    int interface;
    unsigned machine;
    double time;
} saved_state;

static const fmu_model *model;
static instance instances[INSTANCES];
static saved_state saved[SAVED];

static double hostile_number(void) {
    const double numbers[] = {0.0, -0.0, -1.0, NAN, INFINITY, -INFINITY, 1e308, -1e308, 5e-324};
    return numbers[below((int)(sizeof numbers / sizeof *numbers))];
}

/* The state of an instance as bytes from malloc. */
static unsigned char *bytes_of(instance *i, size_t *size) {
    void *state = NULL;
    CHECK(fmi->get_state(i->c, &state) == OK, "state");
    CHECK(fmi->serialized_size(i->c, state, size) == OK, "state");
    unsigned char *bytes = malloc(*size);
    CHECK(bytes && fmi->serialize(i->c, state, bytes, *size) == OK, "state");
    CHECK(fmi->free_state(i->c, &state) == OK && !state, "state");
    return bytes;
}

/* Judges the status of a call: `legal` calls succeed, or for `discard` may be discarded; others
 * are refused. */
static void judge(status got, int legal, int discard, long messages_before, const char *what) {
    if (legal)
        CHECK(got == OK || (discard && got == DISCARD), what);
    else
        CHECK(got == ERROR, what);
    if (got == OK) return;
    CHECK(messages.count > messages_before && messages.last[0], what);
    CHECK(messages.last_status == got, what);
}

static int in(const instance *i, unsigned states) { return (i->state & states) != 0; }

static void create(instance *i, const char *folder, const char *token) {
    const long before = messages.count;
    i->interface = below(2);
    const int wrong = below(6);
    if (wrong < 4) {
        const char *name = wrong == 0 ? NULL : wrong == 1 ? "" : "name";
        const char *given = wrong == 2 ? NULL : wrong == 3 ? "wrong" : token;
        CHECK(!fmi->instantiate(i->interface, name, given, folder, &messages), "instantiate");
        CHECK(messages.count == before + 1 && messages.last_status == ERROR, "instantiate");
        CHECK(!fmi->instantiate(i->interface, "name", token, below(2) ? NULL : "/no/such/folder",
                                &messages),
              "instantiate");
    }
    i->events = i->interface && fmi->has_event_mode && below(2);
    i->c = fmi->instantiate(i->events ? 2 : i->interface, "name", token, folder, &messages);
    CHECK(i->c, "instantiate");
    i->state = INSTANTIATED;
    i->time = 0.0;
}

static void enter(instance *i) {
    const long before = messages.count;
    const double start = below(8) ? 10.0 * uniform() : hostile_number();
    const double stop = below(4) ? INFINITY : start + 1000.0;
    const double tolerance = below(2) ? 0.0 : below(4) ? 1e-5 : hostile_number();
    const int legal = in(i, INSTANTIATED) && isfinite(start) && !isnan(stop) &&
                      (isinf(stop) || stop >= start) &&
                      (tolerance == 0.0 || (isfinite(tolerance) && tolerance > 0.0));
    const status got = fmi->enter_initialization(i->c, tolerance, start, stop);
    if (got == WARNING) { /* a tolerance that is brought into range */
        CHECK(legal && messages.count > before, "enter");
    } else {
        judge(got, legal, 0, before, "enter");
    }
    if (!legal) return;
    i->state = INITIALIZATION;
    i->time = start;
}

static void leave(instance *i) {
    const long before = messages.count;
    const status got = fmi->exit_initialization(i->c);
    judge(got, in(i, INITIALIZATION), 1, before, "exit initialization");
    if (got == OK) i->state = !i->interface ? EVENTS : i->events ? STEP_EVENTS : STEPPING;
}

static void end(instance *i) {
    const long before = messages.count;
    judge(fmi->terminate(i->c), in(i, RUNNING), 0, before, "terminate");
    if (in(i, RUNNING)) i->state = ENDED;
}

static int is_settable(const instance *i, const fmu_variable *v) {
    if (v->kind == FMU_INPUT) return in(i, INSTANTIATED | INITIALIZATION | RUNNING);
    const int tunable = v->kind == FMU_PARAMETER && v->slot != FMU_CONTACT_WANTED;
    return (v->kind == FMU_PARAMETER || v->kind == FMU_START) &&
           in(i, INSTANTIATED | INITIALIZATION | (tunable ? TUNABLE : 0));
}

#define SLOT(field) ((int32_t)(offsetof(sm_inputs, field) / sizeof(double)))

/* A value that is allowed for the variable, and mostly sensible. */
static double good_value(const fmu_variable *v) {
    if (v->kind == FMU_START) return (uniform() - 0.5) * 0.66 * model->nominal[v->slot - 1];
    if (v->kind == FMU_PARAMETER)
        return v->slot == FMU_TOLERANCE ? (below(2) ? 1e-6 : 1e-4) : 0.001 + 0.01 * uniform();
    if (v->slot == SLOT(limit_scale)) return 0.8 + 0.4 * uniform();
    if (v->slot == SLOT(frequency[0])) return model->flow.natural[0] * (0.9 + 0.2 * uniform());
    if (v->slot == SLOT(frequency[1])) return model->flow.natural[1] * (0.93 + 0.1 * uniform());
    if ((v->slot >= SLOT(frequency) && v->slot < SLOT(phase)) || v->slot == SLOT(limit_scale_rate))
        return 1e-4 * (uniform() - 0.5);
    return 0.2 * (uniform() - 0.5);
}

static void set_reals(instance *i) {
    uint32_t vr[4];
    double value[4];
    const size_t count = (size_t)below(5);
    const long before = messages.count;
    int legal = in(i, INSTANTIATED | INITIALIZATION | RUNNING);
    for (size_t k = 0; k < count; k++) {
        vr[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        const int known = vr[k] < (uint32_t)model->variables;
        const fmu_variable *v = known ? &model->variable[vr[k]] : NULL;
        value[k] = v ? good_value(v) : 0.0;
        if (!v || v->type != FMU_REAL || !is_settable(i, v)) legal = 0;
        if (below(10) == 0) {
            value[k] = NAN;
            legal = 0;
        }
    }
    if (count > 0 && below(20) == 0) {
        judge(fmi->set_real(i->c, below(2) ? NULL : vr, count, NULL), 0, 0, before, "set NULL");
        return;
    }
    judge(fmi->set_real(i->c, vr, count, value), legal, 0, before, "set real");
}

static void get_reals(instance *i) {
    uint32_t vr[4];
    double value[4] = {0.0};
    const size_t count = (size_t)below(5);
    const long before = messages.count;
    int legal = !in(i, INSTANTIATED);
    for (size_t k = 0; k < count; k++) {
        vr[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        const int known = vr[k] < (uint32_t)model->variables;
        if (!known || model->variable[vr[k]].type != FMU_REAL) legal = 0;
    }
    if (count > 0 && below(20) == 0) {
        judge(fmi->get_real(i->c, vr, count, NULL), 0, 0, before, "get NULL");
        return;
    }
    const status got = fmi->get_real(i->c, vr, count, value);
    judge(got, legal, 1, before, "get real");
    for (size_t k = 0; got == OK && k < count; k++) CHECK(isfinite(value[k]), "get real");
}

/* Arrays and reals in one call; as many values as they have, or not. */
static void get_floats(instance *i) {
    uint32_t vr[4];
    const size_t count = (size_t)below(5), size = (size_t)model->contact.contacts;
    size_t values = 0;
    int legal = !in(i, INSTANTIATED);
    for (size_t k = 0; k < count; k++) {
        vr[k] = (uint32_t)(model->variables - 1 - below(8));
        const int array = model->variable[vr[k]].type == FMU_ARRAY;
        if (!array && model->variable[vr[k]].type != FMU_REAL) legal = 0;
        values += array ? size : 1;
    }
    const size_t given = below(4) ? values : (size_t)below(6);
    double value[64] = {0.0};
    const long before = messages.count;
    const status got = fmi->get_floats(i->c, vr, count, value, given);
    judge(got, legal && given == values, 1, before, "get floats");
    for (size_t k = 0; got == OK && k < given; k++) CHECK(isfinite(value[k]), "get floats");
}

/* Any unknowns by any knowns. Where there is none, as of a modulus at zero, is not known here. */
static void directional(instance *i) {
    uint32_t unknown[3], known[3];
    double seed[3], sensitivity[3] = {0.0};
    const long before = messages.count;
    const size_t unknowns = (size_t)below(4), knowns = (size_t)below(4);
    for (int k = 0; k < 3; k++) {
        unknown[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        known[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        seed[k] = below(20) ? uniform() : hostile_number();
    }
    const int adjoint = fmi->adjoint && below(3) == 0;
    const status got = (adjoint ? fmi->adjoint : fmi->directional)(
        i->c, below(12) ? unknown : NULL, unknowns, below(12) ? known : NULL, knowns, seed,
        sensitivity);
    CHECK(got == OK || messages.count > before, "directional derivative");
    CHECK(got != OK || !in(i, INSTANTIATED), "directional derivative");
}

/* Of any variables by time. */
static void output_derivatives(instance *i) {
    uint32_t vr[3];
    int32_t order[3];
    double value[3] = {0.0};
    const long before = messages.count;
    const size_t count = (size_t)below(4);
    for (int k = 0; k < 3; k++) {
        vr[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        order[k] = below(8) ? 1 : below(3);
    }
    const status got = fmi->output_derivatives(i->c, below(12) ? vr : NULL, count, order,
                                               below(12) ? value : NULL);
    CHECK(got == OK || messages.count > before, "output derivatives");
    CHECK(got != OK || in(i, STEPPING | STEP_EVENTS), "output derivatives");
    for (size_t k = 0; got == OK && k < count; k++) CHECK(isfinite(value[k]), "output derivatives");
}

/* Enumerations and booleans: the only ones there are, and wrong ones. */
static void other_types(instance *i) {
    const long before = messages.count;
    const uint32_t vr = below(4) ? (uint32_t)below(model->variables) : random_bits();
    const int known = vr < (uint32_t)model->variables;
    const int32_t type = known ? model->variable[vr].type : FMU_REAL;
    int32_t integer = 0;
    int boolean = 0;
    switch (below(3)) {
    case 0:
        judge(fmi->get_enumeration(i->c, &vr, 1, &integer),
              type == FMU_ENUMERATION && !in(i, INSTANTIATED), 1, before, "get enumeration");
        break;
    case 1:
        judge(fmi->get_boolean(i->c, &vr, 1, &boolean),
              type == FMU_BOOLEAN && !in(i, INSTANTIATED), 1, before, "get boolean");
        break;
    default:
        boolean = below(2);
        judge(fmi->set_boolean(i->c, &vr, 1, &boolean),
              type == FMU_BOOLEAN && in(i, INSTANTIATED | INITIALIZATION), 0, before,
              "set boolean");
    }
}

static void step(instance *i) {
    const long before = messages.count;
    const double length = below(6) ? 30.0 * uniform() * uniform() : hostile_number();
    const double from = below(10) ? i->time : below(2) ? i->time - 1.0 : hostile_number();
    const int possible = isfinite(length) && length > 1e-100 && fabs(from - i->time) <= 1e-9;
    if (possible && length > 1e100) return; /* legal, but it would take seconds */
    double reached = 0.0;
    const status got = fmi->step(i->c, from, length, &reached);
    /* past a stop time it is refused */
    const int past = got == ERROR && strstr(messages.last, "past the stop time") != NULL;
    judge(got, in(i, STEPPING) && possible && !past, 1, before, "step");
    if (got == OK) i->time = reached;
}

/* States change only where it says so, and only once. `whole`: no argument is NULL. */
static void update(instance *i, int whole) {
    const size_t nx = 3 * (size_t)model->modes + 1, bytes = nx * sizeof(double);
    const int exchanged = in(i, EVENTS), legal = (exchanged || in(i, STEP_EVENTS)) && whole;
    double before[16], after[16];
    int changed = 0, again = 0;
    if (legal && exchanged) CHECK(fmi->get_states(i->c, before, nx) == OK, "update");
    const long messages_before = messages.count;
    judge(fmi->update_discrete(i->c, whole ? &changed : NULL), legal, 0, messages_before,
          "update");
    if (legal && !exchanged) CHECK(!changed, "update");
    if (!legal || !exchanged) return;
    CHECK(fmi->get_states(i->c, after, nx) == OK, "update");
    CHECK(changed || memcmp(before, after, bytes) == 0, "update");
    CHECK(fmi->update_discrete(i->c, &again) == OK && !again, "update again");
    CHECK(fmi->get_states(i->c, before, nx) == OK, "update again");
    CHECK(memcmp(before, after, bytes) == 0, "update again");
}

/* An event as importers make it: an input is set, then the states follow. */
static void event(instance *i) {
    uint32_t vr = (uint32_t)below(model->variables);
    while (model->variable[vr].kind != FMU_INPUT) vr = (vr + 1) % (uint32_t)model->variables;
    const double value = good_value(&model->variable[vr]);
    CHECK(fmi->enter_events(i->c) == OK, "event");
    i->state = EVENTS;
    CHECK(fmi->set_real(i->c, &vr, 1, &value) == OK, "event");
    update(i, 1);
    CHECK(fmi->enter_continuous(i->c) == OK, "event");
    i->state = CONTINUOUS;
}

static void exchange(instance *i) {
    const size_t nx = 3 * (size_t)model->modes + 1, wrong = nx + (size_t)below(2) * 2 - 1;
    double values[16] = {0.0};
    const long before = messages.count;
    const int arguments = below(8) != 0, right = below(8) != 0;
    const double time = below(8) ? i->time + uniform() : hostile_number();
    const int kind = below(12);
    for (size_t k = 0; k < nx; k++) values[k] = uniform() - 0.5;
    if (kind == 6 && !right) values[below((int)nx)] = NAN;
    switch (kind) {
    case 0:
        judge(fmi->enter_events(i->c), in(i, EXCHANGE) || (in(i, STEPPING) && i->events), 0,
              before, "enter events");
        if (in(i, EXCHANGE)) i->state = EVENTS;
        if (in(i, STEPPING) && i->events) i->state = STEP_EVENTS;
        break;
    case 11:
        if (!fmi->enter_steps) break;
        judge(fmi->enter_steps(i->c), in(i, STEP_EVENTS), 0, before, "enter steps");
        if (in(i, STEP_EVENTS)) i->state = STEPPING;
        break;
    case 1: update(i, arguments); break;
    case 2:
    case 3:
        judge(fmi->enter_continuous(i->c), in(i, EVENTS), 0, before, "enter continuous");
        if (in(i, EVENTS)) i->state = CONTINUOUS;
        break;
    case 4:
        judge(fmi->completed_step(i->c, arguments), in(i, CONTINUOUS) && arguments, 0, before,
              "completed step");
        break;
    case 5: judge(fmi->set_time(i->c, time), in(i, EXCHANGE) && isfinite(time), 0, before, "time"); break;
    case 6:
        judge(fmi->set_states(i->c, values, nx), in(i, CONTINUOUS) && right, 0, before,
              "set states");
        break;
    case 7:
        judge(fmi->get_states(i->c, right ? values : NULL, nx), in(i, EXCHANGE) && right, 0,
              before, "get states");
        break;
    case 8:
        judge(fmi->get_derivatives(i->c, values, right ? nx : wrong), in(i, EXCHANGE) && right, 1,
              before, "derivatives");
        break;
    case 9:
        if (in(i, EXCHANGE)) event(i);
        break;
    default:
        judge(fmi->get_nominals(i->c, values, right ? nx : wrong), in(i, EXCHANGE) && right, 0,
              before, "nominals");
        judge(fmi->get_indicators(i->c, 1), 0, 0, before, "indicators");
    }
}

static void save(instance *i) {
    saved_state *s = &saved[below(SAVED)];
    if (s->state) CHECK(fmi->free_state(i->c, &s->state) == OK, "free state");
    CHECK(fmi->get_state(i->c, &s->state) == OK, "get state");
    s->interface = i->interface;
    s->machine = i->state;
    s->time = i->time;
}

static void restore(instance *i) {
    const saved_state *s = &saved[below(SAVED)];
    const long before = messages.count;
    const int legal = s->state && s->interface == i->interface
                      && (s->machine != STEP_EVENTS || i->events);
    judge(fmi->set_state(i->c, s->state), legal, 0, before, "set state");
    if (!legal) return;
    i->state = s->machine;
    i->time = s->time;
}

/* Through bytes, whole or damaged, into the same instance. */
static void serialize(instance *i) {
    size_t size;
    unsigned char *bytes = bytes_of(i, &size);
    void *state = NULL;
    const long before = messages.count;
    const int damage = below(3);
    if (damage == 1) bytes[below((int)size)] ^= (unsigned char)(1 << below(8));
    const size_t given = damage == 2 ? (size_t)below((int)size) : size;
    judge(fmi->deserialize(i->c, bytes, given, &state), damage == 0, 0, before, "deserialize");
    CHECK((state != NULL) == (damage == 0), "deserialize");
    if (state) {
        CHECK(fmi->set_state(i->c, state) == OK, "set state");
        CHECK(fmi->free_state(i->c, &state) == OK, "free state");
        size_t again;
        unsigned char *same = bytes_of(i, &again);
        CHECK(again == size && memcmp(same, bytes, size) == 0, "set state");
        free(same);
    }
    free(bytes);
}

static void refused(instance *i) {
    const char *const categories[] = {"logStatusError", "no such"};
    const long before = messages.count;
    size_t size;
    double reached;
    switch (below(8)) {
    case 0: judge(fmi->set_logging(i->c, 1, 2, categories), 0, 0, before, "logging"); break;
    case 1: judge(fmi->get_state(i->c, NULL), 0, 0, before, "get state"); break;
    case 2: judge(fmi->set_state(i->c, NULL), 0, 0, before, "set state"); break;
    case 3: judge(fmi->serialized_size(i->c, NULL, &size), 0, 0, before, "size"); break;
    case 4: judge(fmi->deserialize(i->c, NULL, 9, NULL), 0, 0, before, "deserialize"); break;
    case 5: CHECK(fmi->step(NULL, 0.0, 1.0, &reached) == ERROR, "no instance"); break;
    case 6: CHECK(fmi->get_real(NULL, NULL, 0, NULL) == ERROR, "no instance"); break;
    default: CHECK(fmi->absent(i->c, below(fmi->absent_count)) != OK, "absent");
    }
}

static void random_call(instance *i, const char *folder, const char *token) {
    if (!i->c) {
        create(i, folder, token);
        return;
    }
    const int call = below(100);
    size_t size = 0, again;
    /* what is refused leaves no trace: reading may bring outputs up to date, so not after that */
    const int traced = call >= 40 && call < 80 && below(4) == 0;
    const unsigned state = i->state;
    unsigned char *bytes = traced ? bytes_of(i, &size) : NULL;
    const long before = messages.count;
    if (call < 4 && fmi->get_floats) get_floats(i);
    else if (call < 13) get_reals(i);
    else if (call < 16) output_derivatives(i);
    else if (call < 20) directional(i);
    else if (call < 24) other_types(i);
    else if (call < 28) save(i);
    else if (call < 32) restore(i);
    else if (call < 35) serialize(i);
    else if (call < 37) {
        fmi->free_instance(i->c);
        i->c = NULL;
    } else if (call < 40) {
        CHECK(fmi->reset(i->c) == OK, "reset");
        i->state = INSTANTIATED;
        i->time = 0.0;
    } else if (call < 55) set_reals(i);
    else if (call < 72 && i->events && in(i, STEP_EVENTS) && below(2)) exchange(i);
    else if (call < 72 && (i->interface || below(4) == 0)) step(i);
    else if (call < 72) exchange(i);
    else if (call < 76) end(i);
    else if (call < 80) refused(i);
    else if (call < 85) enter(i);
    else if (call < 91) leave(i);
    else exchange(i);
    if (traced && messages.count > before && i->state == state) {
        unsigned char *after = bytes_of(i, &again);
        CHECK(again == size && memcmp(bytes, after, size) == 0, "a refused call left a trace");
        free(after);
    }
    free(bytes);
}

void run_sequence(const fmu_model *of, const char *folder, const char *token) {
    model = of;
    /* most sequences get going at once */
    for (int k = 0; k < INSTANCES; k++) {
        if (below(3) == 0) continue;
        create(&instances[k], folder, token);
        if (below(4)) enter(&instances[k]);
        if (below(4)) leave(&instances[k]);
    }
    for (int k = 0; k < CALLS; k++) random_call(&instances[below(INSTANCES)], folder, token);
    void *any = NULL;
    for (int k = 0; k < INSTANCES; k++)
        if (instances[k].c) any = instances[k].c;
    for (int k = 0; k < SAVED; k++) {
        if (!any) {
            create(&instances[0], folder, token);
            any = instances[0].c;
        }
        CHECK(fmi->free_state(any, &saved[k].state) == OK, "free state");
    }
    for (int k = 0; k < INSTANCES; k++) {
        fmi->free_instance(instances[k].c);
        instances[k].c = NULL;
    }
}

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

#include "sequence.h"

#define INSTANCES 3
#define CALLS 25 /* of a sequence */

const fmu_model *model;
static instance instances[INSTANCES];

void judge(status got, int legal, int discard, long messages_before, const char *what) {
    if (legal)
        CHECK(got == OK || (discard && got == DISCARD), what);
    else
        CHECK(got == ERROR, what);
    if (got == OK) return;
    CHECK(messages.count > messages_before && messages.last[0], what);
    CHECK(messages.last_status == got, what);
}

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

static void refused(instance *i) {
    const char *const categories[] = {"logStatusError", "no such"};
    const long before = messages.count;
    size_t size;
    double reached;
    switch (below(7)) {
    case 0: judge(fmi->set_logging(i->c, 1, 2, categories), 0, 0, before, "logging"); break;
    case 1: judge(fmi->get_state(i->c, NULL), 0, 0, before, "get state"); break;
    case 2: judge(fmi->set_state(i->c, NULL), 0, 0, before, "set state"); break;
    case 3: judge(fmi->serialized_size(i->c, NULL, &size), 0, 0, before, "size"); break;
    case 4: judge(fmi->deserialize(i->c, NULL, 9, NULL), 0, 0, before, "deserialize"); break;
    case 5: CHECK(fmi->step(NULL, 0.0, 1.0, &reached) == ERROR, "no instance"); break;
    default: CHECK(fmi->get_real(NULL, NULL, 0, NULL) == ERROR, "no instance");
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
    if (call < 13) get_reals(i);
    else if (call < 16) call_output_derivatives(i);
    else if (call < 20) call_directional(i);
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
    if (!any) {
        create(&instances[0], folder, token);
        any = instances[0].c;
    }
    free_saved(any);
    for (int k = 0; k < INSTANCES; k++) {
        fmi->free_instance(instances[k].c);
        instances[k].c = NULL;
    }
}

/* Random calls that save states and put them back. */
#include <stdlib.h>
#include <string.h>

#include "sequence.h"

#define SAVED 3

typedef struct {
    void *state;
    int interface;
    unsigned machine;
    double time;
} saved_state;

static saved_state saved[SAVED];

unsigned char *bytes_of(instance *i, size_t *size) {
    void *state = NULL;
    CHECK(fmi->get_state(i->c, &state) == OK, "state");
    CHECK(fmi->serialized_size(i->c, state, size) == OK, "state");
    unsigned char *bytes = malloc(*size);
    CHECK(bytes && fmi->serialize(i->c, state, bytes, *size) == OK, "state");
    CHECK(fmi->free_state(i->c, &state) == OK && !state, "state");
    return bytes;
}

void save(instance *i) {
    saved_state *s = &saved[below(SAVED)];
    if (s->state) CHECK(fmi->free_state(i->c, &s->state) == OK, "free state");
    CHECK(fmi->get_state(i->c, &s->state) == OK, "get state");
    s->interface = i->interface;
    s->machine = i->state;
    s->time = i->time;
}

void restore(instance *i) {
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
void serialize(instance *i) {
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

void free_saved(void *c) {
    for (int k = 0; k < SAVED; k++) CHECK(fmi->free_state(c, &saved[k].state) == OK, "free state");
}

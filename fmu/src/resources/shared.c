/* Models that instances share. */
#include "resources/model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <windows.h>
static SRWLOCK registry_lock = SRWLOCK_INIT;
static void enter(void) { AcquireSRWLockExclusive(&registry_lock); }
static void leave(void) { ReleaseSRWLockExclusive(&registry_lock); }
#else
#include <pthread.h>
static pthread_mutex_t registry_lock = PTHREAD_MUTEX_INITIALIZER;
static void enter(void) { pthread_mutex_lock(&registry_lock); }
static void leave(void) { pthread_mutex_unlock(&registry_lock); }
#endif

typedef struct entry {
    fmu_model model;
    size_t users;
    struct entry *next;
    char folder[];
} entry;

/* All models of this library; only read and written between enter and leave. */
static entry *registry;

/* Loads another model into the registry; NULL: `reason` says why not. */
static entry *load(const char *folder, const char *token, char reason[FMU_REASON]) {
    snprintf(reason, FMU_REASON, "out of memory");
    entry *made = calloc(1, sizeof *made + strlen(folder) + 1);
    if (!made || !fmu_model_load(&made->model, folder, token, reason)) {
        free(made);
        return NULL;
    }
    memcpy(made->folder, folder, strlen(folder) + 1);
    made->next = registry;
    registry = made;
    return made;
}

const fmu_model *fmu_model_acquire(const char *folder, const char *token,
                                   char reason[FMU_REASON]) {
    enter();
    entry *e = registry; /* with these files: another model may have been put into the folder */
    while (e && (strcmp(e->folder, folder) != 0 || !fmu_model_is_of(&e->model, folder, token)))
        e = e->next;
    if (!e) e = load(folder, token, reason);
    if (e) e->users++;
    leave();
    return e ? &e->model : NULL;
}

void fmu_model_release(const fmu_model *model) {
    if (!model) return;
    enter();
    entry **place = &registry;
    while (&(*place)->model != model) place = &(*place)->next;
    entry *e = *place;
    if (--e->users == 0) {
        *place = e->next;
        fmu_model_free(&e->model);
        free(e);
    }
    leave();
}

/* Snapshots of an instance. */
#include "instance/instance.h"
#include "resources/files.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC 0x31554d46u /* "FMU1" */

typedef struct {
    uint32_t magic, model, interface, crc; /* crc, where it is serialised: of all that follows */
    uint64_t count;                        /* doubles after this */
    uint64_t state;                        /* fmu_state */
} header;

struct fmu_snapshot {
    header head;
    double content[]; /* the run, the outputs, the state of the core */
};

enum { RUN = sizeof(fmu_run) / sizeof(double) };
#define CHECKED_FROM offsetof(header, count)

static size_t content_count(const fmu_instance *instance) {
    return RUN + instance->output_count + fmu_core_state_count(instance->core);
}

static size_t bytes_of(size_t count) { return sizeof(header) + count * sizeof(double); }

static uint32_t crc_of(const fmu_snapshot *snapshot) {
    return npy_crc(0, (const char *)snapshot + CHECKED_FROM,
                   bytes_of((size_t)snapshot->head.count) - CHECKED_FROM);
}

fmu_status fmu_snapshot_take(fmu_instance *instance, fmu_snapshot **snapshot) {
    if (!snapshot) return fmu_say(instance, FMU_ERROR, "GetFMUState: the state is NULL");
    const size_t count = content_count(instance);
    fmu_snapshot *taken = *snapshot;
    if (taken && (taken->head.magic != MAGIC || taken->head.count != count))
        return fmu_say(instance, FMU_ERROR,
                       "GetFMUState: the state to replace is not one of this FMU");
    /* so that equal instances give equal states */
    if (fmu_evaluate_inputs(instance) != FMU_OK) return FMU_ERROR;
    if (!taken) taken = calloc(1, bytes_of(count));
    if (!taken) return fmu_say(instance, FMU_ERROR, "GetFMUState: out of memory");
    memcpy(taken->content, &instance->run, sizeof instance->run);
    memcpy(taken->content + RUN, instance->outputs,
           instance->output_count * sizeof *instance->outputs);
    fmu_core_get_state(instance->core, taken->content + RUN + instance->output_count);
    taken->head = (header){.magic = MAGIC,
                           .model = instance->model->checksum,
                           .interface = (uint32_t)instance->interface,
                           .count = count,
                           .state = (uint64_t)instance->state};
    *snapshot = taken;
    return FMU_OK;
}

/* NULL, or why the snapshot cannot be used here. */
static const char *unfit(const fmu_instance *instance, const fmu_snapshot *snapshot) {
    if (!snapshot) return "it is NULL";
    if (snapshot->head.magic != MAGIC) return "it is not a state of this FMU";
    if (snapshot->head.model != instance->model->checksum) return "it is of another model";
    if (snapshot->head.interface != (uint32_t)instance->interface)
        return "it is of the other interface type";
    if (snapshot->head.count != content_count(instance)) return "it has another size";
    if (snapshot->head.state == FMU_STEP_EVENTS && !instance->event_mode)
        return "it is of an instance with an event mode";
    return NULL;
}

fmu_status fmu_snapshot_apply(fmu_instance *instance, const fmu_snapshot *snapshot) {
    const char *reason = unfit(instance, snapshot);
    if (reason) return fmu_say(instance, FMU_ERROR, "SetFMUState: %s", reason);
    fmu_run run;
    memcpy(&run, snapshot->content, sizeof run);
    const double *state = snapshot->content + RUN + instance->output_count;
    FMU_TRY(fmu_evaluate_restore(instance, run.parameters, state, "SetFMUState"));
    instance->state = (fmu_state)snapshot->head.state;
    instance->run = run;
    /* passed before the snapshot was taken; again, a moving force could differ in the last bit */
    instance->inputs_current = run.started && instance->interface == FMU_CO_SIMULATION;
    memcpy(instance->outputs, snapshot->content + RUN,
           instance->output_count * sizeof *instance->outputs);
    return FMU_OK;
}

fmu_status fmu_snapshot_free(fmu_snapshot **snapshot) {
    if (!snapshot) return FMU_OK;
    free(*snapshot);
    *snapshot = NULL;
    return FMU_OK;
}

fmu_status fmu_snapshot_size(const fmu_instance *instance, const fmu_snapshot *snapshot,
                             size_t *size) {
    const char *reason = size ? unfit(instance, snapshot) : "the size is NULL";
    if (reason) return fmu_say(instance, FMU_ERROR, "SerializedFMUStateSize: %s", reason);
    *size = bytes_of((size_t)snapshot->head.count);
    return FMU_OK;
}

fmu_status fmu_snapshot_write(const fmu_instance *instance, const fmu_snapshot *snapshot,
                              void *bytes, size_t size) {
    const char *reason = bytes ? unfit(instance, snapshot) : "the array is NULL";
    if (!reason && size < bytes_of((size_t)snapshot->head.count))
        reason = "the array is too short";
    if (reason) return fmu_say(instance, FMU_ERROR, "SerializeFMUState: %s", reason);
    header head = snapshot->head;
    head.crc = crc_of(snapshot);
    memcpy(bytes, snapshot, bytes_of((size_t)head.count));
    memcpy(bytes, &head, sizeof head);
    return FMU_OK;
}

fmu_status fmu_snapshot_read(const fmu_instance *instance, const void *bytes, size_t size,
                             fmu_snapshot **snapshot) {
    const size_t expected = bytes_of(content_count(instance));
    if (!bytes || !snapshot || size < expected)
        return fmu_say(instance, FMU_ERROR, "DeserializeFMUState: %s",
                       bytes && snapshot ? "the bytes are too few" : "an argument is NULL");
    fmu_snapshot *read = malloc(expected);
    if (!read) return fmu_say(instance, FMU_ERROR, "DeserializeFMUState: out of memory");
    memcpy(read, bytes, expected);
    const char *reason = unfit(instance, read);
    if (!reason && read->head.crc != crc_of(read)) reason = "it is damaged";
    if (reason) {
        free(read);
        return fmu_say(instance, FMU_ERROR, "DeserializeFMUState: %s", reason);
    }
    *snapshot = read;
    return FMU_OK;
}

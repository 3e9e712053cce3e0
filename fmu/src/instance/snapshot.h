/* The state of an instance as one block of bytes, without pointers: to be kept, copied, sent. */
#ifndef FMU_SNAPSHOT_H
#define FMU_SNAPSHOT_H

#include "instance/instance.h"

typedef struct fmu_snapshot fmu_snapshot;

/* Into *snapshot: a new one if it is NULL. */
fmu_status fmu_snapshot_take(fmu_instance *instance, fmu_snapshot **snapshot);
fmu_status fmu_snapshot_apply(fmu_instance *instance, const fmu_snapshot *snapshot);
void fmu_snapshot_free(fmu_snapshot *snapshot);

fmu_status fmu_snapshot_size(const fmu_instance *instance, const fmu_snapshot *snapshot,
                             size_t *size);
fmu_status fmu_snapshot_write(const fmu_instance *instance, const fmu_snapshot *snapshot,
                              void *bytes, size_t size);
/* Into *snapshot, a new one; damaged bytes, and those of another model, are refused. */
fmu_status fmu_snapshot_read(const fmu_instance *instance, const void *bytes, size_t size,
                             fmu_snapshot **snapshot);

#endif

/* Models that instances share: the instances of one resource folder have one. */
#ifndef FMU_SHARED_H
#define FMU_SHARED_H

#include "resources/model.h"

/* The model of the FMU with this token from its resource folder, to be released; NULL: `reason`
 * says why there is none. From any thread. */
const fmu_model *fmu_model_acquire(const char *folder, const char *token,
                                   char reason[FMU_REASON]);
void fmu_model_release(const fmu_model *model);

#endif

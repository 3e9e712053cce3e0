/* What the functions of FMI 3.0 begin with. */
#ifndef FMU_FMI3_H
#define FMU_FMI3_H

#include "fmi3Functions.h"
#include "instance/instance.h"

#define ALLOW(states, name) \
    if (fmu_allow(c, (states), (name)) != FMU_OK) return fmi3Error
#define REFUSE_IF(condition, reason) \
    if (condition) return (fmi3Status)fmu_say(c, FMU_ERROR, "%s", (reason))

#define READABLE ((FMU_ANY & ~FMU_INSTANTIATED) | FMU_INTERMEDIATE)

#endif

/* What the importer is told of calls that did not go well, and of events if it wants them. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "instance/instance.h"

static const char *const CATEGORY[] = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                       "logStatusError"};
#define CATEGORIES (sizeof CATEGORY / sizeof *CATEGORY)

void fmu_log(const fmu_logger *logger, const char *name, fmu_status status,
             const char *message) {
    if (status == FMU_OK && !logger->events) return;
    logger->write(logger, name, status, CATEGORY[status], message);
}

fmu_status fmu_say(const fmu_instance *instance, fmu_status status, const char *format, ...) {
    char message[FMU_MESSAGE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    fmu_log(&instance->logger, instance->name, status, message);
    return status;
}

fmu_status fmu_set_logging(fmu_instance *instance, int on, size_t count,
                           const char *const *categories) {
    if (count > 0 && !categories)
        return fmu_say(instance, FMU_ERROR, "SetDebugLogging: the categories are NULL");
    int events = on && count == 0;
    for (size_t k = 0; k < count; k++) {
        size_t known = 0;
        while (known < CATEGORIES && categories[k] && strcmp(categories[k], CATEGORY[known]) != 0)
            known++;
        if (!categories[k] || known == CATEGORIES)
            return fmu_say(instance, FMU_ERROR, "SetDebugLogging: no log category %s",
                           categories[k] ? categories[k] : "NULL");
        if (known == FMU_OK) events = on;
    }
    instance->logger.events = events;
    return FMU_OK;
}

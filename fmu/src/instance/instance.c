/* Log messages to the importer, allowed states, small helpers. */
#include "instance/instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* By status. */
static const char *const CATEGORY[] = {"logEvents", "logStatusWarning", "logStatusDiscard",
                                       "logStatusError"};

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
        int known = FMU_OK;
        while (known <= FMU_ERROR && categories[k] && strcmp(categories[k], CATEGORY[known]) != 0)
            known++;
        if (!categories[k] || known > FMU_ERROR)
            return fmu_say(instance, FMU_ERROR, "SetDebugLogging: no log category %s",
                           categories[k] ? categories[k] : "NULL");
        if (known == FMU_OK) events = on;
    }
    instance->logger.events = events;
    return FMU_OK;
}

static const char *state_name(fmu_state state) {
    switch (state) {
    case FMU_INSTANTIATED: return "instantiated";
    case FMU_INITIALIZATION: return "in initialization mode";
    case FMU_EVENTS: return "in event mode";
    case FMU_CONTINUOUS: return "in continuous-time mode";
    case FMU_STEPPING: return "in step mode";
    case FMU_STEP_EVENTS: return "in event mode";
    case FMU_INTERMEDIATE: return "in intermediate update mode";
    default: return "terminated";
    }
}

fmu_status fmu_allow(const fmu_instance *instance, unsigned states, const char *call) {
    if (!instance) return FMU_ERROR;
    if (instance->state & states) return FMU_OK;
    return fmu_say(instance, FMU_ERROR, "%s: not allowed while the instance is %s", call,
                   state_name(instance->state));
}

fmu_status fmu_enter(fmu_instance *instance, fmu_state state) {
    instance->state = state;
    return FMU_OK;
}

const char *fmu_name_of(const fmu_instance *instance, int32_t kind, int32_t slot) {
    const fmu_model *model = instance->model;
    for (int32_t k = 0; k < model->variables; k++)
        if (model->variable[k].kind == kind && model->variable[k].slot == slot)
            return model->name[k];
    return "(a variable without a name)";
}

int fmu_is_output(const fmu_variable *variable) {
    return variable->kind != FMU_INPUT && variable->kind != FMU_PARAMETER &&
           variable->kind != FMU_RATE;
}

double fmu_modulus(const double amplitude[2]) {
    return sqrt(amplitude[0] * amplitude[0] + amplitude[1] * amplitude[1]);
}

void fmu_table_range(const fmu_instance *instance, double range[SM_MODES]) {
    const sm_table *table = &instance->flow.table;
    range[0] = table->node_a[table->count_a - 1];
    range[1] = table->modes == SM_MODES ? table->node_b[table->count_b - 1] : 1.0;
}

void fmu_outdate(fmu_instance *instance) {
    instance->outputs_current = instance->rates_current = 0;
    instance->motion_current = FMU_NO_MOTION;
}

size_t fmu_state_count(const fmu_instance *instance) {
    return instance->model->shares_tone ? 0 : 3 * (size_t)instance->model->modes + 1;
}

size_t fmu_state_place(const fmu_instance *instance, size_t k) {
    const size_t modes = (size_t)instance->model->modes;
    if (k < 2 * modes) return FMU_AMPLITUDE + k;
    return k < 3 * modes ? FMU_ANGLE + (k - 2 * modes) : FMU_ENERGY;
}

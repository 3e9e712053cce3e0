/* The controller of friction_control.py as an FMU: d(scale)/dt = (|A| / a* - scale) / tau.
 *
 * An FMI 2.0 FMU for Co-Simulation in one file. What the standard has and a controller has no use
 * for is refused at the end.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

enum { AMPLITUDE, SCALE, RATE, BEST, TIME_CONSTANT, LEAST, MOST, VARIABLES };

typedef struct {
    double value[VARIABLES];
    double time; /* [s] */
    int running;
    fmi2CallbackFunctions call;
    char name[]; /* a copy: the importer's lasts for a call */
} controller;

static const double START[VARIABLES] = {0.0, 1.0, 0.0, 1.0, 10.0, 0.05, 5.0};

static fmi2Status refuse(const controller *c, const char *why) {
    if (c->call.logger)
        c->call.logger(c->call.componentEnvironment, c->name, fmi2Error, "logStatusError", "%s", why);
    return fmi2Error;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                              fmi2String resources, const fmi2CallbackFunctions *call,
                              fmi2Boolean visible, fmi2Boolean logging) {
    (void)guid, (void)resources, (void)visible, (void)logging;
    if (type != fmi2CoSimulation || !name || !call) return NULL;
    controller *c = calloc(1, sizeof *c + strlen(name) + 1);
    if (!c) return NULL;
    c->call = *call;
    strcpy(c->name, name);
    fmi2Reset(c);
    return c;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2Reset(fmi2Component component) {
    controller *c = component;
    for (int k = 0; k < VARIABLES; k++) c->value[k] = START[k];
    c->time = 0.0;
    c->running = 0;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stops, fmi2Real stop) {
    (void)defined, (void)tolerance, (void)stops, (void)stop;
    ((controller *)component)->time = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component) {
    const controller *c = component;
    const double *v = c->value;
    if (!(v[BEST] > 0.0)) return refuse(c, "best_amplitude: must be > 0");
    if (!(v[TIME_CONSTANT] > 0.0)) return refuse(c, "time_constant: must be > 0");
    if (!(v[LEAST] > 0.0 && v[MOST] >= v[LEAST]))
        return refuse(c, "least_scale, most_scale: must be > 0 and in that order");
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component) {
    ((controller *)component)->running = 1;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component component) {
    ((controller *)component)->running = 0;
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t count,
                       const fmi2Real value[]) {
    controller *c = component;
    for (size_t k = 0; k < count; k++) {
        if (vr[k] >= VARIABLES || !isfinite(value[k])) return refuse(c, "no variable or no number");
        if (c->running && vr[k] != AMPLITUDE) return refuse(c, "only amplitude may be set now");
    }
    for (size_t k = 0; k < count; k++) c->value[vr[k]] = value[k];
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t count,
                       fmi2Real value[]) {
    const controller *c = component;
    for (size_t k = 0; k < count; k++) {
        if (vr[k] >= VARIABLES) return refuse(c, "there is no such variable");
        value[k] = c->value[vr[k]];
    }
    return fmi2OK;
}

/* Exact for an amplitude that stays. */
fmi2Status fmi2DoStep(fmi2Component component, fmi2Real time, fmi2Real step, fmi2Boolean no_set) {
    controller *c = component;
    double *v = c->value;
    (void)no_set;
    if (!c->running || !(step > 0.0) || fabs(time - c->time) > 1e-9 * (step + fabs(time)))
        return refuse(c, "a step starts where the last one ended");
    const double wanted = fmin(fmax(v[AMPLITUDE] / v[BEST], v[LEAST]), v[MOST]);
    const double part = -expm1(-step / v[TIME_CONSTANT]);
    v[SCALE] += (wanted - v[SCALE]) * part;
    v[RATE] = (wanted - v[SCALE]) * part / step;
    c->time = time + step;
    return fmi2OK;
}

/* ---- what it does not have ------------------------------------------------------------- */

#define NONE(name, ...) \
    fmi2Status name(__VA_ARGS__) { return fmi2Error; }
#define OF(type) fmi2Component c, const fmi2ValueReference vr[], size_t count, type value[]

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count,
                               const fmi2String categories[]) {
    (void)c, (void)on, (void)count, (void)categories;
    return fmi2OK;
}
NONE(fmi2GetInteger, OF(fmi2Integer))
NONE(fmi2GetBoolean, OF(fmi2Boolean))
NONE(fmi2GetString, OF(fmi2String))
NONE(fmi2SetInteger, OF(const fmi2Integer))
NONE(fmi2SetBoolean, OF(const fmi2Boolean))
NONE(fmi2SetString, OF(const fmi2String))
NONE(fmi2GetFMUstate, fmi2Component c, fmi2FMUstate *state)
NONE(fmi2SetFMUstate, fmi2Component c, fmi2FMUstate state)
NONE(fmi2FreeFMUstate, fmi2Component c, fmi2FMUstate *state)
NONE(fmi2SerializedFMUstateSize, fmi2Component c, fmi2FMUstate state, size_t *size)
NONE(fmi2SerializeFMUstate, fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
NONE(fmi2DeSerializeFMUstate, fmi2Component c, const fmi2Byte bytes[], size_t size,
     fmi2FMUstate *state)
NONE(fmi2GetDirectionalDerivative, fmi2Component c, const fmi2ValueReference unknown[],
     size_t unknowns, const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
     fmi2Real sensitivity[])
NONE(fmi2SetRealInputDerivatives, fmi2Component c, const fmi2ValueReference vr[], size_t count,
     const fmi2Integer order[], const fmi2Real value[])
NONE(fmi2GetRealOutputDerivatives, fmi2Component c, const fmi2ValueReference vr[], size_t count,
     const fmi2Integer order[], fmi2Real value[])
NONE(fmi2CancelStep, fmi2Component c)
NONE(fmi2GetStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
NONE(fmi2GetRealStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
NONE(fmi2GetIntegerStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
NONE(fmi2GetBooleanStatus, fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
NONE(fmi2GetStringStatus, fmi2Component c, const fmi2StatusKind kind, fmi2String *value)

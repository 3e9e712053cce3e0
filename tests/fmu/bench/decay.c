/* x' = -x by Euler steps, as little as FMPy can step: what an importer costs by itself.
 * Variable 0 is an input without effect, every other one is x. */
#include <stdlib.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"

typedef struct {
    double input, x;
} decay;

static decay *begin(void) {
    decay *instance = malloc(sizeof *instance);
    if (instance) *instance = (decay){0.0, 1.0};
    return instance;
}

static void get(const decay *instance, const unsigned *vr, size_t count, double *value) {
    for (size_t k = 0; k < count; k++) value[k] = vr[k] ? instance->x : instance->input;
}

static void set(decay *instance, const unsigned *vr, size_t count, const double *value) {
    for (size_t k = 0; k < count; k++) *(vr[k] ? &instance->x : &instance->input) = value[k];
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String folder,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)name, (void)type, (void)token, (void)folder, (void)functions, (void)visible;
    (void)logging;
    return begin();
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                       fmi2Real value[]) {
    get(c, vr, count, value);
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t count,
                       const fmi2Real value[]) {
    set(c, vr, count, value);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_set_state) {
    (void)time, (void)no_set_state;
    ((decay *)c)->x *= 1.0 - 1e-3 * step;
    return fmi2OK;
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference intermediate[],
    size_t intermediates, fmi3InstanceEnvironment environment, fmi3LogMessageCallback callback,
    fmi3IntermediateUpdateCallback update) {
    (void)name, (void)token, (void)path, (void)visible, (void)logging, (void)event_mode;
    (void)early_return, (void)intermediate, (void)intermediates, (void)environment;
    (void)callback, (void)update;
    return begin();
}

void fmi3FreeInstance(fmi3Instance c) { free(c); }

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                          fmi3Float64 value[], size_t values) {
    (void)values;
    get(c, vr, count, value);
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                          const fmi3Float64 value[], size_t values) {
    (void)values;
    set(c, vr, count, value);
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_set_state,
                      fmi3Boolean *event_handling_needed, fmi3Boolean *terminate,
                      fmi3Boolean *early_return, fmi3Float64 *last_time) {
    (void)no_set_state;
    ((decay *)c)->x *= 1.0 - 1e-3 * step;
    *event_handling_needed = *terminate = *early_return = fmi3False;
    *last_time = time + step;
    return fmi3OK;
}

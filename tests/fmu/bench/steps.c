/* Cost of the FMI calls in a C loop, through the library as an importer loads it.
 *
 *   steps LIBRARY FOLDER TOKEN COUNT STEP INPUT REFERENCES... [REFERENCE=START...]
 *
 * prints nanoseconds per call of fmi3DoStep, of fmi3GetFloat64 of the variables after a step, and of fmi3SetFloat64 of one input, and how long 1000 multiplications
 * and additions take that wait for each other: what to measure by on a busy machine. Each is
 * processor time, the least of many short rounds. Then what the second and further instances of
 * the same resource folder take.
 */
#define _POSIX_C_SOURCE 200809L
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi3FunctionTypes.h"

#ifndef ROUNDS
#define ROUNDS 200
#endif
#define MOST 64
#ifndef INSTANCES
#define INSTANCES 1000
#endif

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static double yardstick(void) {
    volatile double kept = 1.5;
    double x = kept;
    const double started = now();
    for (int k = 0; k < 1000; k++) x = x * 0.75 + 0.5;
    kept = x;
    return now() - started;
}

static void say(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                fmi3String message) {
    (void)environment, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static void *entry(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "%s is missing\n", name);
        exit(1);
    }
    return found;
}

static void check(fmi3Status status) {
    if (status != fmi3OK) exit(1);
}

/* Of this process [MB]. */
static double resident(void) {
    long pages = 0, all = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file && fscanf(file, "%ld %ld", &all, &pages) != 2) pages = 0;
    if (file) fclose(file);
    return (double)pages * 4096e-6;
}

int main(int count, char **argument) {
    fmi3ValueReference vr[MOST];
    double value[MOST], last, time = 0.0;
    fmi3Boolean event, terminate, early;
    if (count < 7) return 2;
    void *library = dlopen(argument[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) return 2;
    fmi3InstantiateCoSimulationTYPE *instantiate;
    fmi3EnterInitializationModeTYPE *enter;
    fmi3ExitInitializationModeTYPE *leave;
    fmi3DoStepTYPE *step;
    fmi3GetFloat64TYPE *get;
    fmi3SetFloat64TYPE *set;
    fmi3FreeInstanceTYPE *release;
    *(void **)&instantiate = entry(library, "fmi3InstantiateCoSimulation");
    *(void **)&enter = entry(library, "fmi3EnterInitializationMode");
    *(void **)&leave = entry(library, "fmi3ExitInitializationMode");
    *(void **)&step = entry(library, "fmi3DoStep");
    *(void **)&get = entry(library, "fmi3GetFloat64");
    *(void **)&set = entry(library, "fmi3SetFloat64");
    *(void **)&release = entry(library, "fmi3FreeInstance");
    const long steps = atol(argument[4]);
    const double duration = atof(argument[5]);
    const fmi3ValueReference input = (fmi3ValueReference)atol(argument[6]);
    size_t names = 0;
    fmi3Instance c = instantiate("bench", argument[3], argument[2], false, false, false, false,
                                 NULL, 0, NULL, say, NULL);
    if (!c) return 1;
    for (int k = 7; k < count && names < MOST; k++) {
        const fmi3ValueReference reference = (fmi3ValueReference)atol(argument[k]);
        const char *equals = strchr(argument[k], '=');
        const double start = equals ? atof(equals + 1) : 0.0;
        if (equals)
            check(set(c, &reference, 1, &start, 1));
        else
            vr[names++] = reference;
    }
    check(enter(c, false, 0.0, 0.0, false, 0.0));
    check(leave(c));
    double best[5] = {1e30, 1e30, 1e30, 1e30, 1e30}, force = 0.0;
    check(get(c, &input, 1, &force, 1));
    for (int round = 0; round < ROUNDS; round++) {
        double started = now();
        for (long k = 0; k < steps; k++, time += duration)
            check(step(c, time, duration, true, &event, &terminate, &early, &last));
        const double stepped = (now() - started) / (double)steps;
        started = now();
        for (long k = 0; k < steps; k++) check(get(c, vr, names, value, names));
        const double got = (now() - started) / (double)steps;
        started = now();
        for (long k = 0; k < steps; k++) check(set(c, &input, 1, &force, 1));
        const double were_set = (now() - started) / (double)steps;
        started = now();
        for (long k = 0; k < steps; k++, time += duration) {
            check(set(c, &input, 1, &force, 1));
            check(step(c, time, duration, true, &event, &terminate, &early, &last));
            check(get(c, vr, names, value, names));
        }
        const double all = (now() - started) / (double)steps;
        const double figures[5] = {stepped, got, were_set, all, yardstick()};
        for (int k = 0; k < 5; k++) best[k] = figures[k] < best[k] ? figures[k] : best[k];
    }
    printf("doStep %.0f ns, get of %lu %.0f ns, set %.0f ns, all three %.0f ns; yardstick %.0f ns, "
           "doStep %.2f of it\n",
           best[0], (unsigned long)names, best[1], best[2], best[3], best[4], best[0] / best[4]);
    static fmi3Instance more[INSTANCES];
    double least = 1e30;
    const double before = resident();
    for (int k = 0; k < INSTANCES; k++) {
        const double started = now();
        more[k] = instantiate("more", argument[3], argument[2], false, false, false, false, NULL,
                              0, NULL, say, NULL);
        if (!more[k]) return 1;
        check(enter(more[k], false, 0.0, 0.0, false, 0.0));
        check(leave(more[k]));
        check(step(more[k], 0.0, duration, true, &event, &terminate, &early, &last));
        const double took = now() - started;
        least = took < least ? took : least;
    }
    printf("%d more instances: %.0f us each, %.0f MB in all\n", INSTANCES, 1e-3 * least,
           resident() - before);
    for (int k = 0; k < INSTANCES; k++) release(more[k]);
    release(c);
    dlclose(library);
    return 0;
}

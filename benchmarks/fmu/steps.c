/* Cost of the FMI calls in a C loop, linked with the library of an FMU.
 *
 *   steps FOLDER TOKEN STEP REFERENCES... [REFERENCE=START...]
 *
 * prints nanoseconds of processor time per fmi3DoStep and per fmi3GetFloat64 of the variables
 * after a step, each the least of many short rounds.
 */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi3Functions.h"

#define ROUNDS 200
#define STEPS 500 /* of a round */
#define MOST 64

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static void say(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                fmi3String message) {
    (void)environment, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static void check(fmi3Status status) {
    if (status != fmi3OK) exit(1);
}

int main(int count, char **argument) {
    fmi3ValueReference vr[MOST];
    double value[MOST], last, time = 0.0, best[2] = {1e30, 1e30};
    fmi3Boolean event, terminate, early;
    size_t names = 0;
    if (count < 4) return 2;
    fmi3Instance c = fmi3InstantiateCoSimulation("bench", argument[2], argument[1], false, false,
                                                 false, false, NULL, 0, NULL, say, NULL);
    if (!c) return 1;
    for (int k = 4; k < count && names < MOST; k++) {
        const fmi3ValueReference reference = (fmi3ValueReference)atol(argument[k]);
        const char *equals = strchr(argument[k], '=');
        const double start = equals ? atof(equals + 1) : 0.0;
        if (equals)
            check(fmi3SetFloat64(c, &reference, 1, &start, 1));
        else
            vr[names++] = reference;
    }
    check(fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0));
    check(fmi3ExitInitializationMode(c));
    const double step = atof(argument[3]);
    for (int round = 0; round < ROUNDS; round++) {
        const double started = now();
        for (int k = 0; k < STEPS; k++, time += step)
            check(fmi3DoStep(c, time, step, true, &event, &terminate, &early, &last));
        const double stepped = (now() - started) / STEPS;
        for (int k = 0; k < STEPS; k++, time += step) {
            check(fmi3DoStep(c, time, step, true, &event, &terminate, &early, &last));
            check(fmi3GetFloat64(c, vr, names, value, names));
        }
        const double both = (now() - started) / STEPS - stepped;
        best[0] = stepped < best[0] ? stepped : best[0];
        best[1] = both < best[1] ? both : best[1];
    }
    printf("doStep %.0f ns, with reading of %lu variables %.0f ns\n", best[0],
           (unsigned long)names, best[1]);
    fmi3FreeInstance(c);
    return 0;
}

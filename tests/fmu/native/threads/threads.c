/* Threads that make, step, read and free instances of the same resource folder: FOLDER TOKEN.
 *
 * To be built with -fsanitize=thread. Every instance ends at the same bits.
 */
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "fmi3Functions.h"

#define THREADS 4
#define ROUNDS 20
#define STEPS 30
#define VALUES 8 /* of the first value references */

static const char *folder, *token;
static double last[THREADS][VALUES];
static int failed[THREADS];

static void say(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                fmi3String message) {
    (void)environment, (void)status, (void)category;
    fprintf(stderr, "%s\n", message);
}

static int run(double *values) {
    fmi3ValueReference reference[VALUES];
    fmi3Boolean event, terminate, early;
    double reached;
    for (int k = 0; k < VALUES; k++) reference[k] = (fmi3ValueReference)k;
    fmi3Instance c = fmi3InstantiateCoSimulation("one of many", token, folder, false, false, false,
                                                 false, NULL, 0, NULL, say, NULL);
    if (!c) return 1;
    int bad = fmi3EnterInitializationMode(c, false, 0.0, 0.0, false, 0.0)
              || fmi3ExitInitializationMode(c);
    for (int k = 0; !bad && k < STEPS; k++)
        bad = fmi3DoStep(c, k, 1.0, true, &event, &terminate, &early, &reached)
              || fmi3GetFloat64(c, reference, VALUES, values, VALUES);
    fmi3FreeInstance(c);
    return bad;
}

static void *work(void *argument) {
    const int thread = *(int *)argument;
    for (int k = 0; k < ROUNDS && !failed[thread]; k++) failed[thread] = run(last[thread]);
    return NULL;
}

int main(int count, char **argument) {
    pthread_t thread[THREADS];
    int number[THREADS];
    if (count != 3) return 2;
    folder = argument[1];
    token = argument[2];
    for (int k = 0; k < THREADS; k++) {
        number[k] = k;
        if (pthread_create(&thread[k], NULL, work, &number[k])) return 2;
    }
    for (int k = 0; k < THREADS; k++) pthread_join(thread[k], NULL);
    for (int k = 0; k < THREADS; k++)
        if (failed[k] || memcmp(last[k], last[0], sizeof last[k]) != 0) return 1;
    puts("equal");
    return 0;
}

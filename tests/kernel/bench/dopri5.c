/* What a step of the slow flow costs beside the look-ups in the friction table that it makes.
 *
 * Prints nanoseconds per accepted step of a component without contact motion, and of six
 * look-ups with slopes at the same amplitudes, each the least of several rounds.
 */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "component.h"
#include "table/table.h"

#define STEPS 20000
#define LOOK_UPS 6 /* of a Dormand-Prince step */
#define ROUNDS 15
#define NODES 30
#define SLOPED 8 /* columns: of two modes and two combination resonances */

static double amplitudes[STEPS][2 * SM_MODES];

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int step_along(sm_component *c, double *nanoseconds) {
    const double rest[2 * SM_MODES] = {0.0};
    const sm_inputs inputs = {
        .force = {0.02, 0.03}, .frequency = {0.98, 1.65}, .limit_scale = 1.0}; /* in the table */
    double outputs[SM_OUTPUTS_FIXED];
    uint64_t before, after;
    if (sm_component_reset(c, 0.0, rest) != SM_OK) return 0;
    if (sm_component_set_inputs(c, &inputs) != SM_OK) return 0;
    sm_component_work(c, &before, NULL);
    const double started = now();
    for (int k = 0; k < STEPS; k++)
        if (sm_component_step(c, 1.0) != SM_OK) return 0;
    const double seconds = now() - started;
    sm_component_work(c, &after, NULL);
    *nanoseconds = fmin(*nanoseconds, seconds / (double)(after - before));
    if (sm_component_reset(c, 0.0, rest) != SM_OK) return 0;
    for (int k = 0; k < STEPS; k++) {
        if (sm_component_step(c, 1.0) != SM_OK) return 0;
        if (sm_component_outputs(c, outputs) != SM_OK) return 0;
        memcpy(amplitudes[k], outputs + 1, sizeof amplitudes[k]);
    }
    return 1;
}

static int look_up_along(const sm_table *table, double *nanoseconds, double *sum) {
    double slopes[2 * (SM_MODES + SM_COMBINATIONS + 1) * 3], rate_correction[SM_RATE_CORRECTIONS];
    int32_t cell[SM_MODES] = {0, 0};
    const double started = now();
    for (int k = 0; k < STEPS; k++)
        for (int stage = 0; stage < LOOK_UPS; stage++) {
            const double *a = amplitudes[k];
            const double modulus[SM_MODES] = {sqrt(a[0] * a[0] + a[1] * a[1]) * (1 + 1e-9 * stage),
                                              sqrt(a[2] * a[2] + a[3] * a[3])};
            if (sm_table_slopes_from(table, modulus, SLOPED, cell, slopes, rate_correction)
                != SM_OK)
                return 0;
            *sum += slopes[0];
        }
    *nanoseconds = fmin(*nanoseconds, (now() - started) / STEPS);
    return 1;
}

int main(void) {
    table t = new_rich_table(NODES, NODES, 2);
    problem p = new_problem(2, 2, SM_TANH);
    sm_slow_flow flow = flow_over(&t);
    flow.combination[0] = (sm_combination){1, 5, -2};
    flow.combination[1] = (sm_combination){0, -4, 3};
    const sm_motion none = {.wanted = 0};
    sm_component *c = NULL;
    double stepped = INFINITY, looked = INFINITY, sum = 0.0;
    if (sm_component_create(&flow, &p.contact, &none, 1e-6, &c) != SM_OK) return 1;
    for (int round = 0; round < ROUNDS; round++)
        if (!step_along(c, &stepped) || !look_up_along(&t.table, &looked, &sum)) return 1;
    printf("accepted step %.0f ns, its look-ups alone %.0f ns: %.1f times (sum %.3g)\n", stepped,
           looked, stepped / looked, sum);
    sm_component_free(c);
    free_problem(&p);
    free_table(&t);
    return 0;
}

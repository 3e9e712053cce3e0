/* Runs one group of checks of the core, or lists them: driver [group [times]].
 *
 * Random calls are made, and the long run is, that many times as often.
 */
#include "driver.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fixtures.h"

static void fail(place where) {
    fprintf(stderr, "%s:%d: %s\n", where.file, where.line, where.text);
    _Exit(EXIT_FAILURE); /* no leak check on top: what is held is still to be freed */
}

void check_true(int condition, place where) {
    if (!condition) fail(where);
}

void check_status(sm_status status, sm_status expected, place where) {
    if (status == expected) return;
    fprintf(stderr, "got \"%s\", not \"%s\"\n", sm_message(status), sm_message(expected));
    fail(where);
}

void check_near(double value, double expected, double tolerance, place where) {
    if (fabs(value - expected) <= tolerance) return;
    fprintf(stderr, "got %.17g, not %.17g to %g\n", value, expected, tolerance);
    fail(where);
}

void check_finite(const double *values, size_t count, place where) {
    for (size_t k = 0; k < count; k++)
        if (!isfinite(values[k])) {
            fprintf(stderr, "entry %lu is %g\n", (unsigned long)k, values[k]);
            fail(where);
        }
}

void check_refuses(void *at, const void *wrong, size_t size, size_t count, entry call,
                   void *arguments, place where) {
    unsigned char right[sizeof(double) + sizeof(void *)];
    memcpy(right, at, size);
    for (size_t k = 0; k < count; k++) {
        memcpy(at, (const unsigned char *)wrong + k * size, size);
        const sm_status status = call(arguments);
        if (status != SM_BAD_ARGUMENT) fprintf(stderr, "wrong value %lu: ", (unsigned long)k);
        check_status(status, SM_BAD_ARGUMENT, where);
    }
    memcpy(at, right, size);
}

void check_refuses_null(void **pointers, size_t count, entry call, void *arguments, place where) {
    static const void *const none = NULL;
    for (size_t k = 0; k < count; k++)
        check_refuses(pointers[k], &none, sizeof none, 1, call, arguments, where);
}

void check_refuses_not_finite(const array *arrays, size_t count, entry call, void *arguments,
                              place where) {
    const double wrong[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < 3 * arrays[i].count; k++) {
            double *at = arrays[i].values + k / 3;
            const double right = *at;
            *at = wrong[k % 3];
            const sm_status status = call(arguments);
            if (status != SM_NOT_FINITE)
                fprintf(stderr, "%g in entry %d of array %d: ", *at, (int)k / 3, (int)i);
            check_status(status, SM_NOT_FINITE, where);
            *at = right;
        }
}

void check_no_memory(entry call, void *arguments) {
    sm_status status = SM_NO_MEMORY;
    for (int allowed = 0; status == SM_NO_MEMORY; allowed++) {
        allocations_left = allowed;
        status = call(arguments);
        CHECK(allowed > 0 || status == SM_NO_MEMORY);
    }
    allocations_left = -1;
    CHECK_STATUS(status, SM_OK);
}

#define GROUPS(GROUP)                                                                       \
    GROUP(friction) GROUP(frictional) GROUP(elastic) GROUP(curves) GROUP(long_run)          \
    GROUP(same_bits) GROUP(refusals) GROUP(random_calls)
#define DECLARE(name) void check_##name(int times);
#define ENTRY(name) {#name, check_##name},

GROUPS(DECLARE)

static const struct {
    const char *name;
    void (*run)(int times);
} ALL[] = {GROUPS(ENTRY)};

int main(int argc, char **argv) {
    const int times = argc > 2 ? atoi(argv[2]) : 1;
    for (size_t g = 0; g < sizeof ALL / sizeof *ALL; g++) {
        if (argc < 2) puts(ALL[g].name);
        if (argc > 1 && strcmp(argv[1], ALL[g].name) == 0) {
            ALL[g].run(times);
            free_doubles();
            return EXIT_SUCCESS;
        }
    }
    return argc < 2 ? EXIT_SUCCESS : EXIT_FAILURE;
}

#include "driver.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void fail(const char *text, const char *file, int line) {
    fprintf(stderr, "%s:%d: %s\n", file, line, text);
    _Exit(EXIT_FAILURE); /* no leak check on top: what is held is still to be freed */
}

void check_true(int condition, const char *text, const char *file, int line) {
    if (!condition) fail(text, file, line);
}

void check_status(sm_status status, sm_status expected, const char *text, const char *file,
                  int line) {
    if (status == expected) return;
    fprintf(stderr, "got \"%s\", not \"%s\"\n", sm_message(status), sm_message(expected));
    fail(text, file, line);
}

void check_near(double value, double expected, double tolerance, const char *text,
                const char *file, int line) {
    if (fabs(value - expected) <= tolerance) return;
    fprintf(stderr, "got %.17g, not %.17g to %g\n", value, expected, tolerance);
    fail(text, file, line);
}

void check_finite(const double *values, size_t count, const char *text, const char *file,
                  int line) {
    for (size_t k = 0; k < count; k++)
        if (!isfinite(values[k])) {
            fprintf(stderr, "entry %lu of %lu is %g\n", (unsigned long)k, (unsigned long)count,
                    values[k]);
            fail(text, file, line);
        }
}

void check_refuses_not_finite(double *values, size_t count, entry call, void *arguments,
                              const char *text, const char *file, int line) {
    const double wrong[] = {NAN, INFINITY, -INFINITY};
    for (size_t k = 0; k < count; k++) {
        const double right = values[k];
        for (size_t w = 0; w < sizeof wrong / sizeof *wrong; w++) {
            values[k] = wrong[w];
            const sm_status status = call(arguments);
            if (status == SM_NOT_FINITE) continue;
            fprintf(stderr, "%g in entry %lu: ", wrong[w], (unsigned long)k);
            check_status(status, SM_NOT_FINITE, text, file, line);
        }
        values[k] = right;
    }
}

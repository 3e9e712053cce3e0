/* Checks of the driver: the first that fails is named and ends the run. */
#ifndef TEST_DRIVER_H
#define TEST_DRIVER_H

#include "slipmode.h"

#define CHECK(condition) check_true((condition), #condition, __FILE__, __LINE__)
#define CHECK_STATUS(call, expected) check_status((call), (expected), #call, __FILE__, __LINE__)
/* |value - expected| <= tolerance, which a NaN does not pass */
#define CHECK_NEAR(value, expected, tolerance) \
    check_near((value), (expected), (tolerance), #value, __FILE__, __LINE__)
#define CHECK_FINITE(values, count) check_finite((values), (count), #values, __FILE__, __LINE__)

/* `call` with one argument wrong is refused; the argument is then put right again. */
#define CHECK_REFUSES(type, argument, wrong, call, expected) \
    do {                                                     \
        type right = (argument);                             \
        (argument) = (wrong);                                \
        CHECK_STATUS(call, expected);                        \
        (argument) = right;                                  \
    } while (0)

void check_true(int condition, const char *text, const char *file, int line);
void check_status(sm_status status, sm_status expected, const char *text, const char *file,
                  int line);
void check_near(double value, double expected, double tolerance, const char *text,
                const char *file, int line);
void check_finite(const double *values, size_t count, const char *text, const char *file,
                  int line);

typedef sm_status (*entry)(void *arguments);

/* SM_NOT_FINITE with a NaN, and with either infinity, in each of `values`. */
#define CHECK_REFUSES_NOT_FINITE(values, count, call, arguments) \
    check_refuses_not_finite((values), (count), (call), (arguments), #values, __FILE__, __LINE__)
void check_refuses_not_finite(double *values, size_t count, entry call, void *arguments,
                              const char *text, const char *file, int line);

#endif

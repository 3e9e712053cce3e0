/* Checks of the driver: the first that fails is named and ends the run. */
#ifndef TEST_DRIVER_H
#define TEST_DRIVER_H

#include "slipmode.h"

typedef sm_status (*entry)(void *arguments);
typedef struct {
    const char *text, *file;
    int line;
} place;

#define HERE(text) ((place){text, __FILE__, __LINE__})
#define CHECK(condition) check_true((condition), HERE(#condition))
#define CHECK_STATUS(call, expected) check_status((call), (expected), HERE(#call))
/* |value - expected| <= tolerance, which a NaN does not pass */
#define CHECK_NEAR(value, expected, tolerance) \
    check_near((value), (expected), (tolerance), HERE(#value))
#define CHECK_FINITE(values, count) check_finite((values), (count), HERE(#values))

/* `call` is refused with SM_BAD_ARGUMENT while each of the pointers is NULL, or *at is each of the
 * numbers in turn. */
#define REFUSES_NULL(call, arguments, ...)                                               \
    check_refuses_null((void *[]){__VA_ARGS__}, sizeof((void *[]){__VA_ARGS__}) / sizeof(void *), \
                       (call), (arguments), HERE(#__VA_ARGS__))
#define REFUSES_INTS(at, call, arguments, ...)                                           \
    check_refuses((at), (const int32_t[]){__VA_ARGS__}, sizeof(int32_t),                 \
                  sizeof((const int32_t[]){__VA_ARGS__}) / sizeof(int32_t), (call), (arguments), \
                  HERE(#at))
#define REFUSES(at, call, arguments, ...)                                                \
    check_refuses((at), (const double[]){__VA_ARGS__}, sizeof(double),                   \
                  sizeof((const double[]){__VA_ARGS__}) / sizeof(double), (call), (arguments), \
                  HERE(#at))
/* SM_NOT_FINITE with a NaN, and with either infinity, in each number of arrays {values, count}. */
typedef struct {
    double *values;
    size_t count;
} array;
#define REFUSES_NOT_FINITE(call, arguments, ...)                                          \
    check_refuses_not_finite((const array[]){__VA_ARGS__},                                \
                             sizeof((const array[]){__VA_ARGS__}) / sizeof(array), (call), \
                             (arguments), HERE(#__VA_ARGS__))
/* `call` has this status while a number is wrong. */
#define CHECK_WITH(at, wrong, call, expected)    \
    do {                                         \
        const double right_value = *(at);        \
        *(at) = (wrong);                         \
        CHECK_STATUS(call, expected);            \
        *(at) = right_value;                     \
    } while (0)

void check_true(int condition, place where);
void check_status(sm_status status, sm_status expected, place where);
void check_near(double value, double expected, double tolerance, place where);
void check_finite(const double *values, size_t count, place where);
void check_refuses(void *at, const void *wrong, size_t size, size_t count, entry call,
                   void *arguments, place where);
void check_refuses_null(void **pointers, size_t count, entry call, void *arguments, place where);
void check_refuses_not_finite(const array *arrays, size_t count, entry call, void *arguments,
                              place where);
/* SM_NO_MEMORY whichever allocation fails, and none of the others leaks. */
void check_no_memory(entry call, void *arguments);

#endif

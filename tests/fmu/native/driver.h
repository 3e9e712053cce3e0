/* What the tests in C share: random numbers, the calls under test, judgement. */
#ifndef TEST_DRIVER_H
#define TEST_DRIVER_H

#include "calls.h"
#include "resources/model.h"

extern const calls *fmi; /* of this sequence: FMI 2.0 or 3.0 */
extern message_log messages;

uint32_t random_bits(void);
int below(int count);
double uniform(void); /* in [0, 1) */

void fail(const char *file, int line, const char *what, const char *condition);
#define CHECK(condition, what) \
    do { \
        if (!(condition)) fail(__FILE__, __LINE__, (what), #condition); \
    } while (0)

/* Some 25 calls on several instances of the model that FOLDER holds. */
void run_sequence(const fmu_model *of, const char *folder, const char *token);
/* One file flipped in a bit, cut short, longer, or missing: no instance, and the file is named. */
void run_damage(const char *folder, const char *token);

#endif

/* What the core is compiled to call instead of calloc. */
#include <stdlib.h>

extern int allocations_left;
int allocations_left = -1;

void *sm_test_calloc(size_t count, size_t size);
void *sm_test_calloc(size_t count, size_t size) {
    if (allocations_left == 0) return NULL;
    if (allocations_left > 0) allocations_left--;
    return calloc(count, size);
}

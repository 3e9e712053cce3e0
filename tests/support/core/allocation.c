/* What the core is compiled to call instead of calloc and free: memory that runs out on request. */
#include <stdlib.h>

int allocations_left = -1; /* that still succeed; negative: all */
int blocks = 0;            /* allocated, and not freed yet */

void *sm_test_calloc(size_t count, size_t size);
void sm_test_free(void *block);

void *sm_test_calloc(size_t count, size_t size) {
    if (allocations_left == 0) return NULL;
    if (allocations_left > 0) allocations_left--;
    void *block = calloc(count, size);
    blocks += block != NULL;
    return block;
}

void sm_test_free(void *block) {
    blocks -= block != NULL;
    free(block);
}

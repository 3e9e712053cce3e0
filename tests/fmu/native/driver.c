/* An FMU's C code under random calls, through FMI 2.0 and 3.0.
 *
 *   driver FOLDER TOKEN COUNT SEED         random sequences
 *   driver FOLDER TOKEN COUNT SEED damage  damaged resources; FOLDER is written to
 */
#include "sequence.h"

#include <stdio.h>
#include <stdlib.h>

const calls *fmi = &fmi3_calls;
message_log messages;
static uint64_t random_state;
static long sequence;

uint32_t random_bits(void) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return (uint32_t)(random_state >> 16);
}

int below(int count) { return (int)(random_bits() % (uint32_t)count); }

double uniform(void) { return random_bits() / 4294967296.0; }

void fail(const char *file, int line, const char *what, const char *condition) {
    fprintf(stderr, "%s:%d: sequence %ld, %s, %s: %s; last message: %s\n", file, line, sequence,
            fmi->version, what, condition, messages.last);
    exit(1);
}

int main(int count, char **argument) {
    char reason[FMU_REASON];
    fmu_model model;
    if (count < 5) return 2;
    const char *folder = argument[1], *token = argument[2];
    const long sequences = atol(argument[3]);
    random_state = 0x9e3779b97f4a7c15u ^ (uint64_t)atol(argument[4]);
    if (!fmu_model_load(&model, folder, token, reason)) {
        fprintf(stderr, "%s\n", reason);
        return 2;
    }
    for (sequence = 0; sequence < sequences; sequence++) {
        fmi = below(2) ? &fmi2_calls : &fmi3_calls;
        if (count > 5)
            run_damage(folder, token);
        else
            run_sequence(&model, folder, token);
    }
    fmu_model_free(&model);
    printf("%ld sequences, %ld messages\n", sequences, messages.count);
    return 0;
}

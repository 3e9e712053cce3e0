/* Contact problems, friction tables and models, each array in a block of memory of its own and of
 * its exact size, so that the address sanitizer sees any step beyond an end. */
#ifndef TEST_FIXTURES_H
#define TEST_FIXTURES_H

#include <stddef.h>

#include "slipmode.h"

#define TWO_PI 6.283185307179586

double *new_doubles(size_t count); /* zeros */

typedef struct {
    sm_contact contact;
    double *limit, *stiffness, *damping, *coupling; /* what `contact` points to */
} problem;

/* Strongly coupled contacts with limits about 2, alpha 0.02, D = 0.01 K and complex coupling. */
problem new_problem(int contacts, int modes, int law);
void free_problem(problem *p);

typedef struct {
    sm_table table;
    double *node_a, *node_b, *values, *rate_correction, *detuning;
} table;

/* Amplitudes 0 to 4, unevenly spaced; S_j is a polynomial that a bicubic surface holds exactly. */
table new_table(int modes, int count_a, int count_b);
/* For two modes, with columns for combination resonances and for the friction power, and a
 * rate correction and slopes in the forcing frequencies. */
table new_rich_table(int count_a, int count_b, int combinations);
void free_table(table *t);
/* S_j of that polynomial, (Re, Im) of one or two modes. */
void exact_friction(int modes, double a, double b, double *s);

/* Slow flow at omega = 1 and 1.7 with damping 0.01 omega^2 over the table. */
sm_slow_flow flow_over(const table *t);
/* Doubles at the start of sm_inputs that the user sets. */
#define INPUT_COUNT (offsetof(sm_inputs, angle) / sizeof(double))
#define SEGMENT_COUNT (offsetof(sm_segment, reaction_start) / sizeof(double)) /* of sm_segment */
/* Forces 0.15 and 0.25, close to resonance. */
sm_inputs resonant_inputs(void);

/* Allocations by the core that still succeed; negative: all. */
extern int allocations_left;

/* A number in [0, 1) of a fixed sequence. */
double random_number(void);
int random_below(int count);

#endif

/* Contact problems, friction tables and slow flows, each array in a block of memory of its own and
 * of its exact size, so that the address sanitizer sees any step beyond an end. */
#ifndef TEST_FIXTURES_H
#define TEST_FIXTURES_H

#include <complex.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "driver.h"

#define PI 3.141592653589793
#define TWO_PI 6.283185307179586
#define COUNT(array) (sizeof(array) / sizeof *(array))

double *new_doubles(size_t count); /* zeros; until free_doubles */
void free_doubles(void);           /* all of them */

/* Strongly coupled contacts with limits about 2, alpha 0.02, D = 0.01 K and complex coupling. */
typedef struct {
    sm_contact contact;
    double *limit, *stiffness, *damping, *coupling; /* what `contact` points to */
} problem;
problem new_problem(int contacts, int modes, int law);

/* Amplitudes 0 to 4, unevenly spaced; S_j is a polynomial that a bicubic surface holds exactly. */
typedef struct {
    sm_table table;
    double *node_a, *node_b, *values, *rate_correction, *detuning;
} table;
table new_table(int modes, int count_a, int count_b);
/* For two modes, with columns for combination resonances and for the friction power, and a
 * rate correction and slopes in the forcing frequencies. */
table new_rich_table(int count_a, int count_b, int combinations);

/* Slow flow at omega = 1 and 1.7 with damping 0.01 omega^2 over the table. */
sm_slow_flow flow_over(const table *t);
/* Doubles at the start of sm_inputs that the user sets, and of sm_segment. */
#define INPUT_COUNT (offsetof(sm_inputs, angle) / sizeof(double))
#define SEGMENT_COUNT (offsetof(sm_segment, reaction_start) / sizeof(double))
/* Forces 0.15 and 0.25, close to resonance. */
sm_inputs resonant_inputs(void);

/* Allocations by the core that still succeed; negative: all. */
extern int allocations_left;

/* A number in [0, 1) of a fixed sequence; from -1 to 1; 10 to a power in the range. */
double random_number(void);
double random_sign(void);
double decades(double from, double count);
int random_below(int count);
/* One of the values hostile, every other time. */
void spoil(double *values, size_t count);
/* A status that there is, and finite values if it is SM_OK. */
void check_response(sm_status status, const double *values, size_t count);

#endif

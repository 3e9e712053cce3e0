/* Elastic contacts with random laws on a structure of random stiffness. */
#ifndef TEST_ELASTIC_FIXTURE_H
#define TEST_ELASTIC_FIXTURE_H

#include "fixtures.h"

typedef struct {
    sm_contact contact;
    sm_elastic elastic;
    sm_element *element;
    double *slider, *reference, *stiffness, *coupling, *flexibility; /* flexibility: R */
} joints;

enum { ANY_LAW = 0, ONLY_SLIDERS, ONLY_FRICTIONAL };

/* So many elements, with friction up to `mu`; R = (K + diag(k_ref))^-1 less a mode's part of it,
 * K a matrix of any softness whose off-diagonal part is `coupling` of it. */
joints new_joints(int elements, int modes, int laws, double mu, double coupling);
void free_joints(joints *j);

#endif

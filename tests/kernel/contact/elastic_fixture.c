#include "elastic_fixture.h"

#include <math.h>
#include <stdlib.h>

#define MOST_SLIDERS 5

static double decades(double from, double count) { return pow(10.0, from + count * random_number()); }

static void add_sliders(joints *j, sm_element *element, int column) {
    *element = (sm_element){.law = SM_SLIDERS,
                            .column = {column},
                            .first_slider = j->elastic.sliders,
                            .sliders = 1 + random_below(MOST_SLIDERS)};
    for (int k = 0; k < element->sliders; k++, j->elastic.sliders++) {
        double *slider = j->slider + 2 * j->elastic.sliders;
        slider[0] = random_below(10) ? decades(-1.5, 2.0) : 0.0;
        slider[1] = decades(-1.5, 3.0);
        j->reference[column] += slider[1];
    }
}

static void add_frictional(joints *j, sm_element *element, int column, int tangents, int open,
                           double mu) {
    *element = (sm_element){.law = SM_FRICTIONAL,
                            .column = {column, column + 1, column + 2},
                            .tangents = tangents,
                            .friction = mu * random_number(),
                            .tangential_stiffness = decades(-1.5, 3.0),
                            .normal_stiffness = decades(-1.5, 3.0)};
    if (open)
        element->gap = decades(-2.0, 2.0);
    else if (random_below(5))
        element->preload = decades(-1.5, 2.0);
    for (int k = 0; k < tangents && !open; k++)
        j->reference[column + k] = element->tangential_stiffness;
    j->reference[column + tangents] = open ? 0.0 : element->normal_stiffness;
}

/* Of a symmetric positive definite matrix, by Gauss and Jordan. */
static void invert(double *a, size_t n) {
    for (size_t p = 0; p < n; p++) {
        const double pivot = 1.0 / a[p * n + p];
        a[p * n + p] = 1.0;
        for (size_t k = 0; k < n; k++) a[p * n + k] *= pivot;
        for (size_t r = 0; r < n; r++) {
            if (r == p) continue;
            const double factor = a[r * n + p];
            a[r * n + p] = 0.0;
            for (size_t k = 0; k < n; k++) a[r * n + k] -= factor * a[p * n + k];
        }
    }
}

static void find_flexibility(joints *j, size_t n, double coupling) {
    double *R = j->flexibility, *g = new_doubles(n * n), *part = new_doubles(2 * n), whole = 0.0;
    const double soft = decades(-2.5, 4.0), kept = random_number();
    for (size_t k = 0; k < n * n; k++) g[k] = 2.0 * random_number() - 1.0;
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < n; k++) {
            double sum = 0.0;
            for (size_t m = 0; m < n; m++) sum += g[i * n + m] * g[k * n + m];
            R[i * n + k] = soft * coupling * 3.0 * sum / (double)n;
            if (i == k) R[i * n + k] += soft * (1.0 - coupling) + j->reference[i];
        }
    invert(R, n);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < n; k++) part[i] += R[i * n + k] * g[k];
    for (size_t i = 0; i < n; i++) whole += g[i] * part[i];
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < n; k++) R[i * n + k] -= kept * part[i] * part[k] / whole;
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < i; k++) R[i * n + k] = R[k * n + i];
    free(g);
    free(part);
}

joints new_joints(int elements, int modes, int laws, double mu, double coupling) {
    const size_t most = 3 * (size_t)elements;
    joints j = {.element = calloc((size_t)elements, sizeof(sm_element)),
                .slider = new_doubles(2 * MOST_SLIDERS * (size_t)elements),
                .reference = new_doubles(most)};
    int n = 0;
    if (!j.element) abort();
    for (int e = 0; e < elements; e++) {
        const int tangents = 1 + random_below(2), open = e > 0 && random_below(3) == 0;
        const int slides = laws == ONLY_SLIDERS || (laws == ANY_LAW && random_below(3) == 0);
        if (slides)
            add_sliders(&j, &j.element[e], n);
        else
            add_frictional(&j, &j.element[e], n, tangents, open, mu);
        n += slides ? 1 : tangents + 1;
    }
    const size_t count = (size_t)n, exact = 2 * (size_t)j.elastic.sliders;
    j.slider = realloc(j.slider, (exact + !exact) * sizeof(double)); /* to their sizes */
    j.reference = realloc(j.reference, count * sizeof(double));
    j.flexibility = new_doubles(count * count);
    j.stiffness = new_doubles(count * count);
    j.coupling = new_doubles(2 * count * (size_t)modes);
    if (!j.slider || !j.reference) abort();
    find_flexibility(&j, count, coupling);
    for (size_t k = 0; k < count * count; k++) j.stiffness[k] = -j.flexibility[k];
    for (size_t k = 0; k < 2 * count * (size_t)modes; k++)
        j.coupling[k] = (k % 2 ? 0.01 : 1.0) * (random_number() - 0.5);
    j.elastic.elements = elements;
    j.contact = (sm_contact){.contacts = n,
                             .modes = modes,
                             .law = SM_ELASTIC,
                             .stiffness = j.stiffness,
                             .coupling = j.coupling};
    return j;
}

void free_joints(joints *j) {
    free(j->element);
    free(j->slider);
    free(j->reference);
    free(j->stiffness);
    free(j->coupling);
    free(j->flexibility);
}

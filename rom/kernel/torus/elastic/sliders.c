/* Initial positions of sliders in periodic motion: after a period, and from harmonics.
 *
 * elastic_lines.c calls both functions, which elastic_lines.h describes. */
#include <string.h>

#include "torus/elastic/elastic_lines.h"

/* Carries the positions of one slider over, from the lines on which it has moved. */
static void carry_over(const sm_elastic_lines *e, const double *at_start, double *now) {
    const size_t lines = e->lines.lines, stride = e->memory_size;
    const double sign = e->half ? -1.0 : 1.0;
    double mean = 0.0;
    for (size_t p = 0; p < lines && !e->half; p++) mean += now[p * stride] / (double)lines;
    for (size_t p = 0; p < lines; p++) {
        if (now[p * stride] != at_start[p * stride]) continue;
        size_t from = p;
        double turned = 1.0;
        do {
            from = (from + lines - e->shift) % lines;
            turned *= sign;
        } while (from != p && now[from * stride] == at_start[from * stride]);
        now[p * stride] = from == p ? mean : turned * now[from * stride];
    }
}

void sm_carry_sliders_over(sm_elastic_lines *e) {
    const sm_elastic *elastic = e->contact->elastic;
    size_t at = 0;
    for (int32_t k = 0; k < elastic->elements; k++) {
        const sm_element *element = &elastic->element[k];
        const int count = element->law == SM_SLIDERS ? element->sliders : element->tangents;
        for (size_t i = at; i < at + (size_t)count; i++)
            carry_over(e, e->memory_at_start + i, e->memory + i);
        at += (size_t)sm_element_memory(element);
    }
}

/* Adds the harmonics of contact i in Y (orders, N_c, 2), over its stiffness, to its sliders. */
static void place_slider(const sm_elastic_lines *e, size_t i, const double *Y, double stiffness,
                         double *slider) {
    const sm_phase_lines *l = &e->lines;
    Y += 2 * i;
    for (size_t q = 0; q < l->orders; q++, Y += 2 * l->contacts) {
        const int m = l->order[2 * q + 1];
        const double *c = sm_phases_power(&l->phases, m), *s = c + l->phases.wide;
        const double back = m < 0 ? -1.0 : 1.0;
        for (size_t p = 0; p < l->lines; p++)
            slider[p * e->memory_size] += 2.0 * (Y[0] * c[p] - back * Y[1] * s[p]) / stiffness;
    }
}

void sm_place_sliders(sm_elastic_lines *e, const double *Y) {
    const sm_elastic *elastic = e->contact->elastic;
    double *memory = e->memory;
    for (int32_t k = 0; k < elastic->elements; k++) {
        const sm_element *element = &elastic->element[k];
        const int32_t i = element->column[0];
        const double stiffness = elastic->slider[2 * element->first_slider + 1];
        if (element->sliders == 1 && stiffness == elastic->reference[i])
            place_slider(e, (size_t)i, Y, stiffness, memory);
        memory += sm_element_memory(element);
    }
}

#include "torus/elastic/sliders.h"

#include <string.h>

static void carry_over(const sm_period *period, const double *at_start, double *now) {
    const size_t lines = period->lines, stride = period->remembered;
    const double sign = period->half ? -1.0 : 1.0;
    double mean = 0.0;
    for (size_t p = 0; p < lines && !period->half; p++) mean += now[p * stride] / (double)lines;
    for (size_t p = 0; p < lines; p++) {
        if (now[p * stride] != at_start[p * stride]) continue;
        size_t from = p;
        double turned = 1.0;
        do {
            from = (from + lines - period->shift) % lines;
            turned *= sign;
        } while (from != p && now[from * stride] == at_start[from * stride]);
        now[p * stride] = from == p ? mean : turned * now[from * stride];
    }
}

void sm_carry_sliders_over(const sm_elastic *elastic, const sm_period *period, double *memory) {
    size_t at = 0;
    for (int32_t e = 0; e < elastic->elements; e++) {
        const sm_element *element = &elastic->element[e];
        const int count = element->law == SM_SLIDERS ? element->sliders : element->tangents;
        for (size_t k = at; k < at + (size_t)count; k++)
            carry_over(period, period->at_start + k, memory + k);
        at += (size_t)sm_element_memory(element);
    }
}

void sm_place_sliders(const sm_phase_lines *l, const double *reference, const double *Y,
                      double *memory) {
    const size_t n = l->contacts;
    memset(memory, 0, l->lines * n * sizeof(double));
    for (size_t q = 0; q < l->orders; q++, Y += 2 * n) {
        const int m = l->order[2 * q + 1];
        const double *c = sm_phases_power(&l->phases, m), *s = c + l->phases.wide;
        const double back = m < 0 ? -1.0 : 1.0;
        for (size_t p = 0; p < l->lines; p++)
            for (size_t i = 0; i < n; i++)
                memory[p * n + i] +=
                    2.0 * (Y[2 * i] * c[p] - back * Y[2 * i + 1] * s[p]) / reference[i];
    }
}

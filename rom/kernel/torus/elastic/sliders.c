/* Initial positions of sliders in periodic motion: after a period, and from harmonics.
 *
 * elastic_lines.c calls both functions, which elastic_lines.h describes. */
#include <math.h>
#include <string.h>

#include "contact/elastic/reversal.h"
#include "torus/elastic/elastic_lines.h"

/* Smallest difference between 1 and the motion of a bound per motion of a slider. */
#define SMALLEST_LAG 0.05
/* Part of the step by which a slider that slid follows its bound, besides its slip. Of 0, 0.15, 0.3
 * and 0.5 it takes the fewest periods on the wedge damper of tests/rom/contact/test_wedge_damper.py. */
#define FORWARD 0.3

void sm_bound_sliders(sm_elastic_lines *e, size_t p, const double *x) {
    const sm_elastic *elastic = e->contact->elastic;
    for (int32_t k = 0; k < elastic->elements; k++) {
        const sm_element *element = &elastic->element[k];
        if (!sm_placed(element)) continue;
        const double N = element->preload
                         + element->normal_stiffness * (x[element->column[1]] - element->gap);
        const double limit = element->friction * fmax(N, 0.0), k_t = element->tangential_stiffness;
        const double centre = x[element->column[0]] + element->tangential_preload[0] / k_t;
        for (int side = 0; side < 2; side++) {
            double *last = e->last_bounds + 2 * (2 * (p * (size_t)elastic->elements + (size_t)k)
                                                 + (size_t)side);
            const double z[3] = {last[0], last[1], (side ? -centre : centre) - limit / k_t};
            double *bound = &e->bounds[2 * k + side];
            *bound = fmax(*bound, fmax(z[2], z[1] + sm_rise(z)));
            last[0] = z[1];
            last[1] = z[2];
        }
    }
}

/* Returns 1 less the motion of a bound per motion of the slider: low if `side` is 1, high if -1. */
static double lag(const sm_elastic_lines *e, const sm_element *element, double side) {
    const size_t i = (size_t)element->column[0], n = (size_t)element->column[1];
    const double *R = e->flexibility + i * e->lines.contacts;
    const double own = R[i] + sm_marched_flexibility(&e->marched, i, i);
    const double normal = R[n] + sm_marched_flexibility(&e->marched, i, n);
    const double rise = element->friction * element->normal_stiffness
                        / element->tangential_stiffness;
    const double k_ref = e->contact->elastic->reference[i];
    return fmax(1.0 - k_ref * (own - side * rise * normal), SMALLEST_LAG);
}

/* Returns the mean of a slider over the lines. */
static double mean(const sm_elastic_lines *e, const double *slider) {
    double sum = 0.0;
    for (size_t p = 0; p < e->lines.lines; p++) sum += slider[p * e->memory_size];
    return sum / (double)e->lines.lines;
}

/* Moves the slider of element k to a position on all lines; the integrated modes and the bounds at
 * the last steps move with it. */
static void move_slider(sm_elastic_lines *e, int32_t k, double *slider, double to) {
    const sm_elastic *elastic = e->contact->elastic;
    const sm_element *element = &elastic->element[k];
    const size_t i = (size_t)element->column[0];
    const double low = 1.0 - lag(e, element, 1.0), high = lag(e, element, -1.0) - 1.0;
    for (size_t p = 0; p < e->lines.lines; p++, slider += e->memory_size) {
        double *last = e->last_bounds + 4 * (p * (size_t)elastic->elements + (size_t)k);
        const double moved = to - *slider;
        sm_marched_shift(&e->marched, p, i, elastic->reference[i] * moved);
        last[0] += low * moved;
        last[1] += low * moved;
        last[2] += high * moved;
        last[3] += high * moved;
        *slider = to;
    }
}

void sm_place_stuck_sliders(sm_elastic_lines *e) {
    const sm_elastic *elastic = e->contact->elastic;
    size_t at = 0;
    for (int32_t k = 0; k < elastic->elements; k++) {
        const sm_element *element = &elastic->element[k];
        const double low = e->bounds[2 * k], high = -e->bounds[2 * k + 1];
        if (sm_placed(element) && low < high) {
            const double side = low > 0.0 ? 1.0 : -1.0, bound = low > 0.0 ? low : high;
            const double from = mean(e, e->memory_at_start + at), now = mean(e, e->memory + at);
            const double further = 1.0 / lag(e, element, side) - 1.0;
            double to = 0.0;
            if (low > 0.0 || high < 0.0) {
                to = bound + further * (bound - now + FORWARD * (now - from));
                to = side * fmax(side * to, 0.0);
            }
            move_slider(e, k, e->memory + at, to);
        }
        at += (size_t)sm_element_memory(element);
    }
}

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

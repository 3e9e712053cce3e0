/* Values along phase lines by the places where these began: line p is where p + turned did. */
#ifndef SLIPMODE_PLACES_H
#define SLIPMODE_PLACES_H

#include <stddef.h>
#include <string.h>

typedef struct {
    size_t lines, size; /* values of a line; 0: nothing is kept by places */
    size_t turned;
} sm_places;

static inline size_t sm_places_size(const sm_places *places) {
    return places->lines * places->size;
}

static inline void sm_places_take(const sm_places *places, const double *by_line,
                                  double *by_place) {
    const size_t size = places->size;
    for (size_t p = 0; p < places->lines; p++)
        memcpy(by_place + (p + places->turned) % places->lines * size, by_line + p * size,
               size * sizeof(double));
}

static inline void sm_places_give(const sm_places *places, const double *by_place,
                                  double *by_line) {
    const size_t size = places->size;
    for (size_t p = 0; p < places->lines; p++)
        memcpy(by_line + p * size, by_place + (p + places->turned) % places->lines * size,
               size * sizeof(double));
}

#endif

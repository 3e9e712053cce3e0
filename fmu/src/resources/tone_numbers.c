/* The flow of modes that share a tone, from the numbers of tone.npy: the doubles of sm_tone, and the
 * arrays that it points to, in the order of its fields. fmu/archive/resources.py writes them. */
#include "resources/model.h"

typedef struct {
    const double *number; /* NULL: they are only counted */
    size_t taken;
} reader;

static const double *take(reader *r, size_t count) {
    const double *found = r->number ? r->number + r->taken : NULL;
    r->taken += count;
    return found;
}

static double take_one(reader *r) {
    const double *found = take(r, 1);
    return found ? *found : 0.0;
}

static void take_modes(reader *r, int32_t modes, size_t contacts, size_t rows,
                       sm_tone_modes *to) {
    const size_t M = 2 * (size_t)modes;
    to->count = modes;
    to->pole = take(r, M);
    to->excitation = take(r, M);
    to->conjugate = take(r, M);
    to->motion = take(r, M * contacts);
    to->projection = take(r, M * contacts);
    to->output = take(r, M * rows);
}

static void take_carrier(reader *r, const fmu_layout *shape, int t, sm_tone_carrier *to) {
    const size_t n = (size_t)shape->contacts;
    const size_t rows = (size_t)shape->retained[t] + (size_t)shape->elastic + 1;
    take_modes(r, shape->slow[t], n, rows, &to->slow);
    take_modes(r, shape->fast[t], n, rows, &to->fast);
    to->amplitudes = shape->retained[t];
    to->reference = take_one(r);
    to->flexibility = take(r, 2 * n * (n + 1));
    to->own = take(r, 2 * n);
    to->output = take(r, 2 * rows * (n + 1));
}

size_t fmu_tone_numbers(const fmu_layout *shape, const double *number, sm_tone *tone) {
    const size_t n = (size_t)shape->contacts, kinds = (size_t)shape->kinds;
    reader r = {number, 0};
    tone->tones = shape->slow[1] > 0 ? 2 : 1;
    for (int t = 0; t < tone->tones; t++) take_carrier(&r, shape, t, &tone->carrier[t]);
    tone->contacts = shape->contacts;
    tone->kinds = shape->kinds;
    tone->nodes = shape->nodes;
    tone->shares = shape->shares;
    tone->elastic = shape->elastic;
    tone->contact_motion = 1;
    tone->stiffness = take(&r, n);
    tone->onset = take(&r, kinds);
    tone->first = take_one(&r);
    tone->spacing = take_one(&r);
    const size_t values = 4 * (size_t)(tone->tones * tone->tones) * kinds;
    tone->secant = take(&r, values * (size_t)shape->nodes * (size_t)shape->shares);
    tone->contraction = take_one(&r);
    return r.taken;
}

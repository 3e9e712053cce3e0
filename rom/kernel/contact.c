#include "contact.h"

#include <math.h>

static int all_finite(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return 0;
    return 1;
}

sm_status sm_contact_check(const sm_contact *contact) {
    if (!contact || contact->contacts < 1 || contact->contacts > 100000) return SM_BAD_ARGUMENT;
    if (contact->modes < 1 || contact->modes > SM_MODES) return SM_BAD_ARGUMENT;
    if (!contact->limit || !contact->stiffness || !contact->damping || !contact->coupling)
        return SM_BAD_ARGUMENT;
    const size_t n = (size_t)contact->contacts;
    if (!all_finite(contact->limit, n) || !all_finite(contact->stiffness, n * n) ||
        !all_finite(contact->damping, n * n) ||
        !all_finite(contact->coupling, 2 * n * (size_t)contact->modes))
        return SM_NOT_FINITE;
    if (contact->law != SM_TANH && contact->law != SM_COULOMB) return SM_BAD_ARGUMENT;
    if (contact->law == SM_TANH && !(contact->alpha > 0.0 && isfinite(contact->alpha)))
        return SM_BAD_ARGUMENT;
    for (size_t i = 0; i < n; i++)
        if (contact->limit[i] < 0.0 || !(contact->stiffness[i * n + i] > 0.0))
            return SM_BAD_ARGUMENT;
    return SM_OK;
}

size_t sm_stepper_size(int contacts) {
    const size_t n = (size_t)contacts;
    return 2 * n * n + (n * sizeof(sm_resolvent) + sizeof(double) - 1) / sizeof(double);
}

void sm_stepper_place(sm_stepper *stepper, int contacts, double *memory) {
    const size_t n = (size_t)contacts;
    stepper->contacts = contacts;
    stepper->h = 0.0;
    stepper->matrix = memory;
    stepper->stiffness = memory + n * n;
    stepper->laws = (sm_resolvent *)(void *)(memory + 2 * n * n);
}

void sm_stepper_set(sm_stepper *stepper, const sm_contact *contact, double h) {
    const int n = contact->contacts;
    if (stepper->h == h) return;
    stepper->h = h;
    for (int i = 0; i < n * n; i++) {
        stepper->stiffness[i] = contact->stiffness[i];
        stepper->matrix[i] = contact->damping[i] + SM_GAMMA * h * contact->stiffness[i];
    }
    for (int i = 0; i < n; i++)
        stepper->laws[i] = sm_resolvent_make(contact->law, stepper->matrix[i * n + i],
                                             contact->limit[i], contact->alpha);
}

size_t sm_lanes_size(int contacts, int lanes) {
    const size_t n = (size_t)contacts, w = (size_t)lanes;
    return (10 + (contacts > 2 ? n : 0)) * n * w;
}

void sm_lanes_place(sm_lanes *m, int contacts, int lanes, double *memory) {
    const size_t size = (size_t)contacts * (size_t)lanes;
    double **arrays[] = {&m->x, &m->base, &m->u, &m->y, &m->v, &m->d,
                         &m->stage_v[0], &m->stage_v[1], &m->r, &m->residual};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++, memory += size)
        *arrays[i] = memory;
    m->factor = memory;
}

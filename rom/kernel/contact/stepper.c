/* Matrices of the steps of stepper.h, and work arrays of lanes. */
#include "contact/stepper.h"

#include "base/check.h"
#include "base/dense.h"

void sm_stepper_place(sm_stepper *stepper, int contacts, sm_block *block) {
    const size_t n = (size_t)contacts;
    *stepper = (sm_stepper){.contacts = contacts, .massless = 1};
    SM_TAKE_EACH(block, n * n, &stepper->matrix, &stepper->stiffness, &stepper->factor,
                 &stepper->inertia);
    stepper->laws = (void *)sm_take(block, sm_doubles(n * sizeof(sm_resolvent)));
}

/* Returns whether the matrix is positive definite. Its diagonal is raised slightly, as rounding may
 * make a semidefinite matrix indefinite. */
static int positive_definite(const double *matrix, size_t n, double *factor) {
    memcpy(factor, matrix, n * n * sizeof(double));
    for (size_t i = 0; i < n; i++) factor[i * n + i] *= 1.0 + SM_ROUNDING_TOLERANCE;
    return sm_cholesky(n, 0.0, factor) == n;
}

/* Sets the law of contact i for the step matrix. */
static void set_law(sm_stepper *stepper, const sm_contact *contact, int i) {
    stepper->laws[i] = sm_resolvent_make(contact->law, stepper->matrix[i * (stepper->contacts + 1)],
                                         contact->limit[i], contact->alpha);
}

sm_status sm_stepper_set(sm_stepper *stepper, const sm_contact *contact, double h) {
    const int n = contact->contacts;
    if (stepper->h == h) { /* limits may be scaled from one march to the next */
        for (int i = 0; i < n; i++)
            if (stepper->laws[i].limit != contact->limit[i]) set_law(stepper, contact, i);
        return SM_OK;
    }
    stepper->h = 0.0; /* until the matrix is known to be positive definite */
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            const int k = i * n + j, low = i > j ? k : j * n + i; /* symmetric to the last bit */
            stepper->stiffness[k] = contact->stiffness[low];
            stepper->inertia[k] = contact->mass ? contact->mass[low] / (SM_GAMMA * h) : 0.0;
            stepper->matrix[k] = stepper->inertia[k] + contact->damping[low]
                                 + SM_GAMMA * h * contact->stiffness[low];
        }
    stepper->massless = !contact->mass;
    stepper->sticks = contact->law == SM_COULOMB;
    stepper->tolerance = SM_SMOOTH_TOLERANCE;
    for (int i = 0; i < n; i++) set_law(stepper, contact, i);
    if (!positive_definite(stepper->matrix, (size_t)n, stepper->factor)) return SM_BAD_ARGUMENT;
    stepper->h = h;
    return SM_OK;
}

void sm_lanes_place(sm_lanes *m, int contacts, int lanes, sm_block *block) {
    const size_t n = (size_t)contacts, size = n * (size_t)lanes, before = block->taken;
    SM_TAKE_EACH(block, size, &m->x, &m->base, &m->u, &m->v, &m->g, &m->slope, &m->stage_v[0],
                 &m->stage_v[1], &m->inertia, &m->r, &m->residual, &m->step, &m->before);
    m->factor = sm_take(block, size * n);
    if (lanes == 1) m->last_r = sm_take(block, n);
    m->lanes = lanes;
    m->rows = 0;
    m->size = block->taken - before;
}

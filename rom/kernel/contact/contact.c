/* Checks of the contacts of all functions of slipmode.h. */
#include "base/check.h"
#include "base/cnumber.h"
#include "contact/elastic/law.h"

/* Returns whether a matrix is symmetric, except for rounding. */
static int symmetric(const double *matrix, size_t n) {
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++) {
            const double size = sqrt(fabs(matrix[i * n + i])) * sqrt(fabs(matrix[j * n + j]));
            const double difference = fabs(matrix[i * n + j] - matrix[j * n + i]);
            if (!(difference <= SM_ROUNDING_TOLERANCE * size)) return 0;
        }
    return 1;
}

/* Checks the modes that are integrated with elastic contacts. */
static sm_status check_marched(const sm_modal_response *response, size_t contacts) {
    if (response->marched < 0 || response->marched > 4096) return SM_BAD_ARGUMENT;
    if (response->marched == 0) return SM_OK;
    if (!response->projection || !response->advance) return SM_BAD_ARGUMENT;
    const size_t modes = (size_t)response->marched;
    return sm_all_finite(response->projection, modes * contacts) &&
                   sm_all_finite(response->advance, 8 * modes)
               ? SM_OK : SM_NOT_FINITE;
}

/* Checks the response of the modes. */
static sm_status check_response(const sm_contact *contact) {
    const sm_modal_response *response = contact->response;
    const size_t n = (size_t)contact->contacts;
    SM_TRY(sm_orders_check(response->orders_count, response->orders));
    if (!response->dynamic_stiffness) return SM_OK;
    if (response->requested < 0 || response->requested > response->orders_count) return SM_BAD_ARGUMENT;
    SM_TRY(check_marched(response, n));
    const size_t harmonics = (size_t)response->orders_count * n * 2;
    return sm_all_finite(response->dynamic_stiffness, harmonics * n) &&
                   (!response->start || sm_all_finite(response->start, harmonics)) &&
                   (!response->prescribed || sm_all_finite(response->prescribed, harmonics))
               ? SM_OK : SM_NOT_FINITE;
}

/* Checks the dual problem of elastic contacts: K is negative semidefinite, and there is no mass. A
 * model may have no contacts. */
static sm_status check_elastic(const sm_contact *contact) {
    const size_t n = (size_t)contact->contacts;
    if (contact->mass) return SM_BAD_ARGUMENT;
    for (size_t i = 0; i < n; i++)
        if (contact->stiffness[i * n + i] > 0.0) return SM_BAD_ARGUMENT;
    if (n == 0 && contact->elastic && contact->elastic->elements == 0)
        return contact->elastic->sliders == 0 ? SM_OK : SM_BAD_ARGUMENT;
    SM_TRY(sm_elastic_check(contact->elastic, contact->contacts));
    return contact->response ? check_response(contact) : SM_OK;
}

sm_status sm_contact_check(const sm_contact *contact) {
    /* indices of (N_c, N_c) matrices fit an int */
    if (!contact || contact->contacts < 0 || contact->contacts > 32768) return SM_BAD_ARGUMENT;
    if (contact->contacts == 0 && contact->law != SM_ELASTIC) return SM_BAD_ARGUMENT;
    if (contact->modes < 1 || contact->modes > SM_MODES) return SM_BAD_ARGUMENT;
    if (!contact->stiffness || !contact->coupling) return SM_BAD_ARGUMENT;
    const size_t n = (size_t)contact->contacts;
    if (!sm_all_finite(contact->stiffness, n * n) ||
        !sm_all_finite(contact->coupling, 2 * n * (size_t)contact->modes))
        return SM_NOT_FINITE;
    if (!symmetric(contact->stiffness, n)) return SM_BAD_ARGUMENT;
    if (contact->law == SM_ELASTIC) return check_elastic(contact);
    if (!contact->limit || !contact->damping) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(contact->limit, n) || !sm_all_finite(contact->damping, n * n))
        return SM_NOT_FINITE;
    if (contact->law != SM_TANH && contact->law != SM_COULOMB) return SM_BAD_ARGUMENT;
    if (contact->law == SM_TANH) SM_TRY(sm_check_positive(contact->alpha));
    for (size_t i = 0; i < n; i++)
        if (contact->limit[i] < 0.0 || !(contact->stiffness[i * n + i] > 0.0))
            return SM_BAD_ARGUMENT;
    if (contact->mass && !sm_all_finite(contact->mass, n * n)) return SM_NOT_FINITE;
    if (!symmetric(contact->damping, n) || (contact->mass && !symmetric(contact->mass, n)))
        return SM_BAD_ARGUMENT;
    return contact->response ? check_response(contact) : SM_OK;
}

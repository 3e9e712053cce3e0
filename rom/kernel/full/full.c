/* Time integration of I q'' + C q' + Lambda q + W g = f(t) with friction at the contacts.
 *
 * Coordinates are such that the mass matrix is I and the stiffness matrix Lambda diagonal. Steps
 * with rigid friction are in esdirk4.h, steps with elastic contacts in elastic_step.c.
 * sm_full_march, which rom/full calls, checks its arguments, makes the steps and samples the
 * motion. */
#include "full/elastic_step.h"
#include "full/esdirk4.h"

#include <stdlib.h>

#include "base/check.h"
#include "base/dense.h"
#include "slow/slow_flow.h"

size_t sm_full_state_count(const sm_full *full) {
    const size_t remembered = full->law == SM_ELASTIC ? sm_elastic_memory(full->elastic) : 0;
    return 2 * (size_t)full->coordinates + 3 * (size_t)full->contacts + 1 + remembered;
}

/* Checks sizes and pointers. */
static sm_status check_sizes(const sm_full *full) {
    /* (n, n) matrices fit the memory of a workstation */
    if (!full || full->coordinates < 1 || full->coordinates > 16384) return SM_BAD_ARGUMENT;
    if (full->contacts < 1 || full->contacts > full->coordinates) return SM_BAD_ARGUMENT;
    if (full->modes < 1 || full->modes > SM_MODES) return SM_BAD_ARGUMENT;
    if (full->outputs < 0 || full->outputs > SM_MOST_OUTPUTS) return SM_BAD_ARGUMENT;
    if (!full->stiffness || !full->damping || !full->directions || !full->patterns ||
        !full->inverse || (full->outputs > 0 && !full->output))
        return SM_BAD_ARGUMENT;
    if (full->law == SM_ELASTIC)
        return full->flexibility && full->own && full->ahead
                   ? sm_elastic_check(full->elastic, full->contacts)
                   : SM_BAD_ARGUMENT;
    if (full->law != SM_TANH && full->law != SM_COULOMB) return SM_BAD_ARGUMENT;
    return full->limit && full->resistance ? SM_OK : SM_BAD_ARGUMENT;
}

/* Checks the values that elastic contacts need. */
static sm_status check_elastic_values(const sm_full *full) {
    const size_t n = (size_t)full->coordinates, contacts = (size_t)full->contacts;
    if (!sm_all_finite(full->flexibility, contacts * contacts) ||
        !sm_all_finite(full->own, n) || !sm_all_finite(full->ahead, n))
        return SM_NOT_FINITE;
    for (size_t k = 0; k < n; k++)
        if (!(full->own[k] > 0.0) || full->ahead[k] < 0.0) return SM_BAD_ARGUMENT;
    return SM_OK;
}

/* Checks that all values are finite and in their ranges. */
static sm_status check_values(const sm_full *full) {
    const size_t n = (size_t)full->coordinates, contacts = (size_t)full->contacts;
    const size_t entries = full->diagonal ? n : n * n;
    if (!sm_all_finite(full->stiffness, n) || !sm_all_finite(full->damping, entries) ||
        !sm_all_finite(full->inverse, entries) ||
        !sm_all_finite(full->directions, contacts * n) ||
        !sm_all_finite(full->patterns, (size_t)full->modes * n) ||
        !sm_all_finite(full->output, (size_t)full->outputs * n))
        return SM_NOT_FINITE;
    SM_TRY(sm_check_positive(full->step));
    if (full->law == SM_ELASTIC) return check_elastic_values(full);
    if (!sm_all_finite(full->limit, contacts) ||
        !sm_all_finite(full->resistance, contacts * contacts))
        return SM_NOT_FINITE;
    for (size_t i = 0; i < contacts; i++)
        if (full->limit[i] < 0.0) return SM_BAD_ARGUMENT;
    return full->law == SM_COULOMB ? SM_OK : sm_check_positive(full->alpha);
}

/* Takes the arrays from a block, or counts them. */
static void place(sm_esdirk4 *m, sm_elastic_step *elastic, const sm_full *full, sm_block *block) {
    const size_t width = sm_whole((size_t)full->coordinates, SM_SHORT_VECTOR);
    const size_t contacts = (size_t)full->contacts;
    SM_TAKE_EACH(block, width, &m->q, &m->v, &m->base_q, &m->base_v, &m->stiffness, &m->per_step,
                 &m->load);
    SM_TAKE_EACH(block, SM_ESDIRK4_STAGES * width, &m->stage_v, &m->stage_dv);
    SM_TAKE_EACH(block, SM_MODES * width, &m->pattern, &m->pattern_response);
    m->response = sm_take(block, contacts * width);
    m->inverse = sm_take(block, full->diagonal ? width : width * width);
    SM_TAKE_EACH(block, contacts, &m->x_c, &m->force);
    if (elastic) {
        sm_elastic_step_place(elastic, full, width, block);
        m->v_c = elastic->v_c;
        return;
    }
    m->gather = sm_take(block, contacts * width);
    sm_lanes_place(&m->lane, full->contacts, 1, block);
    sm_stepper_place(&m->stepper, full->contacts, block);
    m->v_c = m->lane.v;
}

/* Sets to = A^-1 from, for one row of n values. */
static void divide(const sm_full *full, const double *from, double *to) {
    const size_t n = (size_t)full->coordinates;
    for (size_t i = 0; i < n; i++) {
        to[i] = full->diagonal ? full->inverse[i] * from[i] : 0.0;
        for (size_t k = 0; k < n && !full->diagonal; k++)
            to[i] += full->inverse[i * n + k] * from[k];
    }
}

/* Sets the arrays that are constant in time. */
static sm_status prepare(sm_esdirk4 *m, sm_elastic_step *elastic, const sm_full *full) {
    const size_t n = (size_t)full->coordinates, contacts = (size_t)full->contacts;
    const size_t width = m->width, rows = full->diagonal ? 1 : n;
    memcpy(m->stiffness, full->stiffness, n * sizeof(double));
    for (size_t k = 0; k < n; k++)
        m->per_step[k] = 1.0 / (elastic ? full->own[k] : SM_FULL_GAMMA * full->step);
    for (size_t i = 0; i < rows; i++)
        memcpy(m->inverse + i * width, full->inverse + i * n, n * sizeof(double));
    for (size_t j = 0; j < (size_t)full->modes; j++) {
        memcpy(m->pattern + j * width, full->patterns + j * n, n * sizeof(double));
        divide(full, m->pattern + j * width, m->pattern_response + j * width);
    }
    for (size_t i = 0; i < contacts; i++)
        divide(full, full->directions + i * n, m->response + i * width);
    if (elastic) {
        sm_elastic_step_set(elastic, full);
        return SM_OK;
    }
    for (size_t i = 0; i < contacts; i++)
        for (size_t j = 0; j < contacts; j++)
            for (size_t k = 0; k < n; k++)
                m->gather[i * width + k] +=
                    full->resistance[i * contacts + j] * full->directions[j * n + k];
    const sm_contact contact = {.contacts = full->contacts,
                                .modes = full->modes,
                                .law = full->law,
                                .alpha = full->alpha,
                                .limit = full->limit,
                                .stiffness = m->stepper.stiffness, /* zeros: S is all there is */
                                .damping = full->resistance};
    const sm_status status = sm_stepper_set(&m->stepper, &contact, full->step);
    m->stepper.tolerance = SM_READ_TOLERANCE;
    return status;
}

/* Sets stage_dv[0] = f - Lambda q - C v - W g, times gamma h if friction is rigid. */
static void start_acceleration(sm_esdirk4 *m, const sm_full *full, const double *force) {
    const size_t n = (size_t)full->coordinates, width = m->width;
    for (size_t k = 0; k < n; k++) {
        double sum = m->pattern[k] * force[0] + m->pattern[width + k] * force[1]
                     - m->stiffness[k] * m->q[k];
        if (full->diagonal) sum -= full->damping[k] * m->v[k];
        for (size_t j = 0; j < n && !full->diagonal; j++)
            sum -= full->damping[k * n + j] * m->v[j];
        for (int i = 0; i < full->contacts; i++)
            sum -= full->directions[(size_t)i * n + k] * m->force[i];
        m->stage_dv[k] = full->law == SM_ELASTIC ? sum : SM_FULL_GAMMA * m->h * sum;
    }
}

/* Copies the state to `state`, or from there if `back`. */
static void exchange_state(sm_esdirk4 *m, sm_elastic_step *elastic, const sm_full *full,
                           double *state, int back) {
    const size_t n = (size_t)full->coordinates, contacts = (size_t)full->contacts;
    double *const row[] = {m->q,     m->v,           m->x_c, elastic ? elastic->v_c : m->lane.v,
                           m->force, &m->dissipated, elastic ? elastic->memory : NULL};
    const size_t size[] = {n,        n, contacts,                       contacts,
                           contacts, 1, elastic ? elastic->remembered : 0};
    for (size_t k = 0; k < sizeof row / sizeof *row; state += size[k++])
        if (size[k] > 0) memcpy(back ? row[k] : state, back ? state : row[k], size[k] * sizeof *state);
}

/* Starts from a state at `elapsed`. */
static void start(sm_esdirk4 *m, sm_elastic_step *elastic, const sm_full *full,
                  const sm_inputs *inputs, double elapsed, double *state) {
    exchange_state(m, elastic, full, state, 1);
    if (elastic) memcpy(elastic->x_c, m->x_c, (size_t)full->contacts * sizeof(double));
    m->lane.rows = 0;
    m->carrier.modes = full->modes;
    m->carrier.inputs = inputs;
    m->carrier.h = full->step;
    for (int stage = 0; stage < SM_ESDIRK4_STAGES; stage++)
        m->carrier.offset[stage] = SM_ESDIRK4_OFFSET[stage] * full->step;
    sm_carrier_anchor(&m->carrier, elapsed);
    double force[SM_MODES] = {0.0};
    sm_carrier_force(&m->carrier, 0, elapsed, force);
    start_acceleration(m, full, force);
}

/* Makes steps `first` to `first + steps` of a run that starts `elapsed` seconds into the inputs. */
SM_HOT static sm_status march(sm_esdirk4 *m, sm_elastic_step *elastic, double elapsed,
                              size_t first, size_t steps) {
    for (size_t k = first; k < first + steps; k++) {
        const double now = elapsed + m->h * (double)k;
        if (k % SM_EXACT_STEPS == 0) sm_carrier_anchor(&m->carrier, now);
        SM_TRY(elastic ? sm_elastic_step_take(elastic, m, now) : sm_esdirk4_step(m, now));
    }
    if (elastic) sm_elastic_step_velocity(elastic, m->v);
    return SM_OK;
}

/* Writes displacements, velocities and forces of the contacts. */
static void sample_contacts(const sm_esdirk4 *m, const sm_full *full, double *contact) {
    const size_t contacts = (size_t)full->contacts;
    for (size_t i = 0; i < contacts; i++) {
        contact[i] = m->x_c[i];
        contact[contacts + i] = m->v_c[i];
        contact[2 * contacts + i] = m->force[i];
        if (full->law == SM_ELASTIC) continue;
        const double limit = full->limit[i]; /* rounding must not carry the force beyond it */
        contact[2 * contacts + i] = fmax(-limit, fmin(m->force[i], limit));
    }
}

/* Checks the arguments of sm_full_march. */
static sm_status check_run(const sm_full *full, const sm_inputs *inputs, double elapsed,
                           const double *state, const sm_full_samples *samples) {
    SM_TRY(check_sizes(full));
    SM_TRY(check_values(full));
    if (!inputs || !state || !samples || samples->count < 1 || samples->every < 1
        || !isfinite(elapsed))
        return SM_BAD_ARGUMENT;
    const int displaced = samples->displacement && samples->velocity;
    if ((full->outputs > 0 && !displaced) || !samples->contact || !samples->dissipated)
        return SM_BAD_ARGUMENT;
    if (!sm_all_finite(state, sm_full_state_count(full))) return SM_NOT_FINITE;
    /* `full` has the friction limits */
    if (inputs->limit_scale != 1.0 || inputs->limit_scale_rate != 0.0) return SM_BAD_ARGUMENT;
    return sm_inputs_check(inputs, full->modes);
}

sm_status sm_full_march(const sm_full *full, const sm_inputs *inputs, double elapsed,
                        double *state, const sm_full_samples *samples) {
    SM_TRY(check_run(full, inputs, elapsed, state, samples));
    sm_elastic_step of_elastic, *elastic = full->law == SM_ELASTIC ? &of_elastic : NULL;
    sm_esdirk4 m = {.contacts = full->contacts,
                    .diagonal = full->diagonal,
                    .width = sm_whole((size_t)full->coordinates, SM_SHORT_VECTOR),
                    .h = full->step};
    sm_block block = {NULL, 0};
    place(&m, elastic, full, &block);
    if (!sm_allocate(&block)) return SM_NO_MEMORY;
    place(&m, elastic, full, &block);
    sm_status status = prepare(&m, elastic, full);
    if (status == SM_OK) start(&m, elastic, full, inputs, elapsed, state);
    const size_t n = (size_t)full->coordinates, rows = (size_t)full->outputs;
    for (size_t s = 0; s < samples->count && status == SM_OK; s++) {
        status = march(&m, elastic, elapsed, s * samples->every, samples->every);
        for (size_t i = 0; i < rows; i++) {
            samples->displacement[s * rows + i] = sm_dot(n, full->output + i * n, m.q);
            samples->velocity[s * rows + i] = sm_dot(n, full->output + i * n, m.v);
        }
        sample_contacts(&m, full, samples->contact + s * 3 * (size_t)full->contacts);
        samples->dissipated[s] = m.dissipated;
    }
    if (status == SM_OK) {
        exchange_state(&m, elastic, full, state, 0);
        status = sm_all_finite(state, sm_full_state_count(full)) ? SM_OK : SM_NOT_FINITE;
    }
    free(block.memory);
    return status;
}

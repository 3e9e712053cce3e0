/* The component: slow flow, eqs. (18), (19), and contact motion, eq. (12), under inputs that
 * change linearly over a step: memory, inputs, outputs and state. component_steps.c makes its
 * steps. The contact motion (contact_output.c) is integrated when it is read. Python, the FMU and
 * the explorer call it. */
#include <stdlib.h>

#include "base/check.h"
#include "slow/component/component.h"
#include "table/table.h"

sm_status sm_component_check(const sm_slow_flow *flow, const sm_contact *contact,
                             const sm_motion *motion) {
    if (!flow || !motion) return SM_BAD_ARGUMENT;
    SM_TRY(sm_table_check(&flow->table));
    SM_TRY(sm_slow_flow_check(flow));
    SM_TRY(sm_contact_check(contact));
    if (contact->modes != flow->table.modes) return SM_BAD_ARGUMENT;
    return sm_motion_check(motion, contact, &flow->table);
}

sm_status sm_component_checked_create(const sm_slow_flow *flow, const sm_contact *contact,
                                      const sm_motion *motion, double tolerance,
                                      sm_component **component) {
    if (!flow || !contact || !motion || !component) return SM_BAD_ARGUMENT;
    SM_TRY(sm_slow_flow_check(flow));
    SM_TRY(sm_check_positive(tolerance));
    if (tolerance >= 1.0) return SM_BAD_ARGUMENT;
    const size_t header = sm_whole_lines(sm_doubles(sizeof(sm_component)));
    sm_block block = {NULL, 0};
    sm_component counted, *c = &counted;
    for (int counts = 1; counts >= 0; counts--) {
        if (!counts && !sm_allocate(&block)) return SM_NO_MEMORY;
        double *own = sm_take(&block, header);
        if (!counts) c = (void *)own;
        c->flow = *flow;
        sm_contact_output_place(&c->contacts, motion, contact, &block);
    }
    c->tolerance = tolerance;
    c->inputs.limit_scale = 1.0;
    for (int j = 0; j < contact->modes; j++) c->inputs.frequency[j] = flow->natural[j];
    *component = c;
    return SM_OK;
}

sm_status sm_component_create(const sm_slow_flow *flow, const sm_contact *contact,
                              const sm_motion *motion, double tolerance,
                              sm_component **component) {
    if (!component) return SM_BAD_ARGUMENT;
    SM_TRY(sm_component_check(flow, contact, motion));
    return sm_component_checked_create(flow, contact, motion, tolerance, component);
}

void sm_component_free(sm_component *component) { free(component); }

/* Copies the angles of the state, which are exact sums, to the inputs for the combination
 * resonances. */
static void align_angles(sm_component *c) {
    for (int j = 0; j < SM_MODES; j++) c->inputs.angle[j] = c->slow.angle[j].value;
}

/* Computes the derivative of the unknowns; returns SM_OK for finite amplitudes inside the table. */
static sm_status rate_at(const sm_component *c, const sm_inputs *inputs, const double *amplitude,
                         double *rate) {
    sm_instant instant = {.known = 0};
    if (!sm_all_finite(amplitude, 2 * (size_t)c->flow.table.modes)) return SM_NOT_FINITE;
    sm_instant_set(&instant, &c->flow, inputs);
    return sm_slow_flow_derivative(&c->flow, &instant, amplitude, rate);
}

sm_status sm_component_reset(sm_component *c, double time, const double *amplitude) {
    if (!c || !amplitude) return SM_BAD_ARGUMENT;
    if (!isfinite(time)) return SM_NOT_FINITE;
    double rate[SM_UNKNOWNS];
    SM_TRY(rate_at(c, &c->inputs, amplitude, rate));
    sm_slow_state fresh = {.time = {time, 0.0}};
    memcpy(fresh.amplitude, amplitude, 2 * (size_t)c->flow.table.modes * sizeof(double));
    c->slow = fresh;
    align_angles(c);
    c->rate_known = 0; /* the angles have changed */
    sm_contact_output_reset(&c->contacts);
    return SM_OK;
}

sm_status sm_component_set_amplitude(sm_component *c, const double *amplitude) {
    if (!c || !amplitude) return SM_BAD_ARGUMENT;
    double rate[SM_UNKNOWNS];
    SM_TRY(rate_at(c, &c->inputs, amplitude, rate));
    memcpy(c->slow.amplitude, amplitude, 2 * (size_t)c->flow.table.modes * sizeof(double));
    c->slow.step = 0.0;
    c->rate_known = 0;
    return SM_OK;
}

/* Checks the inputs; the limits can be scaled if friction is homogeneous. */
static sm_status check_inputs(const sm_component *c, const sm_inputs *inputs) {
    SM_TRY(sm_inputs_check(inputs, c->flow.table.modes));
    if (inputs->limit_scale == 1.0 && inputs->limit_scale_rate == 0.0) return SM_OK;
    const sm_contact *contact = &c->contacts.contact;
    const int scales = contact->law == SM_ELASTIC ? sm_elastic_homogeneous(contact->elastic)
                                                  : contact->law == SM_COULOMB;
    return scales ? SM_OK : SM_BAD_ARGUMENT;
}

sm_status sm_component_set_inputs(sm_component *c, const sm_inputs *inputs) {
    if (!c || !inputs) return SM_BAD_ARGUMENT;
    SM_TRY(check_inputs(c, inputs));
    const sm_inputs before = c->inputs;
    c->inputs = sm_inputs_after(inputs, c->flow.table.modes, 0.0);
    align_angles(c);
    if (memcmp(&before, &c->inputs, sizeof before) != 0) c->rate_known = 0;
    return SM_OK;
}

size_t sm_component_output_count(const sm_component *c) {
    if (!c) return 0;
    const sm_motion *motion = &c->contacts.motion;
    const size_t moving = 3 * (size_t)c->contacts.contact.contacts + (size_t)motion->elastic;
    return SM_OUTPUTS_FIXED + (motion->wanted ? moving : 0);
}

sm_status sm_component_slow_outputs(const sm_component *c, double *outputs) {
    if (!c || !outputs) return SM_BAD_ARGUMENT;
    double computed[SM_UNKNOWNS];
    const double *rate = c->rate_known ? c->rate : computed;
    if (!c->rate_known) SM_TRY(rate_at(c, &c->inputs, c->slow.amplitude, computed));
    if (!sm_all_finite(rate, SM_UNKNOWNS)) return SM_NOT_FINITE;
    outputs[0] = c->slow.time.value;
    memcpy(outputs + 1, c->slow.amplitude, sizeof c->slow.amplitude);
    outputs[5] = c->slow.angle[0].value;
    outputs[6] = c->slow.angle[1].value;
    outputs[7] = rate[SM_PUT_IN];
    outputs[8] = rate[SM_DISSIPATED];
    outputs[9] = c->slow.energy.value;
    return SM_OK;
}

sm_status sm_component_motion(sm_component *c, int elastic, double *motion) {
    if (!c || !motion || !c->contacts.motion.wanted) return SM_BAD_ARGUMENT;
    return sm_contact_output_read(&c->contacts, &c->flow, &c->inputs, c->slow.amplitude, elastic,
                                  motion);
}

sm_status sm_component_outputs(sm_component *c, double *outputs) {
    SM_TRY(sm_component_slow_outputs(c, outputs));
    return c->contacts.motion.wanted ? sm_component_motion(c, 1, outputs + SM_OUTPUTS_FIXED)
                                     : SM_OK;
}

sm_status sm_component_recent_motion(sm_component *c, const sm_inputs *inputs,
                                     const double *amplitude, const double *rate, int smooth,
                                     double *motion) {
    if (!c || !inputs || !amplitude || !rate || !motion) return SM_BAD_ARGUMENT;
    if (!c->contacts.motion.wanted) return SM_BAD_ARGUMENT;
    const size_t count = 2 * (size_t)c->flow.table.modes;
    if (!sm_all_finite(amplitude, count) || !sm_all_finite(rate, count)) return SM_NOT_FINITE;
    SM_TRY(check_inputs(c, inputs));
    const sm_detail detail = smooth ? SM_UNHALVED : SM_TO_BE_READ;
    const sm_slow_point at = {amplitude, inputs};
    return sm_contact_output_recent(&c->contacts, &c->flow, &at, rate, detail, motion);
}

/* The state without its contacts. */
typedef struct {
    sm_slow_state slow;
    sm_inputs inputs;
} own_state;

#define OWN_DOUBLES SM_DOUBLES_IN(own_state)

size_t sm_component_state_count(const sm_component *c) {
    return c ? OWN_DOUBLES + sm_contact_output_state_count(&c->contacts) : 0;
}

sm_status sm_component_get_state(const sm_component *c, double *state) {
    if (!c || !state) return SM_BAD_ARGUMENT;
    const own_state own = {c->slow, c->inputs};
    memcpy(state, &own, sizeof own);
    sm_contact_output_get_state(&c->contacts, state + OWN_DOUBLES);
    return SM_OK;
}

sm_status sm_component_set_state(sm_component *c, const double *state) {
    if (!c || !state) return SM_BAD_ARGUMENT;
    if (!sm_all_finite(state, sm_component_state_count(c))) return SM_NOT_FINITE;
    own_state own;
    memcpy(&own, state, sizeof own);
    SM_TRY(check_inputs(c, &own.inputs));
    SM_TRY(sm_contact_output_check_state(&c->contacts, state + OWN_DOUBLES));
    double rate[SM_UNKNOWNS];
    SM_TRY(rate_at(c, &own.inputs, own.slow.amplitude, rate));
    c->slow = own.slow;
    c->inputs = own.inputs;
    c->rate_known = 0;
    sm_contact_output_set_state(&c->contacts, state + OWN_DOUBLES);
    return SM_OK;
}

void sm_component_work(const sm_component *c, uint64_t *accepted, uint64_t *rejected) {
    if (accepted) *accepted = c ? c->accepted : 0;
    if (rejected) *rejected = c ? c->rejected : 0;
}

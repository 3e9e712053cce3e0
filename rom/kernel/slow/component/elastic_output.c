/* The elastic displacements of a component, which sm_motion defines: the motion of the modes, of the
 * contacts and of the quasi-static response to the forces, and the response of the modes to the
 * harmonics of the contacts. contact_output.c and component.c call it. */
#include "base/check.h"
#include "slow/component/contact_output.h"


/* Checks an array with `per_node` values at each node. */
static sm_status check_values(const double *values, size_t nodes, size_t per_node) {
    if (per_node == 0) return SM_OK;
    if (!values || !sm_fits(nodes, per_node * sizeof(double))) return SM_BAD_ARGUMENT;
    return sm_all_finite(values, nodes * per_node) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_motion_check(const sm_motion *motion, const sm_contact *contact,
                          const sm_table *table) {
    if (!motion->wanted) return SM_OK;
    if (motion->elastic < 0 || motion->elastic > SM_MOST_OUTPUTS) return SM_BAD_ARGUMENT;
    if (motion->steps_per_period < SM_MIN_STEPS || motion->steps_per_period > SM_MOST)
        return SM_BAD_ARGUMENT;
    const size_t elastic = (size_t)motion->elastic, n = (size_t)contact->contacts;
    const size_t modes = (size_t)contact->modes;
    const size_t nodes = (size_t)table->count_a * (size_t)table->count_b;
    SM_TRY(sm_orders_check(motion->orders_count, motion->orders));
    const size_t pairs = 2 * (size_t)motion->orders_count;
    SM_TRY(check_values(motion->modes_out, elastic, 2 * modes));
    SM_TRY(check_values(motion->forces_out, elastic, 2 * modes));
    SM_TRY(check_values(motion->contacts_out, elastic, n));
    SM_TRY(check_values(motion->reaction, nodes, pairs * n));
    SM_TRY(check_values(motion->response, nodes, pairs * elastic));
    return sm_check_positive(motion->memory_periods);
}

void sm_add_shift(const sm_slow_flow *flow, const sm_inputs *in, double *amplitude, double *rate) {
    for (int j = 0; j < flow->table.modes; j++) {
        const sm_complex shift = sm_cmul(sm_pair(flow->off_resonance[j]), sm_unit(in->phase[j]));
        const sm_complex shifted = sm_cscale(shift, in->force[j]);
        const sm_complex growth =
            sm_cmul(shift, sm_cx(in->force_rate[j], in->phase_rate[j] * in->force[j]));
        amplitude[2 * j] += shifted.re;
        amplitude[2 * j + 1] += shifted.im;
        rate[2 * j] += growth.re;
        rate[2 * j + 1] += growth.im;
    }
}

/* Returns the coordinate that moves the structure at a contact DOF: x_c, or the force deficit of an
 * elastic contact. */
static double source_of(const sm_contact_output *out, size_t i, double x_c, double f_c) {
    return out->contact.law == SM_ELASTIC ? out->contact.elastic->reference[i] * x_c - f_c : x_c;
}

void sm_elastic_output(const sm_contact_output *out, const sm_slow_flow *flow,
                       const sm_inputs *inputs, const double *y, const double *contact, double *x) {
    const size_t n = (size_t)out->contact.contacts, modes = (size_t)out->contact.modes;
    const size_t elastic = (size_t)out->motion.elastic;
    double amplitude[2 * SM_MODES] = {0.0}, rate[2 * SM_MODES] = {0.0};
    sm_complex carrier[SM_MODES] = {{1.0, 0.0}, {1.0, 0.0}}, q[SM_MODES], force[SM_MODES];
    for (size_t j = 0; j < modes; j++) {
        carrier[j] = sm_unit(inputs->angle[j]);
        q[j] = sm_cscale(sm_cmul(sm_pair(y + 2 * j), carrier[j]), 2.0);
        const sm_complex phasor = sm_cmul(sm_unit(inputs->phase[j]), carrier[j]);
        force[j] = sm_cscale(phasor, 2.0 * inputs->force[j]);
    }
    for (size_t k = 0; k < elastic; k++) {
        x[k] = 0.0;
        for (size_t j = 0; j < modes; j++) {
            const size_t at = 2 * (k * modes + j);
            x[k] += sm_cmul(sm_pair(out->motion.modes_out + at), q[j]).re
                    + sm_cmul(sm_pair(out->motion.forces_out + at), force[j]).re;
        }
        for (size_t i = 0; i < n; i++)
            x[k] += out->motion.contacts_out[k * n + i]
                    * source_of(out, i, contact[i], contact[2 * n + i]);
    }
    if (out->response.orders_count == 0) return;
    memcpy(amplitude, y, 2 * modes * sizeof *y);
    sm_add_shift(flow, inputs, amplitude, rate);
    const sm_response_point point =
        sm_response_point_at(flow, inputs->frequency, inputs->limit_scale, amplitude);
    sm_response_add_sums(&point, out->response.orders_count, out->response.orders, elastic,
                         out->motion.response, carrier, x);
}

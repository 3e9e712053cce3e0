#include "slow/component/contact_output.h"

#include "base/check.h"
#include "base/cnumber.h"
#include "base/exact_sum.h"

static size_t node_count(const sm_table *table) {
    return (size_t)table->count_a * (size_t)table->count_b;
}

static sm_status check_values(const double *values, size_t nodes, size_t per_node) {
    if (per_node == 0) return SM_OK;
    if (!values || !sm_fits(nodes, per_node * sizeof(double))) return SM_BAD_ARGUMENT;
    return sm_all_finite(values, nodes * per_node) ? SM_OK : SM_NOT_FINITE;
}

sm_status sm_motion_check(const sm_motion *motion, const sm_contact *contact,
                          const sm_table *table) {
    if (!motion->wanted) return SM_OK;
    if (motion->elastic < 0 || motion->elastic > 1000000) return SM_BAD_ARGUMENT;
    if (motion->steps_per_period < 4 || motion->steps_per_period > 65536) return SM_BAD_ARGUMENT;
    const size_t elastic = (size_t)motion->elastic, n = (size_t)contact->contacts;
    const size_t modes = (size_t)contact->modes, nodes = node_count(table);
    sm_status status = sm_orders_check(motion->orders_count, motion->orders);
    if (status != SM_OK) return status;
    const size_t pairs = 2 * (size_t)motion->orders_count;
    status = check_values(motion->modes_out, elastic, 2 * modes);
    if (status == SM_OK) status = check_values(motion->forces_out, elastic, 2 * modes);
    if (status == SM_OK) status = check_values(motion->contacts_out, elastic, n);
    if (status == SM_OK) status = check_values(motion->reaction, nodes, pairs * n);
    if (status == SM_OK) status = check_values(motion->response, nodes, pairs * elastic);
    return status == SM_OK ? sm_check_positive(motion->memory_periods) : status;
}

void sm_contact_output_place(sm_contact_output *out, const sm_motion *motion,
                             const sm_contact *contact, sm_block *block) {
    const size_t n = (size_t)contact->contacts;
    const int32_t orders = motion->wanted ? motion->orders_count : 0;
    out->motion = *motion;
    out->contact = *contact;
    out->response = (sm_modal_response){.orders_count = orders, .orders = motion->orders};
    out->contact.response = &out->response;
    if (contact->law != SM_ELASTIC) {
        out->limit = contact->limit;
        out->contact.limit = out->scaled_limit = sm_take(block, n);
    }
    sm_march_place(&out->march, &out->contact, orders, block);
    out->state = sm_take(block, sm_march_state_count(contact));
    out->before.state = sm_take(block, sm_march_state_count(contact));
    out->queue = (void *)sm_take(block, sm_doubles(sizeof *out->queue));
    out->before.queue = (void *)sm_take(block, sm_doubles(sizeof *out->queue));
    for (int k = 0; k < 2; k++) out->reaction[k] = sm_take(block, 2 * (size_t)orders * n);
}

static double slowest_period(const sm_contact_output *out, const sm_inputs *inputs) {
    double slowest = INFINITY;
    for (int j = 0; j < out->contact.modes; j++) slowest = fmin(slowest, inputs->frequency[j]);
    return SM_TWO_PI / slowest;
}

/* Seconds for which the contacts remember. */
static double memory_of(const sm_contact_output *out, const sm_inputs *inputs) {
    return out->motion.memory_periods * slowest_period(out, inputs);
}

static void find_reaction(sm_contact_output *out, const sm_slow_flow *flow,
                          const sm_inputs *inputs, const double *y, double *reaction) {
    const sm_response_point point = sm_response_point_at(flow, &out->instant, inputs, y);
    sm_response_coefficients(&point, out->motion.orders_count, out->motion.orders,
                             (size_t)out->contact.contacts, out->motion.reaction, reaction);
}

/* The reaction at both ends of a stretch; where one ends the next begins. */
static void find_reactions(sm_contact_output *out, const sm_slow_flow *flow,
                           const sm_stretch *stretch, const sm_inputs *end) {
    const int same =
        out->reaction_known
        && memcmp(&out->reaction_inputs, &stretch->inputs, offsetof(sm_inputs, angle)) == 0
        && memcmp(out->reaction_amplitude, stretch->y, sizeof out->reaction_amplitude) == 0;
    double *spare = out->reaction[0];
    out->reaction[0] = out->reaction[1];
    out->reaction[1] = spare;
    if (!same) find_reaction(out, flow, &stretch->inputs, stretch->y, out->reaction[0]);
    find_reaction(out, flow, end, stretch->y_end, out->reaction[1]);
    out->reaction_known = 1;
    out->reaction_inputs = *end;
    memcpy(out->reaction_amplitude, stretch->y_end, sizeof out->reaction_amplitude);
}

/* What acts on the contacts as an amplitude at the carrier: with the force that acts on them. */
static void add_off_resonance(const sm_slow_flow *flow, int j, sm_complex force,
                              double *amplitude) {
    const sm_complex off_resonance = sm_cmul(sm_pair(flow->off_resonance[j]), force);
    amplitude[2 * j] += off_resonance.re;
    amplitude[2 * j + 1] += off_resonance.im;
}

static sm_segment segment_of(const sm_slow_flow *flow, const sm_stretch *stretch,
                             const sm_inputs *end) {
    sm_segment g = {.duration = stretch->duration};
    const sm_inputs *start = &stretch->inputs;
    memcpy(g.amplitude_start, stretch->y, sizeof g.amplitude_start);
    memcpy(g.amplitude_end, stretch->y_end, sizeof g.amplitude_end);
    memcpy(g.rate_start, stretch->rate, sizeof g.rate_start);
    memcpy(g.rate_end, stretch->rate_end, sizeof g.rate_end);
    for (int j = 0; j < flow->table.modes; j++) {
        g.angle[j] = start->angle[j];
        g.frequency[j] = start->frequency[j];
        g.frequency_rate[j] = start->frequency_rate[j];
        if (flow->off_resonance[j][0] == 0.0 && flow->off_resonance[j][1] == 0.0) continue;
        const sm_complex from = sm_unit(start->phase[j]), to = sm_unit(end->phase[j]);
        const double growth = start->force_rate[j], phase_rate = start->phase_rate[j];
        add_off_resonance(flow, j, sm_cscale(from, start->force[j]), g.amplitude_start);
        add_off_resonance(flow, j, sm_cscale(to, end->force[j]), g.amplitude_end);
        add_off_resonance(flow, j, sm_cmul(from, sm_cx(growth, phase_rate * start->force[j])),
                          g.rate_start);
        add_off_resonance(flow, j, sm_cmul(to, sm_cx(growth, phase_rate * end->force[j])),
                          g.rate_end);
    }
    return g;
}

/* Marches over a stretch but for its first `from` seconds. */
static sm_status march(sm_contact_output *out, const sm_slow_flow *flow, const sm_stretch *stretch,
                       double from, sm_detail detail) {
    const double to = stretch->duration;
    const sm_inputs end = sm_inputs_after(&stretch->inputs, out->contact.modes, to);
    sm_segment g = segment_of(flow, stretch, &end);
    if (out->response.orders_count > 0) {
        find_reactions(out, flow, stretch, &end);
        g.reaction_start = out->reaction[0];
        g.reaction_end = out->reaction[1];
    }
    const double scale =
        stretch->inputs.limit_scale + stretch->inputs.limit_scale_rate * 0.5 * (from + to);
    if (out->contact.law == SM_ELASTIC)
        out->march.solver.scale = scale;
    else
        for (int i = 0; i < out->contact.contacts; i++)
            out->scaled_limit[i] = scale * out->limit[i];
    return sm_march_along(&out->march, &out->contact, &g, from, to, out->motion.steps_per_period,
                          detail);
}

void sm_contact_output_begin(sm_contact_output *out) {
    const sm_stretch_queue *queue = out->queue;
    out->before.first = queue->first;
    out->before.count = queue->count;
    out->before.whole = 0;
    out->before.end = queue->end;
    if (queue->count > 0) out->before.last = *sm_queue_at(queue, queue->count - 1);
}

void sm_contact_output_abandon(sm_contact_output *out) {
    sm_stretch_queue *queue = out->queue;
    if (out->before.whole) {
        *queue = *out->before.queue;
        memcpy(out->state, out->before.state, sm_march_state_count(&out->contact) * sizeof(double));
    }
    queue->first = out->before.first;
    queue->count = out->before.count;
    queue->end = out->before.end;
    if (queue->count > 0)
        queue->stretch[(queue->first + queue->count - 1) % SM_STRETCHES] = out->before.last;
}

/* The first stretch leaves the queue: marched, unless contacts do not remember it anyway. */
static sm_status take_first(sm_contact_output *out, const sm_slow_flow *flow) {
    const sm_stretch *first = sm_queue_at(out->queue, 0);
    const double later = sm_queue_duration(out->queue) - first->duration;
    if (later < memory_of(out, &out->queue->end)) {
        sm_march_start(&out->march, &out->contact, out->state);
        const sm_status status = march(out, flow, first, 0.0, SM_RESOLVED);
        if (status != SM_OK) return status;
        sm_march_read(&out->march, &out->contact, out->state);
    }
    sm_queue_drop_first(out->queue);
    return SM_OK;
}

sm_status sm_contact_output_add(sm_contact_output *out, const sm_slow_flow *flow,
                                const sm_stretch *stretch, const sm_inputs *end) {
    const double longest = 0.5 * slowest_period(out, &stretch->inputs);
    sm_stretch_queue *queue = out->queue;
    if (sm_queue_is_full(queue) && !sm_queue_continues(queue, stretch, longest)) {
        if (!out->before.whole) {
            *out->before.queue = *queue;
            memcpy(out->before.state, out->state,
                   sm_march_state_count(&out->contact) * sizeof(double));
            out->before.whole = 1;
        }
        const sm_status status = take_first(out, flow);
        if (status != SM_OK) return status;
    }
    sm_queue_add(queue, stretch, end, longest);
    return SM_OK;
}

void sm_contact_output_commit(sm_contact_output *out, const sm_slow_flow *flow) {
    /* Room for four stretches as the next step begins. One that cannot be marched stays: reading the
     * motion returns its status. */
    while (out->queue->count > SM_STRETCHES - 4 && take_first(out, flow) == SM_OK) continue;
}

/* Brings the state to the present. */
static sm_status march_all(sm_contact_output *out, const sm_slow_flow *flow) {
    sm_stretch_queue *queue = out->queue;
    if (queue->count == 0) return SM_OK;
    double skipped = sm_queue_duration(queue) - memory_of(out, &queue->end);
    sm_march_start(&out->march, &out->contact, out->state);
    for (int k = 0; k < queue->count; k++) {
        const sm_stretch *stretch = sm_queue_at(queue, k);
        if (skipped < stretch->duration) {
            const sm_detail detail = k + 1 < queue->count ? SM_RESOLVED : SM_TO_BE_READ;
            const sm_status status = march(out, flow, stretch, fmax(0.0, skipped), detail);
            if (status != SM_OK) return status;
        }
        skipped -= stretch->duration;
    }
    sm_march_read(&out->march, &out->contact, out->state);
    queue->count = 0;
    return SM_OK;
}

void sm_contact_output_reset(sm_contact_output *out) {
    memset(out->state, 0, sm_march_state_count(&out->contact) * sizeof(double));
    out->queue->count = 0;
}

size_t sm_contact_output_state_count(const sm_contact_output *out) {
    return sm_march_state_count(&out->contact) + SM_QUEUE_DOUBLES;
}

void sm_contact_output_get_state(const sm_contact_output *out, double *values) {
    const size_t count = sm_march_state_count(&out->contact);
    memcpy(values, out->state, count * sizeof(double));
    sm_queue_write(out->queue, values + count);
}

sm_status sm_contact_output_check_state(const sm_contact_output *out, const double *values) {
    return sm_queue_check(values + sm_march_state_count(&out->contact), out->contact.modes);
}

void sm_contact_output_set_state(sm_contact_output *out, const double *values) {
    const size_t count = sm_march_state_count(&out->contact);
    memcpy(out->state, values, count * sizeof(double));
    sm_queue_read(out->queue, values + count);
}

/* What moves the structure at a contact DOF where x_c and f_c (N_c) are: x_c, or the force that an
 * elastic contact falls short by. */
static double draw(const sm_contact_output *out, size_t i, const double *x_c, const double *f_c) {
    return out->contact.law == SM_ELASTIC ? out->contact.elastic->reference[i] * x_c[i] - f_c[i] : x_c[i];
}

/* x (elastic) where the contacts are at x_c, with forces behind. */
static void read_elastic(sm_contact_output *out, const sm_slow_flow *flow,
                         const sm_inputs *inputs, const double *y, const double *x_c, double *x) {
    const size_t n = (size_t)out->contact.contacts, modes = (size_t)out->contact.modes;
    const size_t elastic = (size_t)out->motion.elastic;
    sm_complex carrier[SM_MODES] = {{1.0, 0.0}, {1.0, 0.0}}, q[SM_MODES], force[SM_MODES];
    for (size_t j = 0; j < modes; j++) {
        carrier[j] = sm_unit(inputs->angle[j]);
        q[j] = sm_cscale(sm_cmul(sm_pair(y + 2 * j), carrier[j]), 2.0);
        force[j] = sm_cscale(sm_cmul(sm_unit(inputs->phase[j]), carrier[j]), 2.0 * inputs->force[j]);
    }
    for (size_t k = 0; k < elastic; k++) {
        x[k] = 0.0;
        for (size_t j = 0; j < modes; j++) {
            const double *shape = out->motion.modes_out + 2 * (k * modes + j);
            x[k] += shape[0] * q[j].re - shape[1] * q[j].im;
            const double *response = out->motion.forces_out + 2 * (k * modes + j);
            x[k] += response[0] * force[j].re - response[1] * force[j].im;
        }
        for (size_t i = 0; i < n; i++)
            x[k] += out->motion.contacts_out[k * n + i] * draw(out, i, x_c, x_c + 2 * n);
    }
    if (out->response.orders_count == 0) return;
    const sm_response_point point = sm_response_point_at(flow, &out->instant, inputs, y);
    sm_response_add_sums(&point, out->response.orders_count, out->response.orders, elastic,
                         out->motion.response, carrier, x);
}

sm_status sm_contact_output_read(sm_contact_output *out, const sm_slow_flow *flow,
                                 const sm_inputs *inputs, const double *y, int elastic,
                                 double *values) {
    const size_t count = 3 * (size_t)out->contact.contacts;
    const sm_status status = march_all(out, flow);
    if (status != SM_OK) return status;
    memcpy(values, out->state, count * sizeof(double));
    if (elastic && out->motion.elastic > 0)
        read_elastic(out, flow, inputs, y, values, values + count);
    return SM_OK;
}

/* The inputs without rates so fast that a frequency or limit would have been zero within the duration
 * before. */
static sm_inputs without_fast_rates(const sm_inputs *inputs, int modes, double duration) {
    sm_inputs slow = *inputs;
    for (int j = 0; j < modes; j++)
        if (fabs(duration * inputs->frequency_rate[j]) >= 0.5 * inputs->frequency[j])
            slow.frequency_rate[j] = 0.0;
    if (fabs(duration * inputs->limit_scale_rate) >= 0.5 * inputs->limit_scale)
        slow.limit_scale_rate = 0.0;
    return slow;
}

sm_status sm_contact_output_recent(sm_contact_output *out, const sm_slow_flow *flow,
                                   const sm_slow_point *at, const double *rate, sm_detail detail,
                                   double *values) {
    const sm_inputs *inputs = at->inputs;
    const double *y = at->amplitude;
    const int modes = out->contact.modes;
    const size_t count = (size_t)out->contact.contacts, bytes = count * sizeof(double);
    const double duration = memory_of(out, inputs);
    const sm_inputs end = without_fast_rates(inputs, modes, duration);
    sm_stretch past = {.duration = duration, .inputs = sm_inputs_after(&end, modes, -duration)};
    for (int k = 0; k < 2 * modes; k++) {
        past.y[k] = y[k] - duration * rate[k];
        past.y_end[k] = y[k];
        past.rate[k] = past.rate_end[k] = rate[k];
    }
    sm_march_start(&out->march, &out->contact, NULL);
    const sm_status status = march(out, flow, &past, 0.0, detail);
    if (status != SM_OK) return status;
    memcpy(values, out->march.x, bytes);
    memcpy(values + count, out->march.v, bytes);
    memcpy(values + 2 * count, out->march.force, bytes);
    if (out->motion.elastic > 0)
        read_elastic(out, flow, inputs, past.y_end, values, values + 3 * count);
    return SM_OK;
}

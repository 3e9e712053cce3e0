/* The contact motion of a component at its communication points. Contacts are integrated, eq. (12),
 * when they are read. Until then a queue stores the slow motion over the memory of the contacts, so
 * that motion which is not read costs little. The component (component.c) calls it. */
#include "slow/component/contact_output.h"

#include "base/check.h"
#include "base/exact_sum.h"

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
    out->state_before = sm_take(block, sm_march_state_count(contact));
    out->queue = (void *)sm_take(block, sm_doubles(sizeof *out->queue));
    out->queue_before = (void *)sm_take(block, sm_doubles(sizeof *out->queue));
    for (int k = 0; k < 2; k++) out->reaction[k] = sm_take(block, 2 * (size_t)orders * n);
}

/* Returns the duration of `count` periods of the slowest carrier [s]. */
static double periods(const sm_contact_output *out, const double *frequency, double count) {
    double slowest = INFINITY;
    for (int j = 0; j < out->contact.modes; j++) slowest = fmin(slowest, frequency[j]);
    return count * SM_TWO_PI / slowest;
}

/* Returns the stretch between inputs and unknowns at its start and at its end. */
static sm_stretch stretch_between(const sm_slow_flow *flow, double duration,
                                  const sm_inputs *begin, const sm_flow_point *from,
                                  const sm_inputs *end, const sm_flow_point *to) {
    sm_stretch stretch = {.segment = {.duration = duration},
                          .limit_scale = begin->limit_scale,
                          .limit_scale_rate = begin->limit_scale_rate};
    sm_segment *g = &stretch.segment;
    memcpy(g->amplitude_start, from->y, sizeof g->amplitude_start);
    memcpy(g->amplitude_end, to->y, sizeof g->amplitude_end);
    memcpy(g->rate_start, from->dy, sizeof g->rate_start);
    memcpy(g->rate_end, to->dy, sizeof g->rate_end);
    memcpy(g->angle, begin->angle, sizeof g->angle);
    memcpy(g->frequency, begin->frequency, sizeof g->frequency);
    memcpy(g->frequency_rate, begin->frequency_rate, sizeof g->frequency_rate);
    sm_add_shift(flow, begin, g->amplitude_start, g->rate_start);
    sm_add_shift(flow, end, g->amplitude_end, g->rate_end);
    return stretch;
}

/* Computes the frequencies and returns the limit scale at a time of a stretch. */
static double state_at(const sm_stretch *stretch, double elapsed, double *frequency) {
    const sm_segment *g = &stretch->segment;
    for (int j = 0; j < SM_MODES; j++)
        frequency[j] = g->frequency[j] + elapsed * g->frequency_rate[j];
    return stretch->limit_scale + elapsed * stretch->limit_scale_rate;
}

/* Computes the force of the modes on the contacts at a time of a stretch. */
static void find_reaction(const sm_contact_output *out, const sm_slow_flow *flow,
                          const sm_stretch *stretch, double elapsed, const double *amplitude,
                          double *reaction) {
    double frequency[SM_MODES];
    const double scale = state_at(stretch, elapsed, frequency);
    const sm_response_point point = sm_response_point_at(flow, frequency, scale, amplitude);
    sm_response_coefficients(&point, out->motion.orders_count, out->motion.orders,
                             (size_t)out->contact.contacts, out->motion.reaction, reaction);
}

/* Integrates the contacts over a stretch, without its first `from` seconds. The friction limits are
 * constant, with their value in the middle. */
static sm_status march(sm_contact_output *out, const sm_slow_flow *flow, const sm_stretch *stretch,
                       double from, sm_detail detail) {
    sm_segment g = stretch->segment;
    if (out->response.orders_count > 0) {
        find_reaction(out, flow, stretch, 0.0, g.amplitude_start, out->reaction[0]);
        find_reaction(out, flow, stretch, g.duration, g.amplitude_end, out->reaction[1]);
        g.reaction_start = out->reaction[0];
        g.reaction_end = out->reaction[1];
    }
    double frequency[SM_MODES];
    const double scale = state_at(stretch, 0.5 * (from + g.duration), frequency);
    if (out->contact.law == SM_ELASTIC)
        out->march.solver.scale = scale;
    else
        for (int i = 0; i < out->contact.contacts; i++)
            out->scaled_limit[i] = scale * out->limit[i];
    return sm_march_along(&out->march, &out->contact, &g, from, g.duration,
                          out->motion.steps_per_period, detail);
}

void sm_contact_output_save(sm_contact_output *out, int back) {
    const size_t bytes = sm_march_state_count(&out->contact) * sizeof(double);
    memcpy(back ? out->state : out->state_before, back ? out->state_before : out->state, bytes);
    sm_queue_copy(back ? out->queue_before : out->queue, back ? out->queue : out->queue_before);
}

/* Returns the duration at the start of the queue without effect on the contacts at its end [s]. */
static double forgotten(const sm_contact_output *out) {
    const sm_stretch *last = sm_queue_at(out->queue, out->queue->count - 1);
    double frequency[SM_MODES];
    (void)state_at(last, last->segment.duration, frequency);
    return sm_queue_duration(out->queue) - periods(out, frequency, out->motion.memory_periods);
}

/* Removes the first stretch from the queue. The contacts are integrated over it unless it is older
 * than their memory. */
static sm_status take_first(sm_contact_output *out, const sm_slow_flow *flow) {
    const sm_stretch *first = sm_queue_at(out->queue, 0);
    if (forgotten(out) < first->segment.duration) {
        sm_march_start(&out->march, &out->contact, out->state);
        SM_TRY(march(out, flow, first, 0.0, SM_RESOLVED));
        sm_march_read(&out->march, &out->contact, out->state);
    }
    sm_queue_drop_first(out->queue);
    return SM_OK;
}

sm_status sm_contact_output_add(sm_contact_output *out, const sm_time_step *step,
                                const sm_inputs *begin, const sm_flow_point *from,
                                const sm_flow_point *to) {
    const sm_stretch stretch =
        stretch_between(step->flow, step->h, begin, from, &step->end, to);
    const double longest = periods(out, begin->frequency, 0.5);
    if (sm_queue_add(out->queue, &stretch, longest)) return SM_OK;
    SM_TRY(take_first(out, step->flow));
    (void)sm_queue_add(out->queue, &stretch, longest);
    return SM_OK;
}

/* Integrates the contacts over the queue, up to the present. */
static sm_status march_all(sm_contact_output *out, const sm_slow_flow *flow) {
    sm_stretch_queue *queue = out->queue;
    if (queue->count == 0) return SM_OK;
    double skipped = forgotten(out);
    sm_march_start(&out->march, &out->contact, out->state);
    for (int k = 0; k < queue->count; k++) {
        const sm_stretch *stretch = sm_queue_at(queue, k);
        if (skipped < stretch->segment.duration) {
            const sm_detail detail = k + 1 < queue->count ? SM_RESOLVED : SM_TO_BE_READ;
            SM_TRY(march(out, flow, stretch, fmax(0.0, skipped), detail));
        }
        skipped -= stretch->segment.duration;
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

sm_status sm_contact_output_read(sm_contact_output *out, const sm_slow_flow *flow,
                                 const sm_inputs *inputs, const double *y, int elastic,
                                 double *values) {
    const size_t count = 3 * (size_t)out->contact.contacts;
    SM_TRY(march_all(out, flow));
    memcpy(values, out->state, count * sizeof(double));
    if (elastic && out->motion.elastic > 0)
        sm_elastic_output(out, flow, inputs, y, values, values + count);
    return SM_OK;
}

/* Returns the inputs without rates so fast that a frequency or limit would have been 0 within the
 * duration before. */
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
    const int modes = out->contact.modes;
    const double duration = periods(out, at->inputs->frequency, out->motion.memory_periods);
    const sm_inputs end = without_fast_rates(at->inputs, modes, duration);
    const sm_inputs begin = sm_inputs_after(&end, modes, -duration);
    sm_flow_point from = {.y = {0.0}}, to = {.y = {0.0}};
    for (int k = 0; k < 2 * modes; k++) {
        from.y[k] = at->amplitude[k] - duration * rate[k];
        to.y[k] = at->amplitude[k];
        from.dy[k] = to.dy[k] = rate[k];
    }
    const sm_stretch past = stretch_between(flow, duration, &begin, &from, &end, &to);
    sm_march_start(&out->march, &out->contact, NULL);
    SM_TRY(march(out, flow, &past, 0.0, detail));
    const size_t n = (size_t)out->contact.contacts;
    const double *const rows[] = {out->march.x, out->march.v, out->march.force};
    for (size_t k = 0; k < 3; k++) memcpy(values + k * n, rows[k], n * sizeof *values);
    if (out->motion.elastic > 0)
        sm_elastic_output(out, flow, at->inputs, to.y, values, values + 3 * n);
    return SM_OK;
}

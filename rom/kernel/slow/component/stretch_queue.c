/* A queue of slow motion over which the contacts have not been integrated yet.
 *
 * Contact motion is integrated when it is read (contact_output.c). Until then each internal step of
 * the slow flow adds a stretch here; short steps are joined as long as one cubic describes them.
 */
#include "slow/component/stretch_queue.h"

#include <string.h>

#include "base/check.h"
#include "slow/motion/segment.h"

#define WIDTH SM_DOUBLES_IN(sm_stretch)

#define EQUAL(a, b) (memcmp((a), (b), sizeof(a)) == 0)

/* Returns whether two numbers are equal except for rounding of their linear change. */
static int is_near(double a, double b) { return fabs(a - b) <= SM_ROUNDING_TOLERANCE * fabs(b); }

/* Returns whether amplitudes, frequencies and limits are smooth from one stretch to the next. */
static int continues(const sm_stretch *last, const sm_stretch *next) {
    const sm_segment *a = &last->segment, *b = &next->segment;
    for (int j = 0; j < SM_MODES; j++) {
        const double end = a->frequency[j] + a->frequency_rate[j] * a->duration;
        if (!is_near(end, b->frequency[j])) return 0;
    }
    return EQUAL(a->amplitude_end, b->amplitude_start) && EQUAL(a->rate_end, b->rate_start)
           && EQUAL(a->frequency_rate, b->frequency_rate)
           && is_near(last->limit_scale + last->limit_scale_rate * a->duration, next->limit_scale)
           && last->limit_scale_rate == next->limit_scale_rate;
}

int sm_queue_add(sm_stretch_queue *queue, const sm_stretch *stretch, double longest) {
    const sm_segment *added = &stretch->segment;
    if (queue->count > 0) {
        sm_stretch *last = &queue->stretch[(queue->first + queue->count - 1) % SM_STRETCHES];
        sm_segment *g = &last->segment;
        if (g->duration + added->duration <= longest && continues(last, stretch)) {
            g->duration += added->duration;
            memcpy(g->amplitude_end, added->amplitude_end, sizeof g->amplitude_end);
            memcpy(g->rate_end, added->rate_end, sizeof g->rate_end);
            return 1;
        }
    }
    if (queue->count == SM_STRETCHES) return 0;
    queue->stretch[(queue->first + queue->count++) % SM_STRETCHES] = *stretch;
    return 1;
}

void sm_queue_drop_first(sm_stretch_queue *queue) {
    queue->first = (queue->first + 1) % SM_STRETCHES;
    queue->count--;
}

void sm_queue_copy(const sm_stretch_queue *from, sm_stretch_queue *to) {
    to->first = 0;
    to->count = from->count;
    for (int k = 0; k < from->count; k++) to->stretch[k] = *sm_queue_at(from, k);
}

double sm_queue_duration(const sm_stretch_queue *queue) {
    double duration = 0.0;
    for (int k = 0; k < queue->count; k++) duration += sm_queue_at(queue, k)->segment.duration;
    return duration;
}

void sm_queue_write(const sm_stretch_queue *queue, double *values) {
    memset(values, 0, SM_QUEUE_DOUBLES * sizeof *values);
    values[0] = queue->count;
    for (int k = 0; k < queue->count; k++)
        memcpy(values + 1 + (size_t)k * WIDTH, sm_queue_at(queue, k), sizeof(sm_stretch));
}

void sm_queue_read(sm_stretch_queue *queue, const double *values) {
    queue->first = 0;
    queue->count = (int32_t)values[0];
    memcpy(queue->stretch, values + 1, sizeof queue->stretch);
}

/* Returns whether a linear function of time is positive from 0 to the duration. */
static int stays_positive(double value, double rate, double duration) {
    return value > 0.0 && value + rate * duration > 0.0;
}

sm_status sm_queue_check(const double *values, int modes) {
    sm_stretch_queue queue;
    if (!(values[0] >= 0.0 && values[0] <= SM_STRETCHES)) return SM_BAD_ARGUMENT;
    sm_queue_read(&queue, values);
    for (int k = 0; k < queue.count; k++) {
        const sm_stretch *s = &queue.stretch[k];
        const sm_segment *g = &s->segment;
        SM_TRY(sm_segments_check(1, g, modes));
        int positive = stays_positive(s->limit_scale, s->limit_scale_rate, g->duration);
        for (int j = 0; j < modes; j++)
            positive &= stays_positive(g->frequency[j], g->frequency_rate[j], g->duration);
        if (!positive) return SM_BAD_ARGUMENT;
    }
    return SM_OK;
}

#include "slow/component/stretch_queue.h"

#include <stddef.h>
#include <string.h>

#include "base/check.h"
#include "slow/instant.h"

#define WIDTH (sizeof(sm_stretch) / sizeof(double))

static sm_stretch *last_of(sm_stretch_queue *queue) {
    return &queue->stretch[(queue->first + queue->count - 1) % SM_STRETCHES];
}

int sm_queue_continues(const sm_stretch_queue *queue, const sm_stretch *stretch, double longest) {
    if (queue->count == 0) return 0;
    const sm_stretch *last = sm_queue_at(queue, queue->count - 1);
    return last->duration + stretch->duration <= longest
           && memcmp(&queue->end, &stretch->inputs, offsetof(sm_inputs, angle)) == 0
           && memcmp(last->y_end, stretch->y, sizeof last->y_end) == 0;
}

void sm_queue_add(sm_stretch_queue *queue, const sm_stretch *stretch, const sm_inputs *end,
                  double longest) {
    if (sm_queue_continues(queue, stretch, longest)) {
        sm_stretch *last = last_of(queue);
        last->duration += stretch->duration;
        memcpy(last->y_end, stretch->y_end, sizeof last->y_end);
        memcpy(last->rate_end, stretch->rate_end, sizeof last->rate_end);
    } else {
        queue->count++;
        *last_of(queue) = *stretch;
    }
    queue->end = *end;
}

void sm_queue_drop_first(sm_stretch_queue *queue) {
    queue->first = (queue->first + 1) % SM_STRETCHES;
    queue->count--;
}

double sm_queue_duration(const sm_stretch_queue *queue) {
    double duration = 0.0;
    for (int k = 0; k < queue->count; k++) duration += sm_queue_at(queue, k)->duration;
    return duration;
}

void sm_queue_write(const sm_stretch_queue *queue, double *values) {
    memset(values, 0, SM_QUEUE_DOUBLES * sizeof *values);
    values[0] = queue->count;
    memcpy(values + 1, &queue->end, sizeof queue->end);
    values += 1 + sizeof queue->end / sizeof *values;
    for (int k = 0; k < queue->count; k++)
        memcpy(values + (size_t)k * WIDTH, sm_queue_at(queue, k), sizeof(sm_stretch));
}

void sm_queue_read(sm_stretch_queue *queue, const double *values) {
    queue->first = 0;
    queue->count = (int)values[0];
    memcpy(&queue->end, values + 1, sizeof queue->end);
    memcpy(queue->stretch, values + 1 + sizeof queue->end / sizeof *values, sizeof queue->stretch);
}

sm_status sm_queue_check(const double *values, int modes) {
    sm_stretch_queue queue;
    if (!(values[0] >= 0.0 && values[0] <= SM_STRETCHES)) return SM_BAD_ARGUMENT;
    sm_queue_read(&queue, values);
    for (int k = 0; k < queue.count; k++) {
        const sm_inputs end =
            sm_inputs_after(&queue.stretch[k].inputs, modes, queue.stretch[k].duration);
        sm_status status = sm_check_positive(queue.stretch[k].duration);
        if (status == SM_OK) status = sm_inputs_check(&queue.stretch[k].inputs, modes);
        if (status == SM_OK) status = sm_inputs_check(&end, modes);
        if (status != SM_OK) return status;
    }
    return SM_OK;
}

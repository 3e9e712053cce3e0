/* A queue of slow motion over which the contacts have not been integrated yet, eq. (12). */
#ifndef SLIPMODE_STRETCH_QUEUE_H
#define SLIPMODE_STRETCH_QUEUE_H

#include "base/block.h"
#include "slipmode.h"

/* Stretches in a queue. Two successive stretches that were not joined are longer than half a
 * period, so that a full queue has at least 10 periods unless inputs are discontinuous. */
#define SM_STRETCHES 40

/* Slow motion between two times. Part of the state of a component, as doubles. */
typedef struct {
    sm_segment segment; /* without reactions: they are NULL in a queue */
    double limit_scale, limit_scale_rate; /* at the start [-], [1/s] */
} sm_stretch;

/* A ring of successive stretches. */
typedef struct {
    int32_t first, count;
    sm_stretch stretch[SM_STRETCHES];
} sm_stretch_queue;

/* Returns stretch k of the queue. */
static inline const sm_stretch *sm_queue_at(const sm_stretch_queue *queue, int k) {
    return &queue->stretch[(queue->first + k) % SM_STRETCHES];
}

/* Joins a stretch to the last one if it continues it smoothly and both together are at most
 * `longest` seconds long; otherwise adds it. Returns 0 if the queue is too full to add it. */
int sm_queue_add(sm_stretch_queue *queue, const sm_stretch *stretch, double longest);
/* Removes the first stretch. */
void sm_queue_drop_first(sm_stretch_queue *queue);
/* Copies the stretches of a queue in use. */
void sm_queue_copy(const sm_stretch_queue *from, sm_stretch_queue *to);
/* Returns the sum of the durations [s]. */
double sm_queue_duration(const sm_stretch_queue *queue);

/* Doubles of a queue: the number of stretches, and the stretches in order. */
#define SM_QUEUE_DOUBLES (1 + SM_STRETCHES * SM_DOUBLES_IN(sm_stretch))
/* Writes a queue as doubles. */
void sm_queue_write(const sm_stretch_queue *queue, double *values);
/* Reads a queue from doubles. */
void sm_queue_read(sm_stretch_queue *queue, const double *values);
/* Checks the doubles of a queue: finite segments, positive frequencies and limits. */
sm_status sm_queue_check(const double *values, int modes);

#endif

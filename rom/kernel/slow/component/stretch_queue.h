/* The slow motion that contacts have yet to be marched through, if anybody asks for them. */
#ifndef SLIPMODE_STRETCH_QUEUE_H
#define SLIPMODE_STRETCH_QUEUE_H

#include "slipmode.h"

#define SM_STRETCHES 40 /* room, for the memory of the contacts in halves of a period and more */

/* Between two instants of a step: inputs at its start with their angles, amplitudes and their
 * rates. Doubles alone: it is part of a component's state. */
typedef struct {
    double duration;
    sm_inputs inputs;
    double y[2 * SM_MODES], rate[2 * SM_MODES];
    double y_end[2 * SM_MODES], rate_end[2 * SM_MODES];
} sm_stretch;

typedef struct {
    int first, count;
    sm_stretch stretch[SM_STRETCHES]; /* in a ring */
    sm_inputs end;                    /* inputs at the end of the last one */
} sm_stretch_queue;

static inline const sm_stretch *sm_queue_at(const sm_stretch_queue *queue, int k) {
    return &queue->stretch[(queue->first + k) % SM_STRETCHES];
}

static inline int sm_queue_is_full(const sm_stretch_queue *queue) {
    return queue->count == SM_STRETCHES;
}

/* Adds a stretch that ends with inputs `end`. It becomes part of the last one where it goes on as
 * that does and both are not longer than `longest`; the queue is not full otherwise. */
void sm_queue_add(sm_stretch_queue *queue, const sm_stretch *stretch, const sm_inputs *end,
                  double longest);
void sm_queue_drop_first(sm_stretch_queue *queue);
/* Whether sm_queue_add would make it part of the last one. */
int sm_queue_continues(const sm_stretch_queue *queue, const sm_stretch *stretch, double longest);
double sm_queue_duration(const sm_stretch_queue *queue);

/* As doubles, in order. */
#define SM_QUEUE_DOUBLES \
    (1 + (SM_STRETCHES * sizeof(sm_stretch) + sizeof(sm_inputs)) / sizeof(double))
void sm_queue_write(const sm_stretch_queue *queue, double *values);
sm_status sm_queue_check(const double *values, int modes);
void sm_queue_read(sm_stretch_queue *queue, const double *values);

#endif

/* A tone in time: its state, its work arrays, and the rates of its amplitudes. */
#ifndef SLIPMODE_TONE_FLOW_H
#define SLIPMODE_TONE_FLOW_H

#include "base/block.h"
#include "base/exact_sum.h"
#include "slipmode.h"

#define SM_TONE_STAGES 4
#define SM_TONE_WEIGHTS 7 /* per mode, see tone_march.c */

/* The state besides its vectors. */
typedef struct {
    sm_exact_sum time, angle; /* [s]; theta in [0, 2 pi) [rad] */
    sm_exact_sum energy;      /* dissipated at the contacts [J] */
    double step;              /* next internal step, 0: not chosen yet [s] */
    double band;              /* of frequency, in which the fast modes respond as in its middle */
    double power;             /* dissipated at the contacts [W] */
    sm_inputs inputs;
} sm_tone_state;

#define SM_TONE_SCALARS (sizeof(sm_tone_state) / sizeof(double))

struct sm_tone_flow {
    sm_tone tone;
    double tolerance;
    uint64_t accepted, rejected;
    size_t state_count;
    double *state;                 /* sm_tone_state, then the vectors down to `drive` */
    sm_tone_state *now;            /* its beginning */
    double *amplitude;             /* (2, M) */
    double *deficit, *drive;       /* (2, n) */
    double *before;                /* (state_count) */
    double *others;                /* (n + 1, 2, n) how deficits and G move the contacts, besides
                                      the slow modes, in the present band */
    double *given;                 /* (2, n) */
    double *next, *end;            /* (2, M) */
    double *stage[SM_TONE_STAGES]; /* (2, M) b G + l y; the first at present, part of the state */
    double *weight;                /* (SM_TONE_WEIGHTS, 2, M) */
    double *fast;                  /* (2, fast modes) */
    double *output;                /* (2, K) */
};

/* to (2, rows) += matrix x, with `columns` columns of `rows` complex numbers. */
void sm_tone_add_product(int rows, int columns, const double *matrix, const double *x, double *to);
/* Steady fast modes (2, M) from their rates, at a frequency. */
void sm_tone_steady(const sm_tone_modes *modes, double frequency, double *rates);

/* The band of a frequency. */
double sm_tone_band(const sm_tone *tone, double frequency);
/* Frequency between a band and the next one, `way` 1 or -1. */
double sm_tone_edge(const sm_tone *tone, double band, int way);
/* Lets the fast modes respond as in the middle of a band. */
void sm_tone_enter_band(sm_tone_flow *flow, double band);

/* b G + l y, (2, M), `elapsed` seconds after the inputs' start. The deficits are found from the
 * last ones; the dissipated power follows. */
sm_status sm_tone_load(sm_tone_flow *flow, double elapsed, const double *amplitude, double *load);

/* Integrates from one time after the inputs' start to another [s], within a band. The load is that
 * at the start, and at the end. */
sm_status sm_tone_march(sm_tone_flow *flow, double from, double to);

#endif

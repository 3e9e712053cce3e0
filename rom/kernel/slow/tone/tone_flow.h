/* Several modes on one or two tones (docs/theory.md, "Several modes on one tone"): state, work arrays, and
 * the functions that the files of this folder share. The symbols are defined at
 * sm_tone: amplitudes a, force deficits y, drives c, poles s, complex force G. */
#ifndef SLIPMODE_TONE_FLOW_H
#define SLIPMODE_TONE_FLOW_H

#include "base/block.h"
#include "base/exact_sum.h"
#include "slipmode.h"

#define SM_TONE_STAGES 4
#define SM_TONE_WEIGHTS 7 /* per mode, see tone_march.c */

/* The scalars of the state. */
typedef struct {
    sm_exact_sum time, energy;    /* [s]; dissipated at the contacts [J] */
    sm_exact_sum angle[SM_MODES]; /* theta of the tones in [0, 2 pi) [rad] */
    double band[SM_MODES];        /* index of the frequency band of each tone: fast modes respond
                                     as in its middle */
    double step;                  /* next internal step, 0: not chosen yet [s] */
    double power;                 /* dissipated at the contacts [W] */
    sm_inputs inputs;
} sm_tone_state;

#define SM_TONE_SCALARS SM_DOUBLES_IN(sm_tone_state)

/* Arrays of amplitudes contain (2, M) for each tone, M its slow modes, one tone after the other.
 * T is the number of tones. */
struct sm_tone_flow {
    sm_tone tone;
    double tolerance;
    size_t amplitudes;             /* length of an array of amplitudes */
    uint64_t accepted, rejected;
    size_t state_count;
    double *state;                 /* sm_tone_state, then the vectors up to `drive` */
    sm_tone_state *now;            /* the scalars at the start of `state` */
    double *amplitude;             /* slow modes */
    double *deficit, *drive;       /* (T, 2, n) y and c of the contacts */
    double *before;                /* (state_count) state before the present call */
    double *others;                /* (T, n + 1, 2, n) displacement of the contacts by y and by G,
                                      without the slow modes, in the present bands */
    double *given;                 /* (T, 2, n) displacement of the contacts by a and G */
    double *next, *end;            /* amplitudes and load at the end of a step */
    double *stage[SM_TONE_STAGES]; /* loads b G + l y of the stages; the first one, at present, is
                                      part of the state */
    double *weight;                /* (SM_TONE_WEIGHTS, amplitudes) weights of a step, by mode */
    double *fast;                  /* (2, fast modes) of one tone */
    double *output;                /* (2, K) for each tone */
};

/* Returns the number of complex outputs K at carrier t; 0 without outputs. */
static inline size_t sm_tone_rows(const sm_tone *tone, int t) {
    const sm_tone_carrier *carrier = &tone->carrier[t];
    return carrier->output ? (size_t)carrier->amplitudes + (size_t)tone->elastic + 1 : 0;
}

/* Checks a tone. */
sm_status sm_tone_check(const sm_tone *tone, double tolerance);

/* Adds matrix x to `to` (2, rows); the complex matrix has `columns` columns of `rows` numbers. */
void sm_tone_add_product(int rows, int columns, const double *matrix, const double *x, double *to);
/* Replaces the rates of modes (2, M) by their steady amplitudes at a frequency [rad/s]. */
void sm_tone_steady(const sm_tone_modes *modes, double frequency, double *rates);

/* Returns the index of the band of a frequency of tone t. */
double sm_tone_band(const sm_tone *tone, int t, double frequency);
/* Returns the frequency between a band and the next higher (way = 1) or lower one (way = -1). */
double sm_tone_edge(const sm_tone *tone, int t, double band, int way);
/* Computes the response of the fast modes to tone t in the middle of a band. */
void sm_tone_enter_band(sm_tone_flow *flow, int t, double band);

/* Computes the load b G + l y of the slow modes `elapsed` seconds after the inputs' start, and the
 * dissipated power. The search for the deficits y starts from the last ones. */
sm_status sm_tone_load(sm_tone_flow *flow, double elapsed, const double *amplitude, double *load);

/* Integrates from one time after the inputs' start to another [s], within a band. stage[0] is the
 * load at the start, and at the end. */
sm_status sm_tone_march(sm_tone_flow *flow, double from, double to);

#endif

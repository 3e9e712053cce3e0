/* Friction terms from the friction table, eq. (20), with S_j over the moduli and T_k for each
 * combination resonance (n, m) of a mode j:
 *   G_j = S_j u_j + sum_k T_k exp(i (n theta_A + m theta_B - theta_j)) u_A^n u_B^m,  u = e / |e|.
 * At forcing frequencies off the carriers of the table, sum_k dS_j/dOmega_k detuning_k is added to
 * S_j. The slow flow (slow_flow.c) calls it. */
#include "slow/friction_model.h"

#include <math.h>

#include "base/check.h"
#include "base/lanes.h"
#include "table/table.h"

/* Adds a term to a sum. */
SM_INLINE void add(sm_complex *sum, sm_complex term) { *sum = sm_cadd(*sum, term); }

/* Returns i factor z. */
SM_INLINE sm_complex times_i(sm_complex z, double factor) {
    return sm_cx(-factor * z.im, factor * z.re);
}

/* Adds dS_j / dOmega_k detuning_k to the columns S_j and their slopes. */
SM_INLINE void add_detuning(const sm_instant *instant, int modes, size_t fields,
                            const double *by_frequency, double *slopes) {
    for (int part = 0; part < 3; part++, slopes += fields, by_frequency += 2 * modes * modes)
        for (int j = 0; j < modes; j++)
            for (int k = 0; k < modes; k++)
                for (int p = 0; p < 2; p++)
                    slopes[2 * j + p] +=
                        instant->now.detuning[k] * by_frequency[2 * (j * modes + k) + p];
}

/* Adds the combination resonances, whose columns of the table start at T. The phase of a term
 * relative to its mode is often equal or opposite to the one before, near p Omega_A = q Omega_B
 * always +-(p theta_A - q theta_B): equal phasors are computed once. */
static void add_combinations(const sm_slow_flow *flow, const sm_instant *instant, int modes,
                             const double *T, size_t fields, const double *per_modulus,
                             sm_friction *f) {
    const sm_inputs *in = &instant->inputs;
    sm_complex phasor = sm_cx(1.0, 0.0), carrier[SM_MODES] = {{1.0, 0.0}, {1.0, 0.0}};
    int last[SM_MODES] = {0, 0};
    for (int i = 0; i < modes; i++) carrier[i] = sm_cmul(f->unit[i], sm_unit(in->angle[i]));
    for (int k = 0; k < flow->table.combinations; k++, T += 2) {
        const sm_combination *c = &flow->combination[k];
        const int own = c->mode, order[SM_MODES] = {c->n, c->m};
        const int32_t beat[SM_MODES] = {c->n - (own == 0), c->m - (own == 1)};
        if (beat[0] == -last[0] && beat[1] == -last[1]) {
            phasor = sm_conj(phasor);
        } else if (beat[0] != last[0] || beat[1] != last[1]) {
            sm_harmonic_phasors(1, beat, carrier, &phasor.re, &phasor.im);
        }
        for (int i = 0; i < SM_MODES; i++) last[i] = beat[i];
        /* a mode at rest has no harmonics */
        if ((order[0] != 0 && f->modulus[0] == 0.0) || (order[1] != 0 && f->modulus[1] == 0.0))
            continue;
        const sm_complex term = sm_cmul(phasor, sm_pair(T));
        add(&f->term[own], term);
        add(&f->beat[own],
            times_i(term, beat[0] * in->frequency[0] + beat[1] * in->frequency[1]));
        for (int i = 0; i < modes; i++) {
            add(&f->along[own][i], sm_cmul(phasor, sm_pair(T + (size_t)(i + 1) * fields)));
            add(&f->across[own][i], times_i(term, order[i] * per_modulus[i]));
        }
    }
}

/* Evaluates the friction terms and their derivatives; `modes` is a literal. */
SM_INLINE sm_status evaluate(const sm_slow_flow *flow, sm_instant *instant, int modes,
                             sm_friction_terms terms, const sm_complex *e, sm_friction *f) {
    const sm_table *table = &flow->table;
    const size_t fields = 2 * (size_t)(modes + table->combinations + table->power);
    double slopes[3 * SM_MOST_FIELDS], per_modulus[SM_MODES] = {0.0};
    for (int j = 0; j < modes; j++) {
        const double square = sm_cabs2(e[j]), modulus = square < SM_TINY ? 0.0 : sqrt(square);
        per_modulus[j] = square < SM_TINY ? 0.0 : 1.0 / modulus;
        f->modulus[j] = modulus;
        f->unit[j] = square < SM_TINY ? sm_cx(1.0, 0.0) : sm_cscale(e[j], per_modulus[j]);
    }
    SM_TRY(sm_table_slopes_from(table, f->modulus, 2 * (size_t)(modes + table->combinations),
                                instant->cell, slopes, f->lag));
    if (table->detuning) {
        sm_table_detuning(table, f->modulus, 1, instant->cell, f->by_frequency);
        add_detuning(instant, modes, fields, f->by_frequency, slopes);
    }
    for (int j = 0; j < modes; j++) {
        f->term[j] = sm_pair(slopes + 2 * j);
        f->beat[j] = sm_cx(0.0, 0.0);
        for (int k = 0; k < modes; k++) {
            f->along[j][k] = sm_pair(slopes + (size_t)(k + 1) * fields + 2 * j);
            f->across[j][k] = sm_cx(0.0, 0.0);
        }
        f->across[j][j] = f->modulus[j] > 0.0 ? times_i(f->term[j], per_modulus[j])
                                              : times_i(f->along[j][j], 1.0);
    }
    if (terms == SM_ALL_TERMS && table->combinations > 0)
        add_combinations(flow, instant, modes, slopes + 2 * modes, fields, per_modulus, f);
    if (table->power) memcpy(f->power, slopes + fields - 2, sizeof f->power);
    return SM_OK;
}

SM_HOT_ONE sm_status sm_friction_at(const sm_slow_flow *flow, sm_instant *instant,
                                    sm_friction_terms terms, const sm_complex *e,
                                    sm_friction *friction) {
    return flow->table.modes == 1 ? evaluate(flow, instant, 1, terms, e, friction)
                                  : evaluate(flow, instant, SM_MODES, terms, e, friction);
}

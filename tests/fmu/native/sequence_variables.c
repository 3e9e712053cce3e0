/* Random calls that set and read variables, and derivatives of them. */
#include <math.h>
#include <stddef.h>

#include "sequence.h"

double hostile_number(void) {
    const double numbers[] = {0.0, -0.0, -1.0, NAN, INFINITY, -INFINITY, 1e308, -1e308, 5e-324};
    return numbers[below((int)(sizeof numbers / sizeof *numbers))];
}

static int is_settable(const instance *i, const fmu_variable *v) {
    if (v->kind == FMU_INPUT) return in(i, INSTANTIATED | INITIALIZATION | RUNNING);
    const int tunable = v->kind == FMU_PARAMETER && v->slot != FMU_CONTACT_WANTED;
    return (v->kind == FMU_PARAMETER || v->kind == FMU_START) &&
           in(i, INSTANTIATED | INITIALIZATION | (tunable ? TUNABLE : 0));
}

#define SLOT(field) ((int32_t)(offsetof(sm_inputs, field) / sizeof(double)))

double good_value(const fmu_variable *v) {
    if (v->kind == FMU_START) return (uniform() - 0.5) * 0.66 * model->constants->nominal[v->slot - 1];
    if (v->kind == FMU_PARAMETER)
        return v->slot == FMU_TOLERANCE ? (below(2) ? 1e-6 : 1e-4) : 0.02 * (uniform() - 0.3);
    if (v->slot == SLOT(limit_scale)) return 0.8 + 0.4 * uniform();
    if (v->slot == SLOT(frequency[0])) return model->flow.natural[0] * (0.9 + 0.2 * uniform());
    if (v->slot == SLOT(frequency[1])) return model->flow.natural[1] * (0.93 + 0.1 * uniform());
    if ((v->slot >= SLOT(frequency) && v->slot < SLOT(phase)) || v->slot == SLOT(limit_scale_rate))
        return 1e-4 * (uniform() - 0.5);
    return 0.2 * (uniform() - 0.5);
}

void set_reals(instance *i) {
    uint32_t vr[4];
    double value[4];
    const size_t count = (size_t)below(5);
    const long before = messages.count;
    int legal = in(i, INSTANTIATED | INITIALIZATION | RUNNING);
    for (size_t k = 0; k < count; k++) {
        vr[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        const int known = vr[k] < (uint32_t)model->variables;
        const fmu_variable *v = known ? &model->variable[vr[k]] : NULL;
        value[k] = v ? good_value(v) : 0.0;
        if (!v || v->type != FMU_REAL || !is_settable(i, v)) legal = 0;
        if (below(10) == 0) {
            value[k] = NAN;
            legal = 0;
        }
    }
    if (count > 0 && below(20) == 0) {
        judge(fmi->set_real(i->c, below(2) ? NULL : vr, count, NULL), 0, 0, before, "set NULL");
        return;
    }
    judge(fmi->set_real(i->c, vr, count, value), legal, 0, before, "set real");
}

void get_reals(instance *i) {
    uint32_t vr[4];
    double value[4] = {0.0};
    const size_t count = (size_t)below(5);
    const long before = messages.count;
    int legal = !in(i, INSTANTIATED);
    for (size_t k = 0; k < count; k++) {
        vr[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        const int known = vr[k] < (uint32_t)model->variables;
        if (!known || model->variable[vr[k]].type != FMU_REAL) legal = 0;
    }
    if (count > 0 && below(20) == 0) {
        judge(fmi->get_real(i->c, vr, count, NULL), 0, 0, before, "get NULL");
        return;
    }
    const status got = fmi->get_real(i->c, vr, count, value);
    judge(got, legal, 1, before, "get real");
    for (size_t k = 0; got == OK && k < count; k++) CHECK(isfinite(value[k]), "get real");
}

/* Any unknowns by any knowns. Where there is none, as of a modulus at zero, is not known here. */
void call_directional(instance *i) {
    uint32_t unknown[3], known[3];
    double seed[3], sensitivity[3] = {0.0};
    const long before = messages.count;
    const size_t unknowns = (size_t)below(4), knowns = (size_t)below(4);
    for (int k = 0; k < 3; k++) {
        unknown[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        known[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        seed[k] = below(20) ? uniform() : hostile_number();
    }
    const int adjoint = fmi->adjoint && below(3) == 0;
    const status got = (adjoint ? fmi->adjoint : fmi->directional)(
        i->c, below(12) ? unknown : NULL, unknowns, below(12) ? known : NULL, knowns, seed,
        sensitivity);
    CHECK(got == OK || messages.count > before, "directional derivative");
    CHECK(got != OK || !in(i, INSTANTIATED), "directional derivative");
}

/* Of any variables by time. */
void call_output_derivatives(instance *i) {
    uint32_t vr[3];
    int32_t order[3];
    double value[3] = {0.0};
    const long before = messages.count;
    const size_t count = (size_t)below(4);
    for (int k = 0; k < 3; k++) {
        vr[k] = below(12) ? (uint32_t)below(model->variables) : random_bits();
        order[k] = below(8) ? 1 : below(3);
    }
    const status got = fmi->output_derivatives(i->c, below(12) ? vr : NULL, count, order,
                                               below(12) ? value : NULL);
    CHECK(got == OK || messages.count > before, "output derivatives");
    CHECK(got != OK || in(i, STEPPING | STEP_EVENTS), "output derivatives");
    for (size_t k = 0; got == OK && k < count; k++) CHECK(isfinite(value[k]), "output derivatives");
}

/* Enumerations and booleans: the only ones there are, and wrong ones. */
void other_types(instance *i) {
    const long before = messages.count;
    const uint32_t vr = below(4) ? (uint32_t)below(model->variables) : random_bits();
    const int known = vr < (uint32_t)model->variables;
    const int32_t type = known ? model->variable[vr].type : FMU_REAL;
    int32_t integer = 0;
    int boolean = 0;
    switch (below(3)) {
    case 0:
        judge(fmi->get_enumeration(i->c, &vr, 1, &integer),
              type == FMU_ENUMERATION && !in(i, INSTANTIATED), 1, before, "get enumeration");
        break;
    case 1:
        judge(fmi->get_boolean(i->c, &vr, 1, &boolean),
              type == FMU_BOOLEAN && !in(i, INSTANTIATED), 1, before, "get boolean");
        break;
    default:
        boolean = below(2);
        judge(fmi->set_boolean(i->c, &vr, 1, &boolean),
              type == FMU_BOOLEAN && in(i, INSTANTIATED | INITIALIZATION), 0, before,
              "set boolean");
    }
}

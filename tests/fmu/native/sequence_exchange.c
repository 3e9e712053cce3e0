/* Random calls of Model Exchange, and about events. */
#include <math.h>
#include <string.h>

#include "sequence.h"

/* States change only where it says so, and only once. `whole`: no argument is NULL. */
static void update(instance *i, int whole) {
    const size_t nx = 3 * (size_t)model->modes + 1, bytes = nx * sizeof(double);
    const int exchanged = in(i, EVENTS), legal = (exchanged || in(i, STEP_EVENTS)) && whole;
    double before[16], after[16];
    int changed = 0, again = 0;
    if (legal && exchanged) CHECK(fmi->get_states(i->c, before, nx) == OK, "update");
    const long messages_before = messages.count;
    judge(fmi->update_discrete(i->c, whole ? &changed : NULL), legal, 0, messages_before,
          "update");
    if (legal && !exchanged) CHECK(!changed, "update");
    if (!legal || !exchanged) return;
    CHECK(fmi->get_states(i->c, after, nx) == OK, "update");
    CHECK(changed || memcmp(before, after, bytes) == 0, "update");
    CHECK(fmi->update_discrete(i->c, &again) == OK && !again, "update again");
    CHECK(fmi->get_states(i->c, before, nx) == OK, "update again");
    CHECK(memcmp(before, after, bytes) == 0, "update again");
}

/* An event as importers make it: an input is set, then the states follow. */
static void event(instance *i) {
    uint32_t vr = (uint32_t)below(model->variables);
    while (model->variable[vr].kind != FMU_INPUT) vr = (vr + 1) % (uint32_t)model->variables;
    const double value = good_value(&model->variable[vr]);
    CHECK(fmi->enter_events(i->c) == OK, "event");
    i->state = EVENTS;
    CHECK(fmi->set_real(i->c, &vr, 1, &value) == OK, "event");
    update(i, 1);
    CHECK(fmi->enter_continuous(i->c) == OK, "event");
    i->state = CONTINUOUS;
}

void exchange(instance *i) {
    const size_t nx = 3 * (size_t)model->modes + 1, wrong = nx + (size_t)below(2) * 2 - 1;
    double values[16] = {0.0};
    const long before = messages.count;
    const int arguments = below(8) != 0, right = below(8) != 0;
    const double time = below(8) ? i->time + uniform() : hostile_number();
    const int kind = below(12);
    for (size_t k = 0; k < nx; k++) values[k] = uniform() - 0.5;
    if (kind == 6 && !right) values[below((int)nx)] = NAN;
    switch (kind) {
    case 0:
        judge(fmi->enter_events(i->c), in(i, EXCHANGE) || (in(i, STEPPING) && i->events), 0,
              before, "enter events");
        if (in(i, EXCHANGE)) i->state = EVENTS;
        if (in(i, STEPPING) && i->events) i->state = STEP_EVENTS;
        break;
    case 11:
        if (!fmi->enter_steps) break;
        judge(fmi->enter_steps(i->c), in(i, STEP_EVENTS), 0, before, "enter steps");
        if (in(i, STEP_EVENTS)) i->state = STEPPING;
        break;
    case 1: update(i, arguments); break;
    case 2:
    case 3:
        judge(fmi->enter_continuous(i->c), in(i, EVENTS), 0, before, "enter continuous");
        if (in(i, EVENTS)) i->state = CONTINUOUS;
        break;
    case 4:
        judge(fmi->completed_step(i->c, arguments), in(i, CONTINUOUS) && arguments, 0, before,
              "completed step");
        break;
    case 5: judge(fmi->set_time(i->c, time), in(i, EXCHANGE) && isfinite(time), 0, before, "time"); break;
    case 6:
        judge(fmi->set_states(i->c, values, nx), in(i, CONTINUOUS) && right, 0, before,
              "set states");
        break;
    case 7:
        judge(fmi->get_states(i->c, right ? values : NULL, nx), in(i, EXCHANGE) && right, 0,
              before, "get states");
        break;
    case 8:
        judge(fmi->get_derivatives(i->c, values, right ? nx : wrong), in(i, EXCHANGE) && right, 1,
              before, "derivatives");
        break;
    case 9:
        if (in(i, EXCHANGE)) event(i);
        break;
    default:
        judge(fmi->get_nominals(i->c, values, right ? nx : wrong), in(i, EXCHANGE) && right, 0,
              before, "nominals");
        judge(fmi->get_indicators(i->c, 1), 0, 0, before, "indicators");
    }
}

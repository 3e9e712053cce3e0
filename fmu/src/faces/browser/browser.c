/* Calls from JavaScript: an instance of Co-Simulation as in FMI, and what a page shows beyond it: the
 * motion over a beat, and response curves. Built as WebAssembly alone (fmu/archive/browser.py).
 *
 * Where a call is refused, browser_message says why, and the instance is as before. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/exact_sum.h"
#include "faces/browser/memory.h"
#include "instance/instance.h"
#include "resources/files.h"

#if defined(__wasm__)
#define EXPORT(name) __attribute__((export_name(#name))) name
#else
#define EXPORT(name) name
#endif

#define MOST_POINTS 1000 /* of a branch of a curve, to each side of the state it starts from */
#define MOST_STARTS 4096 /* steady states that branches may start from */
#define LARGEST_STEP 0.004 /* between points, relative to span and table: smooth on a screen */
#define SECTIONS 9         /* of the span with states to start from, as rom.response_curve has */

typedef struct {
    fmu_instance *instance;
    memory_files files;
    char message[FMU_MESSAGE];
    double *state;  /* of the component, while its motion over a beat is computed */
    double *starts; /* steady states, one after the other */
    double *branch; /* rows of a branch */
} browser;

static void write_message(const fmu_logger *logger, const char *name, fmu_status status,
                          const char *category, const char *message) {
    (void)name, (void)status, (void)category;
    strncpy(logger->environment, message, FMU_MESSAGE - 1);
}

void *EXPORT(browser_allocate)(size_t bytes) { return calloc(bytes, 1); }

/* The reason of the last refusal, or a warning, since it was cleared. */
const char *EXPORT(browser_message)(const browser *b) { return b->message; }

void EXPORT(browser_clear_message)(browser *b) { memset(b->message, 0, sizeof b->message); }

/* Returns files whose bytes came in eight planes, which compress better: the first of every eight
 * bytes, then the second... */
static char *from_planes(const char *planes, size_t size) {
    char *bytes = malloc(size + 1);
    for (size_t k = 0; bytes && k < size; k++) bytes[k] = planes[k % 8 * (size / 8) + k / 8];
    return bytes;
}

static int read_token(const char *location, char token[65]) {
    FILE *file = location_open(location, "token.txt");
    const size_t length = file ? fread(token, 1, 64, file) : 0;
    if (file) fclose(file);
    token[length] = '\0';
    return length == 64;
}

static int allocate(browser *b, const fmu_instance *instance) {
    const size_t unknowns = 2 * (size_t)instance->model->modes, row = unknowns + 1;
    b->state = calloc(sm_component_state_count(instance->core->component) + 1, sizeof(double));
    b->starts = calloc(MOST_STARTS * row, sizeof(double));
    b->branch = calloc((2 * MOST_POINTS - 1) * (2 * row + unknowns * unknowns), sizeof(double));
    if (b->state && b->starts && b->branch) return 1;
    strcpy(b->message, "out of memory");
    return 0;
}

/* Returns a started instance of the model in these files. NULL: out of memory; if there is another
 * reason, it is the message, and there is no instance. */
browser *EXPORT(browser_open)(const char *planes, size_t size) {
    browser *b = calloc(1, sizeof *b);
    if (!b) return NULL;
    char location[MEMORY_LOCATION], token[65];
    b->files = (memory_files){from_planes(planes, size), size};
    memory_location(&b->files, location);
    if (!b->files.bytes || size % 8 != 0 || !read_token(location, token)) {
        strcpy(b->message, "the model in this page is damaged");
        return b;
    }
    const fmu_logger logger = {.write = write_message, .environment = b->message};
    fmu_instance *instance = fmu_instantiate(FMU_CO_SIMULATION, "page", token, location, &logger);
    if (!instance || !allocate(b, instance)) return b;
    if (fmu_setup(instance, 0, 0.0, 0.0, 0, 0.0) == FMU_OK
        && fmu_enter(instance, FMU_INITIALIZATION) == FMU_OK
        && fmu_exit_initialization(instance) == FMU_OK)
        b->instance = instance;
    return b;
}

/* 1 if there is an instance. */
int EXPORT(browser_is_open)(const browser *b) { return b->instance != NULL; }

/* Doubles in a row of all outputs, as sm_component_outputs packs them. */
size_t EXPORT(browser_output_count)(const browser *b) { return b->instance->output_count; }

int EXPORT(browser_get)(browser *b, const uint32_t *reference, size_t count, double *value) {
    return fmu_get_reals(b->instance, reference, count, value, count, 0) == FMU_OK;
}

/* Sets inputs; if one of them is refused, all keep their values. */
int EXPORT(browser_set)(browser *b, const uint32_t *reference, size_t count, const double *value) {
    fmu_instance *instance = b->instance;
    const sm_inputs before = instance->run.inputs;
    if (fmu_set_reals(instance, reference, count, value) == FMU_OK
        && fmu_evaluate_outputs(instance) == FMU_OK)
        return 1;
    instance->run.inputs = before;
    instance->inputs_current = 0;
    fmu_outdate(instance);
    (void)fmu_evaluate_inputs(instance); /* they were accepted before */
    return 0;
}

/* Advances in equal steps, as many as stay in the friction table; returns how many. Values after each
 * of them go into rows (steps, count). */
size_t EXPORT(browser_play)(browser *b, double duration, size_t steps, const uint32_t *reference,
                            size_t count, double *rows) {
    fmu_instance *instance = b->instance;
    for (size_t k = 0; k < steps; k++, rows += count)
        if (fmu_step(instance, instance->outputs[0], duration / (double)steps) != FMU_OK
            || !browser_get(b, reference, count, rows))
            return k;
    return steps;
}

/* Evaluates the outputs after the amplitudes have been set, or says why they were not set. */
static int moved(browser *b, sm_status status, const char *doing) {
    fmu_outdate(b->instance);
    if (status == SM_OK) return fmu_evaluate_outputs(b->instance) == FMU_OK;
    fmu_say(b->instance, FMU_ERROR, "%s: %s", doing, sm_message(status));
    return 0;
}

/* Back to t = 0 and the amplitudes there, under the present inputs. */
int EXPORT(browser_restart)(browser *b) {
    const double *amplitude = b->instance->model->constants->amplitude;
    return moved(b, sm_component_reset(b->instance->core->component, 0.0, amplitude), "reset");
}

/* Moves the amplitude of each mode by a part of its range in the friction table. */
int EXPORT(browser_perturb)(browser *b, double part) {
    const fmu_instance *instance = b->instance;
    double amplitude[2 * SM_MODES], range[SM_MODES];
    fmu_table_range(instance, range);
    memcpy(amplitude, instance->outputs + FMU_AMPLITUDE, sizeof amplitude);
    for (int j = 0; j < instance->model->modes; j++)
        amplitude[2 * j] += part * range[j] * instance->run.inputs.limit_scale;
    return moved(b, sm_component_set_amplitude(instance->core->component, amplitude), "perturb");
}

/* ---- motion over a beat ------------------------------------------------------------------ */

/* The lower and the higher of the carrier frequencies. */
static void carriers(const fmu_instance *instance, double *slower, double *faster) {
    const double *frequency = instance->run.inputs.frequency;
    const double other = frequency[instance->model->modes - 1];
    *slower = fmin(frequency[0], other);
    *faster = fmax(frequency[0], other);
}

/* Motion from the present time on, which stays, over whole cycles of the slower carrier that are a
 * beat of the two or more. Rows of all outputs, evenly in time, at most `most`; returns how many. */
size_t EXPORT(browser_beat)(browser *b, size_t per_cycle, size_t most, double *rows) {
    fmu_instance *instance = b->instance;
    double slower, faster;
    carriers(instance, &slower, &faster);
    const double cycles = faster > slower ? ceil(slower / (faster - slower)) : 1.0;
    const double wanted = ceil((double)per_cycle * cycles * faster / slower) + 1.0;
    const size_t samples = wanted < (double)most ? (size_t)wanted : most;
    if (samples < 2 || fmu_evaluate_outputs(instance) != FMU_OK) return 0;
    const double step = cycles * SM_TWO_PI / slower / (double)(samples - 1);
    sm_component_get_state(instance->core->component, b->state);
    sm_status status = SM_OK;
    size_t count = 0;
    for (; status == SM_OK && count < samples; rows += instance->output_count) {
        if (count > 0) status = sm_component_step(instance->core->component, step);
        if (status == SM_OK) status = sm_component_outputs(instance->core->component, rows);
        count += status == SM_OK;
    }
    sm_component_set_state(instance->core->component, b->state);
    fmu_status_of(instance, status, "motion");
    return count;
}

/* ---- response curves --------------------------------------------------------------------- */

/* Returns the inputs at the ends of a span of a frequency, as far as the slow flow can follow it, and
 * on the side of the other frequency on which it is. */
static void set_span(const fmu_instance *instance, int mode, double from, double to,
                     sm_inputs ends[2]) {
    const double *allowed = instance->model->constants->carrier_range;
    const double middle = instance->model->constants->middle[mode];
    const double least = 1e-6; /* between frequencies */
    const sm_inputs now = fmu_inputs_now(instance);
    from = fmax(from, allowed[0] * middle);
    to = fmin(to, allowed[1] * middle);
    if (instance->model->modes == SM_MODES) {
        const double other = now.frequency[1 - mode];
        if (now.frequency[mode] < other)
            to = fmin(to, (1.0 - least) * other);
        else
            from = fmax(from, (1.0 + least) * other);
    }
    ends[0] = ends[1] = now;
    ends[0].frequency[mode] = from;
    ends[1].frequency[mode] = to;
}

/* Writes a point of a branch as a row of browser_curve. */
static void put(const sm_forced *forced, int mode, int number, const double *point, double *row) {
    const int modes = forced->flow->table.modes;
    const sm_inputs *ends = forced->inputs;
    const double from = ends[0].frequency[mode], part = point[2 * modes];
    *row++ = from + part * (ends[1].frequency[mode] - from);
    for (int j = 0; j < modes; j++)
        *row++ = ends[0].limit_scale * forced->scale[j] * fmu_modulus(point + 2 * j);
    *row++ = sm_curve_is_stable(2 * modes, point);
    *row = number;
}

/* Steady states under the present inputs against the frequency of a mode: rows of the frequency
 * [rad/s], |a_j| of each mode, 1 where it is stable, and the number of the branch. At most `most`;
 * returns how many. */
size_t EXPORT(browser_curve)(browser *b, int mode, double from, double to, size_t most,
                             double *rows) {
    const fmu_instance *instance = b->instance;
    const int modes = instance->model->modes, unknowns = 2 * modes;
    const size_t stride = 2 * (size_t)(unknowns + 1) + (size_t)(unknowns * unknowns);
    sm_inputs ends[2];
    sm_forced forced = {.flow = &instance->flow, .inputs = ends};
    sm_curve curve;
    size_t starts = 0, count = 0;
    int number = 0;
    if (mode < 0 || mode >= modes) return 0;
    set_span(instance, mode, from, to, ends);
    if (!(ends[0].frequency[mode] < ends[1].frequency[mode])) return 0;
    fmu_table_range(instance, forced.scale);
    sm_status status = sm_forced_curve(&forced, LARGEST_STEP, &curve);
    if (status == SM_OK)
        status = sm_forced_solutions(&forced, SECTIONS, MOST_STARTS, b->starts, &starts);
    fmu_status_of(instance, status, "response curve");
    while (status == SM_OK && starts > 0 && count < most) {
        sm_branch branch = {0, 0, 0};
        const double *row = b->branch, *z = b->starts + --starts * (size_t)(unknowns + 1);
        size_t points = 0;
        if (sm_curve_branch(&curve, z, MOST_POINTS, b->branch, &branch) == SM_OK) {
            row += (MOST_POINTS - 1 - branch.before) * stride;
            points = branch.before + 1 + branch.after;
        }
        for (size_t k = 0; points > 1 && k < points && count < most; k++, count++, rows += modes + 3)
            put(&forced, mode, number, row + k * stride, rows);
        number += points > 1;
        size_t left = 0; /* steady states on no branch so far */
        for (size_t k = 0; k < starts; k++) {
            const double *other = b->starts + k * (size_t)(unknowns + 1);
            if (sm_curve_passes(unknowns, points, stride, row, other)) continue;
            memmove(b->starts + left++ * (size_t)(unknowns + 1), other,
                    (size_t)(unknowns + 1) * sizeof *other);
        }
        starts = left;
    }
    return count;
}

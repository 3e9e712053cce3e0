#include "resources/model.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "resources/location.h"
#include "resources/npy.h"

#define MOST 1000000 /* contacts, elastic outputs, nodes or variables: more is damage */

#define MOST_NAME 128 /* bytes */

/* Files, in the order of checksums.npy. */
enum {
    LAYOUT, CONSTANTS, INPUTS, COMBINATIONS, NODE_A, NODE_B, TABLE, RATE_CORRECTION,
    DETUNING, LIMIT, STIFFNESS, DAMPING, MASS, COUPLING, ELEMENTS, SLIDERS, REFERENCE, ELASTIC_MODES,
    ELASTIC_FORCES, ELASTIC_CONTACTS, ORDERS, REACTION, RESPONSE, VARIABLES, NAMES, FILES
};
static const char *const FILE_NAME[FILES] = {
    "layout.npy", "constants.npy", "inputs.npy", "combinations.npy", "node_a.npy", "node_b.npy",
    "table.npy", "rate_correction.npy", "detuning.npy", "contact_limit.npy", "contact_stiffness.npy",
    "contact_damping.npy", "contact_mass.npy", "contact_coupling.npy", "contact_elements.npy",
    "contact_sliders.npy", "contact_reference.npy", "elastic_modes.npy", "elastic_forces.npy", "elastic_contacts.npy",
    "orders.npy", "contact_reaction.npy", "elastic_response.npy", "variables.npy", "names.txt"};
/* Memory besides that of the files. */
enum { NAME_STARTS = FILES, ELEMENT_RECORDS };

/* layout.npy */
typedef struct {
    int32_t format, modes, contacts, elastic, law, paper, combinations, power, count_a, count_b;
    int32_t corrected, detuned, inertia, elements, sliders, orders, steps_per_period, variables;
} layout;

/* constants.npy */
typedef struct {
    double alpha, memory_periods;
    double natural[SM_MODES], carrier[SM_MODES], coupling_ratio[SM_MODES][2][2], off_resonance[SM_MODES][2];
    double cross_response[SM_MODES][SM_MODES][2], force_factor[SM_MODES];
    double parameters[FMU_PARAMETERS], nominal[FMU_STATES], amplitude[2 * SM_MODES];
    double carrier_range[2];
} constants;

/* A row of contact_elements.npy: sm_element in doubles. */
enum {
    ROW_LAW, ROW_COLUMN, ROW_FIRST_SLIDER = ROW_COLUMN + 3, ROW_SLIDERS, ROW_TANGENTS,
    ROW_FRICTION, ROW_PRELOAD, ROW_TANGENTIAL_STIFFNESS, ROW_NORMAL_STIFFNESS, ROW_GAP, ROW_WIDTH
};

typedef struct {
    const char *folder;
    int32_t *checksum; /* (FILES), NULL until it is read */
    uint32_t crc;      /* of the file that was read last */
    char *reason;
} loader;

static int refuse(loader *l, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(l->reason, FMU_REASON, format, arguments);
    va_end(arguments);
    return 0;
}

static FILE *open_file(loader *l, const char *name) {
    FILE *file = location_open(l->folder, name);
    if (!file) refuse(l, "resources/%s is missing or cannot be read", name);
    return file;
}

static void *read_array(loader *l, const char *name, npy_type type, int dimensions,
                        const size_t shape[NPY_DIMENSIONS]) {
    FILE *file = open_file(l, name);
    if (!file) return NULL;
    npy_layout expected = {.type = type, .dimensions = dimensions};
    for (int k = 0; k < dimensions; k++) expected.shape[k] = shape[k];
    const char *reason;
    void *data = npy_read(file, &expected, &l->crc, &reason);
    fclose(file);
    if (!data) refuse(l, "resources/%s: %s", name, reason);
    return data;
}

static int checksum_fits(loader *l, int which) {
    if ((uint32_t)l->checksum[which] == l->crc) return 1;
    return refuse(l, "resources/%s: damaged, its checksum does not fit", FILE_NAME[which]);
}

/* File `which` into model->memory. */
static void *load_array(loader *l, fmu_model *model, int which, npy_type type, int dimensions,
                        size_t a, size_t b, size_t c, size_t d) {
    const size_t shape[NPY_DIMENSIONS] = {a, b, c, d};
    model->memory[which] = read_array(l, FILE_NAME[which], type, dimensions, shape);
    return model->memory[which] && checksum_fits(l, which) ? model->memory[which] : NULL;
}

/* A text of at most `most` bytes, zero-terminated, in memory from malloc. */
static char *read_text(loader *l, const char *name, size_t most) {
    FILE *file = open_file(l, name);
    if (!file) return NULL;
    char *text = malloc(most + 1);
    const size_t length = text ? fread(text, 1, most, file) : 0;
    const int whole = text && fgetc(file) == EOF;
    fclose(file);
    if (!whole) {
        refuse(l, text ? "resources/%s: longer than it may be" : "resources/%s: out of memory", name);
        free(text);
        return NULL;
    }
    text[length] = '\0';
    l->crc = npy_crc(0, text, length);
    return text;
}

static int token_fits(loader *l, const char *token) {
    char *own = read_text(l, "token.txt", FMU_TOKEN);
    if (!own) return 0;
    const int same = strcmp(own, token) == 0;
    free(own);
    return same || refuse(l, "the instantiation token is not that of this FMU's resources");
}

static int layout_is_possible(loader *l, const layout *shape) {
    if (shape->format != FMU_FORMAT)
        return refuse(l, "resources/layout.npy: version %ld, this binary reads version %d",
                      (long)shape->format, FMU_FORMAT);
    const int32_t counts[] = {shape->contacts, shape->elastic,  shape->combinations,
                              shape->elements, shape->sliders,  shape->orders,
                              shape->count_a,  shape->count_b,  shape->variables};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++)
        if (counts[k] < 0 || counts[k] > MOST)
            return refuse(l, "resources/layout.npy: a count of %ld", (long)counts[k]);
    if (shape->modes < 1 || shape->modes > SM_MODES || shape->combinations > SM_COMBINATIONS)
        return refuse(l, "resources/layout.npy: %ld modes and %ld combination resonances",
                      (long)shape->modes, (long)shape->combinations);
    return 1;
}

/* An array over the nodes that a table may lack: its file is empty then. */
static int load_correction(loader *l, fmu_model *model, int file, const layout *shape, int given,
                           const double **correction) {
    const size_t count_a = given ? (size_t)shape->count_a : 0;
    const size_t count_b = given ? (size_t)shape->count_b : 0;
    const size_t columns = given ? 2 * (size_t)(shape->modes * shape->modes) : 0;
    const double *array =
        load_array(l, model, file, NPY_FLOAT64, 4, count_a, count_b, 4, columns);
    *correction = given ? array : NULL;
    return array != NULL;
}

static int load_flow(loader *l, fmu_model *model, const layout *shape, const constants *given) {
    const size_t count_a = (size_t)shape->count_a, count_b = (size_t)shape->count_b;
    const size_t fields = 2 * (size_t)(shape->modes + shape->combinations + shape->power);
    sm_slow_flow *flow = &model->flow;
    const int32_t *combination =
        load_array(l, model, COMBINATIONS, NPY_INT32, 2, (size_t)shape->combinations, 3, 0, 0);
    if (!combination) return 0;
    for (int32_t k = 0; k < shape->combinations; k++)
        flow->combination[k] =
            (sm_combination){combination[3 * k], combination[3 * k + 1], combination[3 * k + 2]};
    flow->paper = shape->paper;
    memcpy(flow->natural, given->natural, sizeof flow->natural);
    memcpy(flow->carrier, given->carrier, sizeof flow->carrier);
    memcpy(flow->damping, given->parameters + FMU_DAMPING, sizeof flow->damping);
    memcpy(flow->off_resonance, given->off_resonance, sizeof flow->off_resonance);
    memcpy(flow->cross_response, given->cross_response, sizeof flow->cross_response);
    for (int j = 0; j < SM_MODES; j++)
        memcpy(flow->coupling_ratio[j].c, given->coupling_ratio[j],
               sizeof flow->coupling_ratio[j].c);
    flow->table = (sm_table){.modes = shape->modes,
                             .combinations = shape->combinations,
                             .power = shape->power,
                             .count_a = shape->count_a,
                             .count_b = shape->count_b};
    flow->table.node_a = load_array(l, model, NODE_A, NPY_FLOAT64, 1, count_a, 0, 0, 0);
    if (!flow->table.node_a) return 0;
    flow->table.node_b = load_array(l, model, NODE_B, NPY_FLOAT64, 1, count_b, 0, 0, 0);
    if (!flow->table.node_b) return 0;
    flow->table.values = load_array(l, model, TABLE, NPY_FLOAT64, 4, count_a, count_b, 4, fields);
    if (!flow->table.values) return 0;
    return load_correction(l, model, RATE_CORRECTION, shape, shape->corrected,
                           &flow->table.rate_correction)
           && load_correction(l, model, DETUNING, shape, shape->detuned, &flow->table.detuning);
}

/* The elements as the core takes them; integers in their rows must be such. */
static const sm_element *read_elements(loader *l, fmu_model *model, const double *row,
                                       size_t count) {
    sm_element *element = calloc(count + 1, sizeof *element);
    model->memory[ELEMENT_RECORDS] = element;
    if (!element) refuse(l, "out of memory");
    for (size_t e = 0; element && e < count; e++, row += ROW_WIDTH) {
        int32_t integer[ROW_FRICTION];
        for (int k = 0; k < ROW_FRICTION; k++) {
            if (!(row[k] >= 0.0 && row[k] <= MOST && row[k] == floor(row[k]))) {
                refuse(l, "resources/contact_elements.npy: element %ld is none", (long)e);
                return NULL;
            }
            integer[k] = (int32_t)row[k];
        }
        element[e] = (sm_element){.law = integer[ROW_LAW],
                                  .first_slider = integer[ROW_FIRST_SLIDER],
                                  .sliders = integer[ROW_SLIDERS],
                                  .tangents = integer[ROW_TANGENTS],
                                  .friction = row[ROW_FRICTION],
                                  .preload = row[ROW_PRELOAD],
                                  .tangential_stiffness = row[ROW_TANGENTIAL_STIFFNESS],
                                  .normal_stiffness = row[ROW_NORMAL_STIFFNESS],
                                  .gap = row[ROW_GAP]};
        memcpy(element[e].column, integer + ROW_COLUMN, sizeof element[e].column);
    }
    return element;
}

/* Elastic contacts; rigid ones have none of it. */
static int load_elastic(loader *l, fmu_model *model, const layout *shape) {
    const size_t elements = (size_t)shape->elements, sliders = (size_t)shape->sliders;
    const size_t n = shape->law == SM_ELASTIC ? (size_t)shape->contacts : 0;
    const double *row = load_array(l, model, ELEMENTS, NPY_FLOAT64, 2, elements, ROW_WIDTH, 0, 0);
    const double *slider =
        row ? load_array(l, model, SLIDERS, NPY_FLOAT64, 2, sliders, 2, 0, 0) : NULL;
    const double *reference =
        slider ? load_array(l, model, REFERENCE, NPY_FLOAT64, 1, n, 0, 0, 0) : NULL;
    const sm_element *element = reference ? read_elements(l, model, row, elements) : NULL;
    if (!element) return 0;
    model->elastic = (sm_elastic){.elements = shape->elements,
                                  .sliders = shape->sliders,
                                  .element = element,
                                  .slider = slider,
                                  .reference = reference};
    return 1;
}

static int load_contact(loader *l, fmu_model *model, const layout *shape, const constants *given) {
    const size_t n = (size_t)shape->contacts, modes = (size_t)shape->modes;
    const int elastic = shape->law == SM_ELASTIC;
    const size_t rigid = elastic ? 0 : n, inertia = shape->inertia ? n : 0;
    const double *limit = load_array(l, model, LIMIT, NPY_FLOAT64, 1, rigid, 0, 0, 0);
    const double *stiffness =
        limit ? load_array(l, model, STIFFNESS, NPY_FLOAT64, 2, n, n, 0, 0) : NULL;
    const double *damping =
        stiffness ? load_array(l, model, DAMPING, NPY_FLOAT64, 2, rigid, rigid, 0, 0) : NULL;
    const double *mass =
        damping ? load_array(l, model, MASS, NPY_FLOAT64, 2, inertia, inertia, 0, 0) : NULL;
    const double *coupling =
        mass ? load_array(l, model, COUPLING, NPY_FLOAT64, 3, modes, n, 2, 0) : NULL;
    if (!coupling || !load_elastic(l, model, shape)) return 0;
    model->contact = (sm_contact){.contacts = shape->contacts,
                                  .modes = shape->modes,
                                  .law = shape->law,
                                  .alpha = given->alpha,
                                  .limit = limit,
                                  .stiffness = stiffness,
                                  .damping = damping,
                                  .coupling = coupling,
                                  .mass = shape->inertia ? mass : NULL,
                                  .elastic = elastic ? &model->elastic : NULL};
    const sm_status status = sm_contact_check(&model->contact);
    return status == SM_OK || refuse(l, "resources/contact_*.npy: %s", sm_message(status));
}

static int load_motion(loader *l, fmu_model *model, const layout *shape, const constants *given) {
    const size_t n = (size_t)shape->contacts, modes = (size_t)shape->modes;
    const size_t elastic = (size_t)shape->elastic, orders = (size_t)shape->orders;
    const size_t a = (size_t)shape->count_a, b = (size_t)shape->count_b;
    const double *modes_out =
        load_array(l, model, ELASTIC_MODES, NPY_FLOAT64, 3, elastic, modes, 2, 0);
    const double *forces_out =
        modes_out ? load_array(l, model, ELASTIC_FORCES, NPY_FLOAT64, 3, elastic, modes, 2, 0)
                  : NULL;
    const double *contacts_out =
        forces_out ? load_array(l, model, ELASTIC_CONTACTS, NPY_FLOAT64, 2, elastic, n, 0, 0) : NULL;
    const int32_t *order =
        contacts_out ? load_array(l, model, ORDERS, NPY_INT32, 2, orders, 2, 0, 0) : NULL;
    const double *reaction =
        order ? load_array(l, model, REACTION, NPY_FLOAT64, 4, a, b, orders, 2 * n) : NULL;
    const double *response =
        reaction ? load_array(l, model, RESPONSE, NPY_FLOAT64, 4, a, b, orders, 2 * elastic)
                 : NULL;
    if (!response) return 0;
    model->motion = (sm_motion){.elastic = shape->elastic,
                                .modes_out = modes_out,
                                .forces_out = forces_out,
                                .contacts_out = contacts_out,
                                .orders_count = shape->orders,
                                .orders = order,
                                .reaction = reaction,
                                .response = response,
                                .steps_per_period = shape->steps_per_period,
                                .memory_periods = given->memory_periods};
    return 1;
}

/* The first slot that a variable of this kind does not have. */
static int32_t slots(const fmu_model *model, int32_t kind) {
    switch (kind) {
    case FMU_OUTPUT:
        return SM_OUTPUTS_FIXED + 3 * model->contact.contacts + model->motion.elastic;
    case FMU_START: return 1 + 2 * SM_MODES;
    case FMU_INPUT: return (int32_t)(sizeof(sm_inputs) / sizeof(double));
    case FMU_PARAMETER: return FMU_PARAMETERS;
    case FMU_RATE: return FMU_STATES;
    case FMU_MODULUS:
    case FMU_PHASE: return SM_MODES;
    default: return 1;
    }
}

static int load_variables(loader *l, fmu_model *model, int32_t count) {
    const fmu_variable *variable =
        load_array(l, model, VARIABLES, NPY_INT32, 2, (size_t)count, 3, 0, 0);
    if (!variable) return 0;
    for (int32_t k = 0; k < count; k++) {
        const fmu_variable v = variable[k];
        const int32_t size = v.type == FMU_ARRAY ? model->contact.contacts : 1;
        const int misplaced = v.type == FMU_ARRAY &&
                              (v.kind != FMU_OUTPUT || v.slot < SM_OUTPUTS_FIXED);
        if (v.type < FMU_REAL || v.type > FMU_ARRAY || v.kind < FMU_OUTPUT ||
            v.kind >= FMU_KINDS || v.slot < (v.kind == FMU_START) || misplaced ||
            v.slot > slots(model, v.kind) - size)
            return refuse(l, "resources/variables.npy: variable %ld is none", (long)k);
    }
    char *text = model->memory[NAMES] = read_text(l, FILE_NAME[NAMES], MOST_NAME * (size_t)count);
    if (!text || !checksum_fits(l, NAMES)) return 0;
    const char **name = calloc((size_t)count + 1, sizeof *name);
    model->memory[NAME_STARTS] = (void *)name;
    if (!name) return refuse(l, "out of memory");
    for (int32_t k = 0; k < count; k++) {
        char *end = strchr(text, '\n');
        if (!end) return refuse(l, "resources/names.txt: has too few names");
        *end = '\0';
        name[k] = text;
        text = end + 1;
    }
    model->variable = variable;
    model->variables = count;
    model->name = name;
    return 1;
}

/* Whatever the parameters: instances do not look again. */
static int makes_a_component(loader *l, const fmu_model *model) {
    sm_motion motion = model->motion;
    motion.wanted = 1;
    const sm_status status = sm_component_check(&model->flow, &model->contact, &motion);
    return status == SM_OK
           || refuse(l, "the resources do not make a model: %s", sm_message(status));
}

static int load_all(loader *l, fmu_model *model, const char *token) {
    const size_t files[NPY_DIMENSIONS] = {FILES};
    if (!token_fits(l, token)) return 0;
    l->checksum = read_array(l, "checksums.npy", NPY_INT32, 1, files);
    model->checksum = l->crc;
    if (!l->checksum) return 0;
    const layout *shape =
        load_array(l, model, LAYOUT, NPY_INT32, 1, sizeof *shape / sizeof(int32_t), 0, 0, 0);
    if (!shape || !layout_is_possible(l, shape)) return 0;
    const constants *given =
        load_array(l, model, CONSTANTS, NPY_FLOAT64, 1, sizeof *given / sizeof(double), 0, 0, 0);
    if (!given) return 0;
    const sm_inputs *inputs =
        load_array(l, model, INPUTS, NPY_FLOAT64, 1, sizeof *inputs / sizeof(double), 0, 0, 0);
    if (!inputs) return 0;
    model->modes = shape->modes;
    model->inputs = *inputs;
    memcpy(model->force_factor, given->force_factor, sizeof model->force_factor);
    memcpy(model->parameters, given->parameters, sizeof model->parameters);
    memcpy(model->nominal, given->nominal, sizeof model->nominal);
    memcpy(model->amplitude, given->amplitude, sizeof model->amplitude);
    memcpy(model->carrier_range, given->carrier_range, sizeof model->carrier_range);
    return load_flow(l, model, shape, given) && load_contact(l, model, shape, given) &&
           load_motion(l, model, shape, given) && load_variables(l, model, shape->variables) &&
           makes_a_component(l, model);
}

int fmu_model_load(fmu_model *model, const char *folder, const char *token,
                   char reason[FMU_REASON]) {
    loader l = {.folder = folder, .reason = reason};
    const fmu_model empty = {0};
    *model = empty;
    const int loaded = load_all(&l, model, token);
    free(l.checksum);
    if (!loaded) fmu_model_free(model);
    return loaded;
}

void fmu_model_free(fmu_model *model) {
    for (size_t k = 0; k < sizeof model->memory / sizeof *model->memory; k++) {
        free(model->memory[k]);
        model->memory[k] = NULL;
    }
}

int fmu_model_is_of(const fmu_model *model, const char *folder, const char *token) {
    const size_t files[NPY_DIMENSIONS] = {FILES};
    char reason[FMU_REASON];
    loader l = {.folder = folder, .reason = reason};
    if (!token_fits(&l, token)) return 0;
    l.checksum = read_array(&l, "checksums.npy", NPY_INT32, 1, files);
    const int same = l.checksum && l.crc == model->checksum;
    free(l.checksum);
    return same;
}

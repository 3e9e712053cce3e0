/* Loading the model from resources/. */
#include "resources/model.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "resources/files.h"

#define MOST 1000000 /* contacts, elastic outputs, nodes or variables: more is damage */

/* layout.npy */
typedef struct {
    int32_t format, modes, contacts, elastic, law, paper, combinations, power, count_a, count_b;
    int32_t corrected, detuned, inertia, elements, sliders, orders, steps_per_period, variables;
} layout;

/* constants.npy */
typedef struct {
    double alpha, memory_periods;
    double natural[SM_MODES], carrier[SM_MODES], coupling_ratio[SM_MODES][2][2];
    double off_resonance[SM_MODES][2], cross_response[SM_MODES][SM_MODES][2], force_factor[SM_MODES];
    double parameters[FMU_PARAMETERS], nominal[FMU_STATES], amplitude[2 * SM_MODES];
    double carrier_range[2];
} constants;

/* A row of contact_elements.npy: sm_element in doubles. */
enum {
    ROW_LAW, ROW_COLUMN, ROW_FIRST_SLIDER = ROW_COLUMN + 3, ROW_SLIDERS, ROW_TANGENTS,
    ROW_FRICTION, ROW_PRELOAD, ROW_TANGENTIAL_STIFFNESS, ROW_NORMAL_STIFFNESS, ROW_GAP, ROW_WIDTH
};

/* Extents of the arrays, by `count_extents`; END: there is no further dimension. */
enum {
    END, TWO, THREE, FOUR, LAYOUT_FIELDS, CONSTANT_FIELDS, INPUT_FIELDS, ROW_FIELDS, MODES,
    COMBINATION_COUNT, NODES_A, NODES_B, FIELDS, CORRECTED_A, CORRECTED_B, CORRECTED_FIELDS,
    DETUNED_A, DETUNED_B, DETUNED_FIELDS, CONTACTS, RIGID, INERTIA, ELASTIC, ELEMENT_COUNT,
    SLIDER_COUNT, OUTPUTS, ORDER_COUNT, REACTION_FIELDS, RESPONSE_FIELDS, VARIABLE_COUNT, EXTENTS
};

/* Files, in the order of checksums.npy. */
enum {
    LAYOUT, CONSTANTS, INPUTS, COMBINATIONS, NODE_A, NODE_B, TABLE, RATE_CORRECTION, DETUNING,
    LIMIT, STIFFNESS, DAMPING, MASS, COUPLING, ELEMENTS, SLIDERS, REFERENCE, ELASTIC_MODES,
    ELASTIC_FORCES, ELASTIC_CONTACTS, ORDERS, REACTION, RESPONSE, VARIABLES, NAMES, FILES
};
/* Memory besides that of the files. */
enum { NAME_STARTS = FILES, ELEMENT_RECORDS };

static const struct {
    const char *name;
    npy_type type;
    int extent[NPY_DIMENSIONS];
} FILE_OF[FILES] = {
    {"layout.npy", NPY_INT32, {LAYOUT_FIELDS}},
    {"constants.npy", NPY_FLOAT64, {CONSTANT_FIELDS}},
    {"inputs.npy", NPY_FLOAT64, {INPUT_FIELDS}},
    {"combinations.npy", NPY_INT32, {COMBINATION_COUNT, THREE}},
    {"node_a.npy", NPY_FLOAT64, {NODES_A}},
    {"node_b.npy", NPY_FLOAT64, {NODES_B}},
    {"table.npy", NPY_FLOAT64, {NODES_A, NODES_B, FOUR, FIELDS}},
    {"rate_correction.npy", NPY_FLOAT64, {CORRECTED_A, CORRECTED_B, FOUR, CORRECTED_FIELDS}},
    {"detuning.npy", NPY_FLOAT64, {DETUNED_A, DETUNED_B, FOUR, DETUNED_FIELDS}},
    {"contact_limit.npy", NPY_FLOAT64, {RIGID}},
    {"contact_stiffness.npy", NPY_FLOAT64, {CONTACTS, CONTACTS}},
    {"contact_damping.npy", NPY_FLOAT64, {RIGID, RIGID}},
    {"contact_mass.npy", NPY_FLOAT64, {INERTIA, INERTIA}},
    {"contact_coupling.npy", NPY_FLOAT64, {MODES, CONTACTS, TWO}},
    {"contact_elements.npy", NPY_FLOAT64, {ELEMENT_COUNT, ROW_FIELDS}},
    {"contact_sliders.npy", NPY_FLOAT64, {SLIDER_COUNT, TWO}},
    {"contact_reference.npy", NPY_FLOAT64, {ELASTIC}},
    {"elastic_modes.npy", NPY_FLOAT64, {OUTPUTS, MODES, TWO}},
    {"elastic_forces.npy", NPY_FLOAT64, {OUTPUTS, MODES, TWO}},
    {"elastic_contacts.npy", NPY_FLOAT64, {OUTPUTS, CONTACTS}},
    {"orders.npy", NPY_INT32, {ORDER_COUNT, TWO}},
    {"contact_reaction.npy", NPY_FLOAT64, {NODES_A, NODES_B, ORDER_COUNT, REACTION_FIELDS}},
    {"elastic_response.npy", NPY_FLOAT64, {NODES_A, NODES_B, ORDER_COUNT, RESPONSE_FIELDS}},
    {"variables.npy", NPY_INT32, {VARIABLE_COUNT, THREE}},
    {"names.txt", NPY_INT32, {END}},
};

typedef struct {
    const char *folder;
    int32_t *checksum; /* (FILES), NULL until it is read */
    uint32_t crc;      /* of the file that was read last */
    size_t extent[EXTENTS];
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

static void *read_array(loader *l, const char *name, const npy_layout *expected) {
    FILE *file = open_file(l, name);
    if (!file) return NULL;
    const char *reason;
    void *data = npy_read(file, expected, &l->crc, &reason);
    fclose(file);
    if (!data) refuse(l, "resources/%s: %s", name, reason);
    return data;
}

/* Reads the checksums of all files; returns whether there are any. */
static int read_checksums(loader *l) {
    const npy_layout expected = {.type = NPY_INT32, .dimensions = 1, .shape = {FILES}};
    l->checksum = read_array(l, "checksums.npy", &expected);
    return l->checksum != NULL;
}

static int checksum_fits(loader *l, int which) {
    if ((uint32_t)l->checksum[which] == l->crc) return 1;
    return refuse(l, "resources/%s: damaged, its checksum does not fit", FILE_OF[which].name);
}

/* Loads the arrays from `first` to before `end` into model->memory. */
static int load_arrays(loader *l, fmu_model *model, int first, int end) {
    for (int which = first; which < end; which++) {
        npy_layout expected = {.type = FILE_OF[which].type};
        for (int k = 0; k < NPY_DIMENSIONS && FILE_OF[which].extent[k] != END; k++)
            expected.shape[expected.dimensions++] = l->extent[FILE_OF[which].extent[k]];
        model->memory[which] = read_array(l, FILE_OF[which].name, &expected);
        if (!model->memory[which] || !checksum_fits(l, which)) return 0;
    }
    return 1;
}

/* Reads a text of at most `most` bytes, zero-terminated, from malloc. */
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
    char *own = read_text(l, "token.txt", 64); /* SHA-256, hexadecimal */
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

/* Computes the extents of all arrays. Arrays that the model does not need are empty. */
static void count_extents(const layout *shape, size_t extent[EXTENTS]) {
    const size_t modes = (size_t)shape->modes, contacts = (size_t)shape->contacts;
    const size_t count_a = (size_t)shape->count_a, count_b = (size_t)shape->count_b;
    const size_t corrections = 2 * modes * modes;
    const int elastic = shape->law == SM_ELASTIC;
    extent[MODES] = modes;
    extent[COMBINATION_COUNT] = (size_t)shape->combinations;
    extent[NODES_A] = count_a;
    extent[NODES_B] = count_b;
    extent[FIELDS] = 2 * (modes + (size_t)shape->combinations + (size_t)shape->power);
    extent[CORRECTED_A] = shape->corrected ? count_a : 0;
    extent[CORRECTED_B] = shape->corrected ? count_b : 0;
    extent[CORRECTED_FIELDS] = shape->corrected ? corrections : 0;
    extent[DETUNED_A] = shape->detuned ? count_a : 0;
    extent[DETUNED_B] = shape->detuned ? count_b : 0;
    extent[DETUNED_FIELDS] = shape->detuned ? corrections : 0;
    extent[CONTACTS] = contacts;
    extent[RIGID] = elastic ? 0 : contacts;
    extent[INERTIA] = shape->inertia ? contacts : 0;
    extent[ELASTIC] = elastic ? contacts : 0;
    extent[ELEMENT_COUNT] = (size_t)shape->elements;
    extent[SLIDER_COUNT] = (size_t)shape->sliders;
    extent[OUTPUTS] = (size_t)shape->elastic;
    extent[ORDER_COUNT] = (size_t)shape->orders;
    extent[REACTION_FIELDS] = 2 * contacts;
    extent[RESPONSE_FIELDS] = 2 * (size_t)shape->elastic;
    extent[VARIABLE_COUNT] = (size_t)shape->variables;
}

static void set_flow(fmu_model *model, const layout *shape, const constants *given) {
    sm_slow_flow *flow = &model->flow;
    const int32_t *combination = model->memory[COMBINATIONS];
    for (int32_t k = 0; k < shape->combinations; k++, combination += 3)
        flow->combination[k] =
            (sm_combination){combination[0], combination[1], combination[2]};
    flow->paper = shape->paper;
    memcpy(flow->natural, given->natural, sizeof flow->natural);
    memcpy(flow->carrier, given->carrier, sizeof flow->carrier);
    memcpy(flow->damping, given->parameters + FMU_DAMPING, sizeof flow->damping);
    memcpy(flow->off_resonance, given->off_resonance, sizeof flow->off_resonance);
    memcpy(flow->cross_response, given->cross_response, sizeof flow->cross_response);
    for (int j = 0; j < SM_MODES; j++)
        memcpy(flow->coupling_ratio[j].c, given->coupling_ratio[j],
               sizeof flow->coupling_ratio[j].c);
    flow->table = (sm_table){
        .modes = shape->modes,
        .combinations = shape->combinations,
        .power = shape->power,
        .count_a = shape->count_a,
        .count_b = shape->count_b,
        .node_a = model->memory[NODE_A],
        .node_b = model->memory[NODE_B],
        .values = model->memory[TABLE],
        .rate_correction = shape->corrected ? model->memory[RATE_CORRECTION] : NULL,
        .detuning = shape->detuned ? model->memory[DETUNING] : NULL};
}

/* Sets the elements of elastic contacts from their rows; integers there must be such. */
static int set_elements(loader *l, fmu_model *model, const layout *shape) {
    const double *row = model->memory[ELEMENTS];
    sm_element *element = calloc((size_t)shape->elements + 1, sizeof *element);
    model->memory[ELEMENT_RECORDS] = element;
    if (!element) return refuse(l, "out of memory");
    for (int32_t e = 0; e < shape->elements; e++, row += ROW_WIDTH) {
        int32_t integer[ROW_FRICTION];
        for (int k = 0; k < ROW_FRICTION; k++) {
            if (!(row[k] >= 0.0 && row[k] <= MOST && row[k] == floor(row[k])))
                return refuse(l, "resources/contact_elements.npy: element %ld is none", (long)e);
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
    model->elastic = (sm_elastic){.elements = shape->elements,
                                  .sliders = shape->sliders,
                                  .element = element,
                                  .slider = model->memory[SLIDERS],
                                  .reference = model->memory[REFERENCE]};
    return 1;
}

static int set_contact(loader *l, fmu_model *model, const layout *shape, const constants *given) {
    if (!set_elements(l, model, shape)) return 0;
    model->contact =
        (sm_contact){.contacts = shape->contacts,
                     .modes = shape->modes,
                     .law = shape->law,
                     .alpha = given->alpha,
                     .limit = model->memory[LIMIT],
                     .stiffness = model->memory[STIFFNESS],
                     .damping = model->memory[DAMPING],
                     .coupling = model->memory[COUPLING],
                     .mass = shape->inertia ? model->memory[MASS] : NULL,
                     .elastic = shape->law == SM_ELASTIC ? &model->elastic : NULL};
    model->motion = (sm_motion){.elastic = shape->elastic,
                                .modes_out = model->memory[ELASTIC_MODES],
                                .forces_out = model->memory[ELASTIC_FORCES],
                                .contacts_out = model->memory[ELASTIC_CONTACTS],
                                .orders_count = shape->orders,
                                .orders = model->memory[ORDERS],
                                .reaction = model->memory[REACTION],
                                .response = model->memory[RESPONSE],
                                .steps_per_period = shape->steps_per_period,
                                .memory_periods = given->memory_periods};
    const sm_status status = sm_contact_check(&model->contact);
    return status == SM_OK || refuse(l, "resources/contact_*.npy: %s", sm_message(status));
}

/* Returns the first slot that a variable of this kind does not have. */
static int32_t slots(const fmu_model *model, int32_t kind) {
    switch (kind) {
    case FMU_OUTPUT:
        return SM_OUTPUTS_FIXED + 3 * model->contact.contacts + model->motion.elastic;
    case FMU_START: return FMU_AMPLITUDE + 2 * SM_MODES;
    case FMU_INPUT: return (int32_t)(sizeof(sm_inputs) / sizeof(double));
    case FMU_PARAMETER: return FMU_PARAMETERS;
    case FMU_RATE: return FMU_STATES;
    case FMU_MODULUS:
    case FMU_PHASE: return SM_MODES;
    default: return 1;
    }
}

static int set_variables(loader *l, fmu_model *model, int32_t count) {
    const fmu_variable *variable = model->memory[VARIABLES];
    for (int32_t k = 0; k < count; k++) {
        const fmu_variable v = variable[k];
        const int array = v.type == FMU_ARRAY;
        const int32_t size = array ? model->contact.contacts : 1;
        const int32_t first = array ? SM_OUTPUTS_FIXED : v.kind == FMU_START ? FMU_AMPLITUDE : 0;
        if (v.type < FMU_REAL || v.type > FMU_ARRAY || v.kind < FMU_OUTPUT ||
            v.kind >= FMU_KINDS || (array && v.kind != FMU_OUTPUT) || v.slot < first ||
            v.slot > slots(model, v.kind) - size)
            return refuse(l, "resources/variables.npy: variable %ld is none", (long)k);
    }
    const size_t longest = 128; /* bytes of a name */
    char *text = read_text(l, FILE_OF[NAMES].name, longest * (size_t)count);
    model->memory[NAMES] = text;
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

/* Checks the model for any parameters, so that instances need not. */
static int makes_a_component(loader *l, const fmu_model *model) {
    sm_motion motion = model->motion;
    motion.wanted = 1;
    const sm_status status = sm_component_check(&model->flow, &model->contact, &motion);
    return status == SM_OK
           || refuse(l, "the resources do not make a model: %s", sm_message(status));
}

static int load_all(loader *l, fmu_model *model, const char *token) {
    if (!token_fits(l, token) || !read_checksums(l)) return 0;
    model->checksum = l->crc;
    if (!load_arrays(l, model, LAYOUT, CONSTANTS)) return 0;
    const layout *shape = model->memory[LAYOUT];
    if (!layout_is_possible(l, shape)) return 0;
    count_extents(shape, l->extent);
    if (!load_arrays(l, model, CONSTANTS, NAMES)) return 0;
    const constants *given = model->memory[CONSTANTS];
    model->modes = shape->modes;
    model->inputs = *(const sm_inputs *)model->memory[INPUTS];
    memcpy(model->force_factor, given->force_factor, sizeof model->force_factor);
    memcpy(model->parameters, given->parameters, sizeof model->parameters);
    memcpy(model->nominal, given->nominal, sizeof model->nominal);
    memcpy(model->amplitude, given->amplitude, sizeof model->amplitude);
    memcpy(model->carrier_range, given->carrier_range, sizeof model->carrier_range);
    set_flow(model, shape, given);
    return set_contact(l, model, shape, given) && set_variables(l, model, shape->variables) &&
           makes_a_component(l, model);
}

int fmu_model_load(fmu_model *model, const char *folder, const char *token,
                   char reason[FMU_REASON]) {
    loader l = {.folder = folder,
                .reason = reason,
                .extent = {[TWO] = 2, [THREE] = 3, [FOUR] = 4, [ROW_FIELDS] = ROW_WIDTH,
                           [LAYOUT_FIELDS] = sizeof(layout) / sizeof(int32_t),
                           [CONSTANT_FIELDS] = sizeof(constants) / sizeof(double),
                           [INPUT_FIELDS] = sizeof(sm_inputs) / sizeof(double)}};
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
    char reason[FMU_REASON];
    loader l = {.folder = folder, .reason = reason};
    const int same = token_fits(&l, token) && read_checksums(&l) && l.crc == model->checksum;
    free(l.checksum);
    return same;
}

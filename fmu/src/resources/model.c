/* Loading the model from resources/. */
#include "resources/model.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "resources/files.h"

#define MOST 1000000 /* contacts, elastic outputs, nodes or variables: more is damage */

/* A row of contact_elements.npy: sm_element in doubles. */
enum {
    ROW_LAW, ROW_COLUMN, ROW_FIRST_SLIDER = ROW_COLUMN + 3, ROW_SLIDERS, ROW_TANGENTS,
    ROW_FRICTION, ROW_PRELOAD, ROW_TANGENTIAL_PRELOAD,
    ROW_TANGENTIAL_STIFFNESS = ROW_TANGENTIAL_PRELOAD + 2, ROW_NORMAL_STIFFNESS, ROW_GAP, ROW_WIDTH
};

/* Extents of the arrays, set by `count`; END: there is no further dimension. */
enum {
    END, TWO, THREE, FOUR, ROW_FIELDS, LAYOUT_FIELDS, CONSTANT_FIELDS, INPUT_FIELDS, MODES,
    COMBINATIONS, NODES_A, NODES_B, FIELDS, CORRECTIONS, CONTACTS, ELEMENTS, SLIDERS, OUTPUTS,
    ORDERS, REACTIONS, RESPONSES, SAMPLES, SAMPLE_ROW, TONE_NUMBERS, VARIABLES, EXTENTS
};
/* Which models have an array. In the others its file is empty: extents from MODES on are 0. */
enum { ALL, TABLE, SAMPLED, CORRECTED, DETUNED, INERTIA, RIGID, ELASTIC, TONE, CONDITIONS };

#define FIELD(field) offsetof(fmu_model, field)
/* The arrays, in the order of checksums.npy, and the pointers to them in the model. */
static const struct {
    const char *name;
    npy_type type;
    int extent[NPY_DIMENSIONS];
    size_t field;
    int condition;
} FILES[] = {
    {"layout.npy", NPY_INT32, {LAYOUT_FIELDS}, FIELD(layout), ALL},
    {"constants.npy", NPY_FLOAT64, {CONSTANT_FIELDS}, FIELD(constants), ALL},
    {"inputs.npy", NPY_FLOAT64, {INPUT_FIELDS}, FIELD(inputs), ALL},
    {"combinations.npy", NPY_INT32, {COMBINATIONS, THREE}, FIELD(combinations), TABLE},
    {"node_a.npy", NPY_FLOAT64, {NODES_A}, FIELD(flow.table.node_a), TABLE},
    {"node_b.npy", NPY_FLOAT64, {NODES_B}, FIELD(flow.table.node_b), TABLE},
    {"table.npy", NPY_FLOAT64, {NODES_A, NODES_B, FOUR, FIELDS}, FIELD(flow.table.values), TABLE},
    {"rate_correction.npy", NPY_FLOAT64, {NODES_A, NODES_B, FOUR, CORRECTIONS},
     FIELD(flow.table.rate_correction), CORRECTED},
    {"detuning.npy", NPY_FLOAT64, {NODES_A, NODES_B, FOUR, CORRECTIONS},
     FIELD(flow.table.detuning), DETUNED},
    {"contact_limit.npy", NPY_FLOAT64, {CONTACTS}, FIELD(contact.limit), RIGID},
    {"contact_stiffness.npy", NPY_FLOAT64, {CONTACTS, CONTACTS}, FIELD(contact.stiffness), TABLE},
    {"contact_damping.npy", NPY_FLOAT64, {CONTACTS, CONTACTS}, FIELD(contact.damping), RIGID},
    {"contact_mass.npy", NPY_FLOAT64, {CONTACTS, CONTACTS}, FIELD(contact.mass), INERTIA},
    {"contact_coupling.npy", NPY_FLOAT64, {MODES, CONTACTS, TWO}, FIELD(contact.coupling), TABLE},
    {"contact_elements.npy", NPY_FLOAT64, {ELEMENTS, ROW_FIELDS}, FIELD(elements), TABLE},
    {"contact_sliders.npy", NPY_FLOAT64, {SLIDERS, TWO}, FIELD(elastic.slider), TABLE},
    {"contact_reference.npy", NPY_FLOAT64, {CONTACTS}, FIELD(elastic.reference), ELASTIC},
    {"elastic_modes.npy", NPY_FLOAT64, {OUTPUTS, MODES, TWO}, FIELD(motion.modes_out), TABLE},
    {"elastic_forces.npy", NPY_FLOAT64, {OUTPUTS, MODES, TWO}, FIELD(motion.forces_out), TABLE},
    {"elastic_contacts.npy", NPY_FLOAT64, {OUTPUTS, CONTACTS}, FIELD(motion.contacts_out), TABLE},
    {"orders.npy", NPY_INT32, {ORDERS, TWO}, FIELD(motion.orders), TABLE},
    {"contact_reaction.npy", NPY_FLOAT64, {NODES_A, NODES_B, ORDERS, REACTIONS},
     FIELD(motion.reaction), TABLE},
    {"elastic_response.npy", NPY_FLOAT64, {NODES_A, NODES_B, ORDERS, RESPONSES},
     FIELD(motion.response), TABLE},
    {"samples.npy", NPY_FLOAT64, {SAMPLES, SAMPLE_ROW}, FIELD(samples), SAMPLED},
    {"tone.npy", NPY_FLOAT64, {TONE_NUMBERS}, FIELD(tone_numbers), TONE},
    {"variables.npy", NPY_INT32, {VARIABLES, THREE}, FIELD(variable), ALL},
};
enum { ARRAYS = sizeof FILES / sizeof *FILES, NAMES = ARRAYS, NAME_STARTS, ELEMENT_RECORDS };

typedef struct {
    const char *folder;
    int32_t *checksum; /* (ARRAYS + 1), of names.txt too; NULL until it is read */
    uint32_t crc;      /* of the file that was read last */
    size_t extent[EXTENTS];
    int has[CONDITIONS];
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
    const npy_layout expected = {.type = NPY_INT32, .dimensions = 1, .shape = {ARRAYS + 1}};
    l->checksum = read_array(l, "checksums.npy", &expected);
    return l->checksum != NULL;
}

static int checksum_fits(loader *l, int which, const char *name) {
    if ((uint32_t)l->checksum[which] == l->crc) return 1;
    return refuse(l, "resources/%s: damaged, its checksum does not fit", name);
}

/* Loads the arrays from `first` to before `end`. */
static int load_arrays(loader *l, fmu_model *model, int first, int end) {
    for (int k = first; k < end; k++) {
        const int present = l->has[FILES[k].condition];
        npy_layout expected = {.type = FILES[k].type};
        for (int d = 0; d < NPY_DIMENSIONS && FILES[k].extent[d] != END; d++) {
            const int extent = FILES[k].extent[d];
            expected.shape[expected.dimensions++] =
                present || extent < MODES ? l->extent[extent] : 0;
        }
        model->memory[k] = read_array(l, FILES[k].name, &expected);
        if (!model->memory[k] || !checksum_fits(l, k, FILES[k].name)) return 0;
        if (present)
            memcpy((char *)model + FILES[k].field, &model->memory[k], sizeof model->memory[k]);
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
        refuse(l, "resources/%s: %s", name, text ? "longer than it may be" : "out of memory");
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

static int layout_is_possible(loader *l, const fmu_layout *shape) {
    if (shape->format != FMU_FORMAT)
        return refuse(l, "resources/layout.npy: version %ld must be %d for this binary",
                      (long)shape->format, FMU_FORMAT);
    const int32_t counts[] = {shape->contacts, shape->elastic,  shape->combinations,
                              shape->elements, shape->sliders,  shape->orders,
                              shape->count_a,  shape->count_b,  shape->variables, shape->samples,
                              shape->modes,    shape->kinds,    shape->nodes,
                              shape->shares,   shape->slow[0],  shape->slow[1],
                              shape->fast[0],  shape->fast[1],  shape->retained[0],
                              shape->retained[1]};
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++)
        if (counts[k] < 0 || counts[k] > MOST)
            return refuse(l, "resources/layout.npy: damaged, has a count of %ld", (long)counts[k]);
    const int32_t retained = shape->retained[0] + shape->retained[1];
    const int possible =
        shape->kinds > 0 ? shape->modes == retained : shape->modes <= SM_MODES;
    if (shape->modes < 1 || !possible || shape->combinations > SM_COMBINATIONS)
        return refuse(l, "resources/layout.npy: damaged, has %ld modes and %ld combinations",
                      (long)shape->modes, (long)shape->combinations);
    return 1;
}

/* Sets the extents of arrays, and the conditions that the model fulfils. */
static void count(const fmu_layout *shape, size_t extent[EXTENTS], int has[CONDITIONS]) {
    const size_t modes = (size_t)shape->modes, contacts = (size_t)shape->contacts;
    extent[MODES] = modes;
    extent[COMBINATIONS] = (size_t)shape->combinations;
    extent[NODES_A] = (size_t)shape->count_a;
    extent[NODES_B] = (size_t)shape->count_b;
    extent[FIELDS] = 2 * (modes + (size_t)shape->combinations + (size_t)shape->power);
    extent[CORRECTIONS] = 2 * modes * modes;
    extent[CONTACTS] = contacts;
    extent[ELEMENTS] = (size_t)shape->elements;
    extent[SLIDERS] = (size_t)shape->sliders;
    extent[OUTPUTS] = (size_t)shape->elastic;
    extent[ORDERS] = (size_t)shape->orders;
    extent[REACTIONS] = 2 * contacts;
    extent[RESPONSES] = 2 * (size_t)shape->elastic;
    extent[SAMPLES] = (size_t)shape->samples;
    extent[SAMPLE_ROW] = sizeof(fmu_sample) / sizeof(double)
                         + 4 * extent[NODES_A] * extent[NODES_B]
                               * (extent[FIELDS] + extent[CORRECTIONS])
                         + 2 * modes * extent[OUTPUTS];
    sm_tone tone;
    extent[TONE_NUMBERS] = fmu_tone_numbers(shape, NULL, &tone);
    extent[VARIABLES] = (size_t)shape->variables;
    has[TONE] = shape->kinds > 0;
    has[TABLE] = !has[TONE];
    has[SAMPLED] = has[TABLE] && shape->samples > 0;
    has[CORRECTED] = has[TABLE] && shape->corrected;
    has[DETUNED] = has[TABLE] && shape->detuned;
    has[INERTIA] = has[TABLE] && shape->inertia;
    has[ELASTIC] = has[TABLE] && shape->law == SM_ELASTIC;
    has[RIGID] = has[TABLE] && !has[ELASTIC];
}

static void set_flow(fmu_model *model, const fmu_layout *shape, const fmu_constants *given) {
    sm_slow_flow *flow = &model->flow;
    const int32_t *term = model->combinations;
    for (int32_t k = 0; k < shape->combinations; k++, term += 3)
        flow->combination[k] = (sm_combination){term[0], term[1], term[2]};
    flow->paper = shape->paper;
    flow->ratio = given->ratio;
    memcpy(flow->hardening, given->hardening, sizeof flow->hardening);
    memcpy(flow->natural, given->natural, sizeof flow->natural);
    memcpy(flow->spin, given->spin, sizeof flow->spin);
    memcpy(flow->carrier, given->carrier, sizeof flow->carrier);
    memcpy(flow->damping, given->parameters + FMU_DAMPING, sizeof flow->damping);
    memcpy(flow->off_resonance, given->off_resonance, sizeof flow->off_resonance);
    memcpy(flow->cross_response, given->cross_response, sizeof flow->cross_response);
    memcpy(flow->other_modes, given->other_modes, sizeof flow->other_modes);
    for (int j = 0; j < SM_MODES; j++)
        memcpy(flow->coupling_ratio[j], given->coupling_ratio[j],
               sizeof flow->coupling_ratio[j]);
    flow->table.modes = shape->modes;
    flow->table.combinations = shape->combinations;
    flow->table.power = shape->power;
    flow->table.count_a = shape->count_a;
    flow->table.count_b = shape->count_b;
}

void fmu_set_parameters(const fmu_model *model, const double *parameters, sm_slow_flow *flow,
                        sm_motion *motion) {
    const double *own = model->constants->parameters + FMU_DAMPING;
    const double sample = parameters[FMU_SAMPLE];
    *flow = model->flow;
    *motion = model->motion;
    motion->wanted = parameters[FMU_CONTACT_WANTED] != 0.0;
    memcpy(flow->damping, parameters + FMU_DAMPING, sizeof flow->damping);
    if (!(sample >= 1.0 && sample <= model->layout->samples)) return;
    const double *row = model->samples + ((size_t)sample - 1) * model->sample_width;
    const size_t *extent = model->sample_extent;
    fmu_sample given;
    memcpy(&given, row, sizeof given);
    memcpy(flow->natural, given.natural, sizeof flow->natural);
    memcpy(flow->cross_response, given.cross_response, sizeof flow->cross_response);
    memcpy(flow->other_modes, given.other_modes, sizeof flow->other_modes);
    /* a change of the parameter from the model's damping changes the sample's damping by as much */
    for (size_t j = 0; j < SM_MODES; j++)
        flow->damping[j] = given.damping[j] + (flow->damping[j] - own[j]);
    flow->table.values = row + sizeof given / sizeof(double);
    flow->table.rate_correction = flow->table.values + extent[0];
    motion->forces_out = flow->table.rate_correction + extent[1];
}

/* Sets the elements of elastic contacts from their rows; integers there must be such. */
static int set_elements(loader *l, fmu_model *model, const fmu_layout *shape) {
    const double *row = model->elements;
    sm_element *element = calloc((size_t)shape->elements + 1, sizeof *element);
    model->memory[ELEMENT_RECORDS] = element;
    if (!element) return refuse(l, "out of memory");
    for (int32_t e = 0; e < shape->elements; e++, row += ROW_WIDTH) {
        int32_t integer[ROW_FRICTION];
        for (int k = 0; k < ROW_FRICTION; k++) {
            if (!(row[k] >= 0.0 && row[k] <= MOST && row[k] == floor(row[k])))
                return refuse(l, "resources/contact_elements.npy: element %ld is damaged", (long)e);
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
        memcpy(element[e].tangential_preload, row + ROW_TANGENTIAL_PRELOAD,
               sizeof element[e].tangential_preload);
        memcpy(element[e].column, integer + ROW_COLUMN, sizeof element[e].column);
    }
    model->elastic.elements = shape->elements;
    model->elastic.sliders = shape->sliders;
    model->elastic.element = element;
    return 1;
}

static int set_contact(loader *l, fmu_model *model, const fmu_layout *shape) {
    if (!set_elements(l, model, shape)) return 0;
    model->contact.contacts = shape->contacts;
    model->contact.modes = shape->modes;
    model->contact.law = shape->law;
    model->contact.alpha = model->constants->alpha;
    model->contact.elastic = l->has[ELASTIC] ? &model->elastic : NULL;
    model->motion.elastic = shape->elastic;
    model->motion.orders_count = shape->orders;
    model->motion.steps_per_period = shape->steps_per_period;
    model->motion.memory_periods = model->constants->memory_periods;
    const sm_status status = sm_contact_check(&model->contact);
    return status == SM_OK || refuse(l, "resources/contact_*.npy: %s", sm_message(status));
}

/* Returns the first slot that a variable of this kind does not have. */
static int32_t slots(const fmu_model *model, int32_t kind) {
    switch (kind) {
    case FMU_OUTPUT: return model->outputs;
    case FMU_START: return model->shares_tone ? 0 : FMU_AMPLITUDE + 2 * SM_MODES;
    case FMU_INPUT: return (int32_t)(sizeof(sm_inputs) / sizeof(double));
    case FMU_PARAMETER: return FMU_PARAMETERS;
    case FMU_RATE: return model->shares_tone ? 0 : FMU_STATES;
    case FMU_MODULUS:
    case FMU_PHASE: return model->shares_tone ? model->modes : SM_MODES;
    default: return model->shares_tone ? 0 : 1;
    }
}

static int set_variables(loader *l, fmu_model *model, int32_t count) {
    const fmu_variable *variable = model->variable;
    for (int32_t k = 0; k < count; k++) {
        const fmu_variable v = variable[k];
        const int array = v.type == FMU_ARRAY;
        const int32_t size = array ? model->contacts : 1;
        const int32_t first =
            array ? model->slow_outputs : v.kind == FMU_START ? FMU_AMPLITUDE : 0;
        if (v.type < FMU_REAL || v.type > FMU_ARRAY || v.kind < FMU_OUTPUT ||
            v.kind >= FMU_KINDS || (array && v.kind != FMU_OUTPUT) || v.slot < first ||
            v.slot > slots(model, v.kind) - size)
            return refuse(l, "resources/variables.npy: variable %ld is damaged", (long)k);
    }
    const size_t longest = 128; /* bytes of a name */
    char *text = read_text(l, "names.txt", longest * (size_t)count);
    model->memory[NAMES] = text;
    if (!text || !checksum_fits(l, NAMES, "names.txt")) return 0;
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
    model->variables = count;
    model->name = name;
    return 1;
}

/* Sets the counts of outputs, as sm_component_outputs or sm_tone_outputs packs them. */
static void set_outputs(fmu_model *model, const fmu_layout *shape) {
    model->shares_tone = shape->kinds > 0;
    model->modes = shape->modes;
    model->contacts = shape->contacts;
    const int32_t tones = shape->slow[1] > 0 ? 2 : 1;
    model->slow_outputs = model->shares_tone ? 2 * shape->modes + tones + 4 : SM_OUTPUTS_FIXED;
    model->outputs = model->slow_outputs + 3 * shape->contacts + shape->elastic;
}

static int is_model(loader *l, sm_status status) {
    return status == SM_OK
           || refuse(l, "the resources do not make a model: %s", sm_message(status));
}

static int set_tone(loader *l, fmu_model *model, const fmu_layout *shape) {
    memcpy(model->flow.natural, model->constants->natural, sizeof model->flow.natural);
    fmu_tone_numbers(shape, model->tone_numbers, &model->tone);
    model->tones = model->tone.tones;
    sm_tone_flow *made = NULL;
    const sm_status status =
        sm_tone_create(&model->tone, model->constants->parameters[FMU_TOLERANCE], &made);
    sm_tone_free(made);
    return is_model(l, status);
}

static int set_table(loader *l, fmu_model *model, const fmu_layout *shape) {
    set_flow(model, shape, model->constants);
    const size_t values = 4 * l->extent[NODES_A] * l->extent[NODES_B];
    model->sample_width = l->extent[SAMPLE_ROW];
    model->sample_extent[0] = values * l->extent[FIELDS];
    model->sample_extent[1] = values * l->extent[CORRECTIONS];
    model->tones = model->flow.ratio != 0.0 ? 1 : shape->modes;
    if (!set_contact(l, model, shape)) return 0;
    sm_motion motion = model->motion; /* checked for any parameters, so that instances need not */
    motion.wanted = 1;
    return is_model(l, sm_component_check(&model->flow, &model->contact, &motion));
}

static int load_all(loader *l, fmu_model *model, const char *token) {
    if (!token_fits(l, token) || !read_checksums(l)) return 0;
    model->checksum = l->crc;
    if (!load_arrays(l, model, 0, 1) || !layout_is_possible(l, model->layout)) return 0;
    const fmu_layout *shape = model->layout;
    count(shape, l->extent, l->has);
    if (!load_arrays(l, model, 1, ARRAYS)) return 0;
    set_outputs(model, shape);
    if (!(model->shares_tone ? set_tone(l, model, shape) : set_table(l, model, shape))) return 0;
    return set_variables(l, model, shape->variables);
}

int fmu_model_load(fmu_model *model, const char *folder, const char *token,
                   char reason[FMU_REASON]) {
    loader l = {.folder = folder,
                .reason = reason,
                .has = {[ALL] = 1},
                .extent = {[TWO] = 2, [THREE] = 3, [FOUR] = 4, [ROW_FIELDS] = ROW_WIDTH,
                           [LAYOUT_FIELDS] = sizeof(fmu_layout) / sizeof(int32_t),
                           [CONSTANT_FIELDS] = sizeof(fmu_constants) / sizeof(double),
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

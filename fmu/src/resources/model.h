/* The content of resources/: the reduced model and its list of variables. */
#ifndef FMU_MODEL_H
#define FMU_MODEL_H

#include "slipmode.h"

#define FMU_FORMAT 15  /* of resources/; raised whenever older ones must be refused */
#define FMU_REASON 256 /* bytes of a sentence that says what is wrong */
#define FMU_STATES (3 * SM_MODES + 1)

/* The internal tolerance; fmu/variables/listing.py has the same limits. */
#define FMU_LEAST_TOLERANCE 1e-13
#define FMU_MOST_TOLERANCE 1e-2

/* Slots of parameters. */
enum { FMU_DAMPING = 0, FMU_TOLERANCE = SM_MODES, FMU_CONTACT_WANTED, FMU_SAMPLE, FMU_PARAMETERS };

/* Slots of outputs of one or two modes, as sm_component_outputs packs them: the time, (Re, Im) of the amplitudes, the
 * carrier angles, input and dissipated power, dissipated energy. */
enum { FMU_AMPLITUDE = 1, FMU_ANGLE = 5, FMU_POWER = 7, FMU_ENERGY = 9 };

/* Type of a variable. */
enum {
    FMU_REAL = 0, FMU_ENUMERATION, FMU_BOOLEAN,
    FMU_ARRAY /* of reals: an output of every contact, from the slot on */
};

/* Kind of a variable, and what its slot counts: fmu/variables/variable.py has the same. */
enum {
    FMU_OUTPUT = 0, /* outputs of sm_component_outputs or sm_tone_outputs; first the time */
    FMU_START,      /* likewise, an amplitude, which may be set before the start */
    FMU_INPUT,      /* doubles of sm_inputs */
    FMU_PARAMETER,
    FMU_RATE,       /* derivatives of the states */
    FMU_MODULUS,    /* modes */
    FMU_PHASE,      /* modes */
    FMU_MARGIN,     /* one: where the amplitudes are in the friction table */
    FMU_KINDS
};

typedef struct {
    int32_t type, kind, slot;
} fmu_variable;

/* layout.npy; `kinds` and what follows are counts of sm_tone, and 0 in models with a friction table:
 * kinds of contacts, nodes; slow, fast and retained modes of each tone. */
typedef struct {
    int32_t format, modes, contacts, elastic, law, paper, combinations, power, count_a, count_b;
    int32_t corrected, detuned, inertia, elements, sliders, orders, steps_per_period;
    int32_t samples, variables;
    int32_t kinds, nodes, shares;
    int32_t slow[SM_MODES], fast[SM_MODES], retained[SM_MODES];
} fmu_layout;

/* constants.npy */
typedef struct {
    double alpha, memory_periods;
    double natural[SM_MODES], spin[SM_MODES], carrier[SM_MODES];
    double coupling_ratio[SM_MODES][2][2];
    double off_resonance[SM_MODES][2], cross_response[SM_MODES][SM_MODES][2];
    double other_modes[SM_MODES][2][2];
    double force_factor[SM_MODES];     /* modal force per newton of the force input */
    double parameters[FMU_PARAMETERS]; /* start values */
    double nominal[FMU_STATES];        /* of the states, absent modes left out */
    double amplitude[2 * SM_MODES];    /* start values of Re, Im of a_j */
    double middle[SM_MODES];           /* forcing frequency of which carrier_range is a multiple */
    double carrier_range[2];           /* allowed forcing frequencies, relative to the middle */
    double ratio;                      /* of the carriers of two modes on one tone, else 0 */
    double hardening[SM_MODES][SM_MODES];
} fmu_constants;

/* What differs between the samples: a row of samples.npy begins with it. The friction table, its
 * rate correction and motion.forces_out follow. */
typedef struct {
    double natural[SM_MODES], damping[SM_MODES];
    double cross_response[SM_MODES][SM_MODES][2], other_modes[SM_MODES][2][2];
} fmu_sample;

typedef struct {
    const fmu_layout *layout;
    const fmu_constants *constants;
    const sm_inputs *inputs;           /* start values */
    int32_t modes, tones, contacts, variables;
    int32_t slow_outputs, outputs;     /* outputs before the motion of contacts and DOFs; all */
    int shares_tone;                   /* whether it has `tone` instead of what follows */
    sm_tone tone;
    sm_slow_flow flow;
    sm_contact contact;
    sm_elastic elastic;                /* of the contact, if its law is elastic */
    sm_motion motion;
    const int32_t *combinations;       /* (combinations, 3) mode, n, m */
    const double *elements;            /* sm_element in doubles */
    const double *tone_numbers;
    const double *samples;             /* rows of `sample_width` doubles */
    size_t sample_width, sample_extent[2]; /* doubles of a row, its table, its rate correction */
    const fmu_variable *variable;      /* (variables), by value reference */
    const char **name;                 /* (variables), likewise */
    uint32_t checksum;                 /* of all files */
    void *memory[32];                  /* what the pointers above point into */
} fmu_model;

/* Returns how many numbers a tone has. Its counts are set, and its pointers and numbers from `number`
 * unless that is NULL. */
size_t fmu_tone_numbers(const fmu_layout *shape, const double *number, sm_tone *tone);

/* Loads the model of the FMU with this token from its resource folder; 0: `reason` says why not,
 * and there is nothing to free. */
int fmu_model_load(fmu_model *model, const char *folder, const char *token,
                   char reason[FMU_REASON]);
void fmu_model_free(fmu_model *model);
/* Returns whether the model was read from the folder with this token (by checksums). */
int fmu_model_is_of(const fmu_model *model, const char *folder, const char *token);

/* Sets the flow and the motion of a model with these parameters: its damping and its sample. */
void fmu_set_parameters(const fmu_model *model, const double *parameters, sm_slow_flow *flow,
                        sm_motion *motion);

/* Returns the model that all instances of this folder share, to be released; NULL: `reason` says
 * why there is none. May be called from any thread. */
const fmu_model *fmu_model_acquire(const char *folder, const char *token,
                                   char reason[FMU_REASON]);
void fmu_model_release(const fmu_model *model);

#endif

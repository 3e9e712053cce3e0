/* What resources/ holds: the reduced model and its list of variables. */
#ifndef FMU_MODEL_H
#define FMU_MODEL_H

#include "slipmode.h"

#define FMU_FORMAT 9      /* of resources/; raised whenever older ones must be refused */
#define FMU_REASON 256    /* bytes of a sentence that says what is wrong */
#define FMU_TOKEN 64      /* characters of the instantiation token */
#define FMU_PARAMETERS 4  /* slots of FMU_PARAMETER: see below */
#define FMU_STATES (3 * SM_MODES + 1)

/* Parameters, by slot. */
enum { FMU_DAMPING = 0, FMU_TOLERANCE = SM_MODES, FMU_CONTACT_WANTED };

/* Type of a variable. */
enum {
    FMU_REAL = 0, FMU_ENUMERATION, FMU_BOOLEAN,
    FMU_ARRAY /* of reals: an output of every contact, from the slot on */
};

/* What a variable is, and what its slot counts. */
enum {
    FMU_OUTPUT = 0, /* outputs of sm_component_outputs; the time is the first of them */
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

typedef struct {
    int32_t modes, variables;
    sm_slow_flow flow;
    sm_contact contact;
    sm_elastic elastic;                /* of the contact, where its law is that */
    sm_motion motion;
    double force_factor[SM_MODES];     /* modal force per newton of the force input */
    double parameters[FMU_PARAMETERS]; /* start values */
    double nominal[FMU_STATES];        /* of the states, the modes that are not there left out */
    double amplitude[2 * SM_MODES];    /* start values of Re, Im of a_j */
    double carrier_range[2];           /* of forcing frequencies, relative to the natural one */
    sm_inputs inputs;                  /* start values */
    const fmu_variable *variable;      /* (variables), by value reference */
    const char **name;                 /* (variables), likewise */
    uint32_t checksum;                 /* of all files */
    void *memory[32];                  /* what the pointers above point into */
} fmu_model;

/* Loads the model of the FMU with this token from its resource folder; 0: `reason` says why not,
 * and there is nothing to free. */
int fmu_model_load(fmu_model *model, const char *folder, const char *token,
                   char reason[FMU_REASON]);
void fmu_model_free(fmu_model *model);
/* Whether the model is the one of that folder and token, as far as its list of checksums says. */
int fmu_model_is_of(const fmu_model *model, const char *folder, const char *token);

#endif

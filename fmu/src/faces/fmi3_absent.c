/* FMI 3.0: calls for what the FMU does not have. They are refused, with the reason logged. */
#include "faces/fmi3.h"

/* No variable has this type: only nothing can be asked for. */
#define NO_SUCH_TYPE(type)                                                                     \
    fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference vr[], size_t count,      \
                             fmi3##type value[], size_t values) {                              \
        (void)vr, (void)value;                                                                 \
        ALLOW(READABLE, "fmi3Get" #type);                                                      \
        REFUSE_IF(count > 0 || values > 0, "fmi3Get" #type ": no variable has this type");     \
        return fmi3OK;                                                                         \
    }                                                                                          \
    NO_SETTER(type)
#define NO_SETTER(type)                                                                        \
    fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference vr[], size_t count,      \
                             const fmi3##type value[], size_t values) {                        \
        (void)vr, (void)value;                                                                 \
        ALLOW(FMU_BEFORE_START | FMU_RUNNING, "fmi3Set" #type);                                \
        REFUSE_IF(count > 0 || values > 0, "fmi3Set" #type ": no variable of this type is set");\
        return fmi3OK;                                                                         \
    }

NO_SUCH_TYPE(Float32)
NO_SUCH_TYPE(Int8)
NO_SUCH_TYPE(UInt8)
NO_SUCH_TYPE(Int16)
NO_SUCH_TYPE(UInt16)
NO_SUCH_TYPE(Int32)
NO_SUCH_TYPE(UInt32)
NO_SETTER(Int64)
NO_SUCH_TYPE(UInt64)
NO_SUCH_TYPE(String)

#define REFUSE(name, reason)       \
    do {                           \
        ALLOW(FMU_ANY, name);      \
        REFUSE_IF(1, name reason); \
    } while (0)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                         size_t sizes[], fmi3Binary value[], size_t values) {
    (void)vr, (void)count, (void)sizes, (void)value, (void)values;
    REFUSE("fmi3GetBinary", ": no variable has this type");
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                         const size_t sizes[], const fmi3Binary value[], size_t values) {
    (void)vr, (void)count, (void)sizes, (void)value, (void)values;
    REFUSE("fmi3SetBinary", ": no variable has this type");
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                        fmi3Clock value[]) {
    (void)vr, (void)count, (void)value;
    REFUSE("fmi3GetClock", ": there are no clocks");
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                        const fmi3Clock value[]) {
    (void)vr, (void)count, (void)value;
    REFUSE("fmi3SetClock", ": there are no clocks");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference vr,
                                               size_t *count) {
    (void)vr, (void)count;
    REFUSE("fmi3GetNumberOfVariableDependencies", ": those of the model description are all");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference dependent,
                                       size_t element[], fmi3ValueReference independent[],
                                       size_t independent_element[], fmi3DependencyKind kind[],
                                       size_t count) {
    (void)dependent, (void)element, (void)independent, (void)independent_element;
    (void)kind, (void)count;
    REFUSE("fmi3GetVariableDependencies", ": those of the model description are all");
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) {
    REFUSE("fmi3EnterConfigurationMode", ": there are no structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
    REFUSE("fmi3ExitConfigurationMode", ": there are no structural parameters");
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                                  fmi3Float64 interval[], fmi3IntervalQualifier qualifier[]) {
    (void)vr, (void)count, (void)interval, (void)qualifier;
    REFUSE("fmi3GetIntervalDecimal", ": there are no clocks");
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                                   fmi3UInt64 counter[], fmi3UInt64 resolution[],
                                   fmi3IntervalQualifier qualifier[]) {
    (void)vr, (void)count, (void)counter, (void)resolution, (void)qualifier;
    REFUSE("fmi3GetIntervalFraction", ": there are no clocks");
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                               fmi3Float64 shift[]) {
    (void)vr, (void)count, (void)shift;
    REFUSE("fmi3GetShiftDecimal", ": there are no clocks");
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                                fmi3UInt64 counter[], fmi3UInt64 resolution[]) {
    (void)vr, (void)count, (void)counter, (void)resolution;
    REFUSE("fmi3GetShiftFraction", ": there are no clocks");
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                                  const fmi3Float64 interval[]) {
    (void)vr, (void)count, (void)interval;
    REFUSE("fmi3SetIntervalDecimal", ": there are no clocks");
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                                   const fmi3UInt64 counter[], const fmi3UInt64 resolution[]) {
    (void)vr, (void)count, (void)counter, (void)resolution;
    REFUSE("fmi3SetIntervalFraction", ": there are no clocks");
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                               const fmi3Float64 shift[]) {
    (void)vr, (void)count, (void)shift;
    REFUSE("fmi3SetShiftDecimal", ": there are no clocks");
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference vr[], size_t count,
                                const fmi3UInt64 counter[], const fmi3UInt64 resolution[]) {
    (void)vr, (void)count, (void)counter, (void)resolution;
    REFUSE("fmi3SetShiftFraction", ": there are no clocks");
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) {
    REFUSE("fmi3EvaluateDiscreteStates", ": there are no discrete states");
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock,
                                      fmi3Float64 time) {
    (void)clock, (void)time;
    REFUSE("fmi3ActivateModelPartition", ": there are no clocks");
}

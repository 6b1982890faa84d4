/* What FMI 3.0 asks a library to have, and what this FMU's description says that it cannot do. */
#include "fmi3Functions.h"

#define GET_AND_SET(type)                                                                         \
    fmi3Status fmi3Get##type(                                                                     \
        fmi3Instance c, const fmi3ValueReference refs[], size_t count, fmi3##type values[],       \
        size_t value_count)                                                                       \
    {                                                                                             \
        (void)c, (void)refs, (void)count, (void)values, (void)value_count;                        \
        return count == 0 ? fmi3OK : fmi3Error;                                                   \
    }                                                                                             \
    fmi3Status fmi3Set##type(                                                                     \
        fmi3Instance c, const fmi3ValueReference refs[], size_t count, const fmi3##type values[], \
        size_t value_count)                                                                       \
    {                                                                                             \
        (void)c, (void)refs, (void)count, (void)values, (void)value_count;                        \
        return count == 0 ? fmi3OK : fmi3Error;                                                   \
    }

GET_AND_SET(Float32)
GET_AND_SET(Int8)
GET_AND_SET(UInt8)
GET_AND_SET(Int16)
GET_AND_SET(UInt16)
GET_AND_SET(UInt32)
GET_AND_SET(Int64)
GET_AND_SET(UInt64)

#define CHANGE_MODE(name)       \
    fmi3Status name(fmi3Instance c) \
    {                           \
        (void)c;                \
        return fmi3Error;       \
    }

CHANGE_MODE(fmi3EnterConfigurationMode)
CHANGE_MODE(fmi3ExitConfigurationMode)
CHANGE_MODE(fmi3EvaluateDiscreteStates)

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)log, (void)update, (void)lock, (void)unlock;
    return NULL;
}

fmi3Status fmi3GetNumberOfVariableDependencies(
    fmi3Instance c, fmi3ValueReference ref, size_t *count)
{
    (void)c, (void)ref;
    *count = 0;
    return fmi3Error;
}

fmi3Status fmi3GetVariableDependencies(
    fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
    fmi3ValueReference independents[], size_t independent_elements[],
    fmi3DependencyKind kinds[], size_t count)
{
    (void)c, (void)dependent, (void)elements, (void)independents, (void)independent_elements;
    (void)kinds, (void)count;
    return fmi3Error;
}

#define OF_CLOCKS(name, type)                                                                 \
    fmi3Status name(                                                                          \
        fmi3Instance c, const fmi3ValueReference refs[], size_t count, type values[])         \
    {                                                                                         \
        (void)c, (void)refs, (void)values;                                                    \
        return count == 0 ? fmi3OK : fmi3Error;                                               \
    }
#define OF_CLOCKS_IN_PARTS(name, type)                                                        \
    fmi3Status name(                                                                          \
        fmi3Instance c, const fmi3ValueReference refs[], size_t count, type counters[],       \
        type resolutions[])                                                                   \
    {                                                                                         \
        (void)c, (void)refs, (void)counters, (void)resolutions;                               \
        return count == 0 ? fmi3OK : fmi3Error;                                               \
    }

OF_CLOCKS(fmi3GetShiftDecimal, fmi3Float64)
OF_CLOCKS(fmi3SetShiftDecimal, const fmi3Float64)
OF_CLOCKS(fmi3SetIntervalDecimal, const fmi3Float64)
OF_CLOCKS_IN_PARTS(fmi3GetShiftFraction, fmi3UInt64)
OF_CLOCKS_IN_PARTS(fmi3SetShiftFraction, const fmi3UInt64)
OF_CLOCKS_IN_PARTS(fmi3SetIntervalFraction, const fmi3UInt64)

fmi3Status fmi3GetIntervalFraction(
    fmi3Instance c, const fmi3ValueReference refs[], size_t count, fmi3UInt64 counters[],
    fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)c, (void)refs, (void)counters, (void)resolutions, (void)qualifiers;
    return count == 0 ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetOutputDerivatives(
    fmi3Instance c, const fmi3ValueReference refs[], size_t count, const fmi3Int32 orders[],
    fmi3Float64 values[], size_t value_count)
{
    (void)c, (void)refs, (void)orders, (void)values, (void)value_count;
    return count == 0 ? fmi3OK : fmi3Error;
}

fmi3Status fmi3ActivateModelPartition(
    fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time)
{
    (void)c, (void)clock, (void)time;
    return fmi3Error;
}

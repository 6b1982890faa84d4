/* Functions that FMI 3.0 requires in a library, but that this FMU does not support according to its
   description. fmi3.c includes this. */
#ifndef FMI3_REFUSED_H
#define FMI3_REFUSED_H

#define REFUSED(NAME) outcome(c, "this FMU does not support " #NAME)
#define NONE_OF(NAME, PARAMETERS, UNUSED)                                                        \
    fmi3Status NAME(fmi3Instance c, const fmi3ValueReference refs[], size_t count, PARAMETERS)   \
    {                                                                                            \
        (void)refs, UNUSED;                                                                      \
        return count == 0 ? fmi3OK : REFUSED(NAME);                                              \
    }
#define GET_AND_SET(type)                                                                        \
    NONE_OF(fmi3Get##type, fmi3##type values[] AND size_t value_count,                          \
            (void)values AND (void)value_count)                                                 \
    NONE_OF(fmi3Set##type, const fmi3##type values[] AND size_t value_count,                    \
            (void)values AND (void)value_count)

GET_AND_SET(Float32)
GET_AND_SET(Int8)
GET_AND_SET(UInt8)
GET_AND_SET(Int16)
GET_AND_SET(UInt16)
GET_AND_SET(UInt32)
GET_AND_SET(Int64)
GET_AND_SET(UInt64)

#define CHANGE_MODE(NAME)           \
    fmi3Status NAME(fmi3Instance c) \
    {                               \
        return REFUSED(NAME);       \
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
    (void)name, (void)resources, (void)visible, (void)logging;
    (void)update, (void)lock, (void)unlock;
    return instantiated(
        token, environment, log, false, "this FMU does not support scheduled execution");
}

fmi3Status fmi3GetNumberOfVariableDependencies(
    fmi3Instance c, fmi3ValueReference ref, size_t *count)
{
    (void)ref, (void)count;
    return REFUSED(fmi3GetNumberOfVariableDependencies);
}

fmi3Status fmi3GetVariableDependencies(
    fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
    fmi3ValueReference independents[], size_t independent_elements[],
    fmi3DependencyKind kinds[], size_t count)
{
    (void)dependent, (void)elements, (void)independents, (void)independent_elements, (void)kinds;
    (void)count;
    return REFUSED(fmi3GetVariableDependencies);
}

NONE_OF(fmi3GetShiftDecimal, fmi3Float64 shifts[], (void)shifts)
NONE_OF(fmi3SetShiftDecimal, const fmi3Float64 shifts[], (void)shifts)
NONE_OF(fmi3SetIntervalDecimal, const fmi3Float64 intervals[], (void)intervals)
NONE_OF(fmi3GetShiftFraction, fmi3UInt64 counters[] AND fmi3UInt64 resolutions[],
        (void)counters AND (void)resolutions)
NONE_OF(fmi3SetShiftFraction, const fmi3UInt64 counters[] AND const fmi3UInt64 resolutions[],
        (void)counters AND (void)resolutions)
NONE_OF(fmi3SetIntervalFraction, const fmi3UInt64 counters[] AND const fmi3UInt64 resolutions[],
        (void)counters AND (void)resolutions)
NONE_OF(fmi3GetIntervalFraction,
        fmi3UInt64 counters[] AND fmi3UInt64 resolutions[] AND fmi3IntervalQualifier found[],
        (void)counters AND (void)resolutions AND (void)found)
NONE_OF(fmi3GetOutputDerivatives,
        const fmi3Int32 orders[] AND fmi3Float64 values[] AND size_t value_count,
        (void)orders AND (void)values AND (void)value_count)

fmi3Status fmi3ActivateModelPartition(
    fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time)
{
    (void)clock, (void)time;
    return REFUSED(fmi3ActivateModelPartition);
}

#endif

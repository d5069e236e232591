/* A scene has variables of one type. */
#define FMI3_NONE(what, type)                                                                                                                        \
    FMI3_EXPORT fmi3Status fmi3Get##what(fmi3Instance it, const fmi3ValueReference refs[], size_t count, type values[], size_t size)                 \
    {                                                                                                                                                \
        (void)refs, (void)values, (void)size;                                                                                                        \
        return count ? complain(it, "a scene has no variable of that type") : fmi3OK;                                                                \
    }                                                                                                                                                \
    FMI3_EXPORT fmi3Status fmi3Set##what(fmi3Instance it, const fmi3ValueReference refs[], size_t count, const type values[], size_t size)           \
    {                                                                                                                                                \
        (void)refs, (void)values, (void)size;                                                                                                        \
        return count ? complain(it, "a scene has no variable of that type") : fmi3OK;                                                                \
    }

typedef const char *fmi3String;
FMI3_NONE(Float32, float)
FMI3_NONE(Int8, int8_t)
FMI3_NONE(UInt8, uint8_t)
FMI3_NONE(Int16, int16_t)
FMI3_NONE(UInt16, uint16_t)
FMI3_NONE(Int32, int32_t)
FMI3_NONE(UInt32, uint32_t)
FMI3_NONE(Int64, int64_t)
FMI3_NONE(UInt64, uint64_t)
FMI3_NONE(Boolean, bool)
FMI3_NONE(String, fmi3String)

/* What a scene does not offer, and its description says so. */
#define FMI3_REFUSED(name, ...)                                                                                                                      \
    FMI3_EXPORT fmi3Status name(fmi3Instance it, __VA_ARGS__)                                                                                        \
    {                                                                                                                                                \
        return complain(it, #name " is not offered");                                                                                                \
    }

#ifdef __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
FMI3_REFUSED(fmi3GetBinary, const fmi3ValueReference refs[], size_t count, size_t sizes[], const uint8_t *values[], size_t size)
FMI3_REFUSED(fmi3SetBinary, const fmi3ValueReference refs[], size_t count, const size_t sizes[], const uint8_t *const values[], size_t size)
FMI3_REFUSED(fmi3GetClock, const fmi3ValueReference refs[], size_t count, bool values[])
FMI3_REFUSED(fmi3SetClock, const fmi3ValueReference refs[], size_t count, const bool values[])
FMI3_REFUSED(fmi3GetIntervalDecimal, const fmi3ValueReference refs[], size_t count, double intervals[], int qualifiers[])
FMI3_REFUSED(fmi3GetIntervalFraction, const fmi3ValueReference refs[], size_t count, uint64_t counters[], uint64_t resolutions[], int qualifiers[])
FMI3_REFUSED(fmi3GetShiftDecimal, const fmi3ValueReference refs[], size_t count, double shifts[])
FMI3_REFUSED(fmi3GetShiftFraction, const fmi3ValueReference refs[], size_t count, uint64_t counters[], uint64_t resolutions[])
FMI3_REFUSED(fmi3SetIntervalDecimal, const fmi3ValueReference refs[], size_t count, const double intervals[])
FMI3_REFUSED(fmi3SetIntervalFraction, const fmi3ValueReference refs[], size_t count, const uint64_t counters[], const uint64_t resolutions[])
FMI3_REFUSED(fmi3SetShiftDecimal, const fmi3ValueReference refs[], size_t count, const double shifts[])
FMI3_REFUSED(fmi3SetShiftFraction, const fmi3ValueReference refs[], size_t count, const uint64_t counters[], const uint64_t resolutions[])
FMI3_REFUSED(fmi3GetNumberOfVariableDependencies, fmi3ValueReference ref, size_t *count)
FMI3_REFUSED(fmi3GetVariableDependencies, fmi3ValueReference ref, size_t elements[], fmi3ValueReference on[], size_t of[], int kinds[], size_t count)
FMI3_REFUSED(fmi3SerializedFMUStateSize, fmi3FMUState state, size_t *size)
FMI3_REFUSED(fmi3SerializeFMUState, fmi3FMUState state, uint8_t bytes[], size_t size)
FMI3_REFUSED(fmi3DeserializeFMUState, const uint8_t bytes[], size_t size, fmi3FMUState *state)
FMI3_REFUSED(fmi3GetDirectionalDerivative, const fmi3ValueReference of[], size_t n_of, const fmi3ValueReference by[], size_t n_by, const double seed[],
    size_t n_seed, double result[], size_t n_result)
FMI3_REFUSED(fmi3GetAdjointDerivative, const fmi3ValueReference of[], size_t n_of, const fmi3ValueReference by[], size_t n_by, const double seed[],
    size_t n_seed, double result[], size_t n_result)
FMI3_REFUSED(fmi3GetOutputDerivatives, const fmi3ValueReference refs[], size_t count, const int32_t orders[], double values[], size_t size)
FMI3_REFUSED(fmi3ActivateModelPartition, fmi3ValueReference clock, double t)
#ifdef __GNUC__
#pragma GCC diagnostic pop
#endif

/* FMI 3.0 around a scene: Model Exchange on its forward dynamics, Co-Simulation on its flow.
 *
 * Variables are doubles, one each, in this order of value references: time; q and v, the states; their rates; the inputs u; the
 * parameters; kinetic and potential energy. `phi_fill` puts the parameters into the scene's own struct.
 */

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, const char *, const char *);
typedef void (*fmi3Callback)(void);

enum {
    VR_TIME = 0,
    VR_STATE = 1,
    VR_RATE = VR_STATE + FMU_Q + FMU_V,
    VR_INPUT = VR_RATE + FMU_Q + FMU_V,
    VR_PARAMETER = VR_INPUT + FMU_U,
    VR_ENERGY = VR_PARAMETER + FMU_P,
    VR_END = VR_ENERGY + FMU_ENERGY
};

/* An instance; arrays that a scene has not are one long and unused. */
typedef struct {
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
    bool is_stepping; /* Co-Simulation: the flow moves the state */
    double t;
    double p[FMU_P + 1];
    phi_real u[FMU_U + 1];
    phi_real q[FMU_Q], v[FMU_V];
    double tolerance;
    phi_carried flow;
#if WITH_PARAMS
    phi_params own;
#endif
} Instance;

static fmi3Status complain(const Instance *const it, const char *const message)
{
    if (it->log) {
        it->log(it->environment, fmi3Error, "logStatusError", message);
    }
    return fmi3Error;
}

static void reset(Instance *const it)
{
    it->t = 0;
    it->tolerance = 0;
    for (int i = 0; i < FMU_U; ++i) {
        it->u[i] = 0;
    }
    for (int i = 0; i < FMU_P; ++i) {
        it->p[i] = fmu_parameters[i];
    }
    for (int i = 0; i < FMU_Q; ++i) {
        it->q[i] = (phi_real)fmu_start[i];
    }
    for (int i = 0; i < FMU_V; ++i) {
        it->v[i] = 0;
    }
    memset(&it->flow, 0, sizeof it->flow);
#if WITH_PARAMS
    phi_fill(it->p, &it->own);
#endif
}

/* The rates of q: v itself, and for unit vectors w x q. */
static void turned(const Instance *const it, phi_real rate[FMU_Q])
{
    for (int i = 0; i < FMU_CART; ++i) {
        rate[i] = it->v[i];
    }
#if WITH_SPHERE
    for (int i = FMU_CART; i < FMU_Q; i += 3) {
        const phi_real *const q = it->q + i, *const w = it->v + i;
        rate[i] = w[1] * q[2] - w[2] * q[1];
        rate[i + 1] = w[2] * q[0] - w[0] * q[2];
        rate[i + 2] = w[0] * q[1] - w[1] * q[0];
    }
#else
    for (int i = FMU_CART; i < FMU_Q; ++i) {
        rate[i] = it->v[i];
    }
#endif
}

static void rates(const Instance *const it, phi_real rate[FMU_Q + FMU_V])
{
    turned(it, rate);
    phi_forward_dynamics(PARAMS_PASS it->q, it->v, INPUT_PASS rate + FMU_Q);
}

static fmi3Status get(const Instance *const it, const fmi3ValueReference *const refs, const size_t count, double *const values)
{
    phi_real rate[FMU_Q + FMU_V];
    bool has_rates = false;
    for (size_t k = 0; k < count; ++k) {
        const int ref = refs[k] < VR_END ? (int)refs[k] : VR_END;
        if (ref == VR_END) {
            return complain(it, "a value reference names no variable");
        }
        if (ref >= VR_RATE && ref < VR_INPUT && !has_rates) {
            rates(it, rate);
            has_rates = true;
        }
        if (ref == VR_TIME) {
            values[k] = it->t;
        } else if (ref < VR_STATE + FMU_Q) {
            values[k] = it->q[ref - VR_STATE];
        } else if (ref < VR_RATE) {
            values[k] = it->v[ref - VR_STATE - FMU_Q];
        } else if (ref < VR_INPUT) {
            values[k] = rate[ref - VR_RATE];
        } else if (ref < VR_PARAMETER) {
            values[k] = it->u[ref - VR_INPUT];
        } else if (ref < VR_ENERGY) {
            values[k] = it->p[ref - VR_PARAMETER];
#if WITH_ENERGY
        } else {
            phi_real kinetic, potential;
            phi_energy(PARAMS_PASS it->q, it->v, &kinetic, &potential);
            values[k] = ref == VR_ENERGY ? kinetic : potential;
#endif
        }
    }
    return fmi3OK;
}

static fmi3Status set(Instance *const it, const fmi3ValueReference *const refs, const size_t count, const double *const values)
{
    for (size_t k = 0; k < count; ++k) {
        const int ref = refs[k] < VR_END ? (int)refs[k] : VR_END;
        if (ref >= VR_STATE && ref < VR_STATE + FMU_Q) {
            it->q[ref - VR_STATE] = (phi_real)values[k];
        } else if (ref >= VR_STATE && ref < VR_RATE) {
            it->v[ref - VR_STATE - FMU_Q] = (phi_real)values[k];
        } else if (ref >= VR_INPUT && ref < VR_PARAMETER) {
            it->u[ref - VR_INPUT] = (phi_real)values[k];
        } else if (ref >= VR_PARAMETER && ref < VR_ENERGY) {
            it->p[ref - VR_PARAMETER] = values[k];
        } else {
            return complain(it, "a variable that cannot be set was set");
        }
        /* What rounding took belongs to the state that was there. */
        if (ref < VR_RATE) {
            memset(&it->flow, 0, sizeof it->flow);
        }
    }
#if WITH_PARAMS
    phi_fill(it->p, &it->own);
#endif
    return fmi3OK;
}

static Instance *instantiate(const char *const token, const fmi3InstanceEnvironment environment, const fmi3LogMessageCallback log)
{
    Instance *const it = strcmp(token, FMU_TOKEN) ? NULL : calloc(1, sizeof *it);
    if (it) {
        it->log = log;
        it->environment = environment;
        reset(it);
    } else if (log) {
        log(environment, fmi3Error, "logStatusError", strcmp(token, FMU_TOKEN) ? "the instantiation token is that of another model" : "out of memory");
    }
    return it;
}

FMI3_EXPORT const char *fmi3GetVersion(void)
{
    return "3.0";
}

FMI3_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance it, bool is_on, size_t count, const char *const categories[])
{
    (void)it, (void)is_on, (void)count, (void)categories;
    return fmi3OK;
}

FMI3_EXPORT fmi3Instance fmi3InstantiateModelExchange(const char *name, const char *token, const char *resources, bool visible, bool logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    (void)name, (void)resources, (void)visible, (void)logging;
    return instantiate(token, environment, log);
}

FMI3_EXPORT fmi3Instance fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
    bool event_mode, bool early_return, const fmi3ValueReference required[], size_t count, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, fmi3Callback intermediate)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)event_mode, (void)early_return, (void)required, (void)count, (void)intermediate;
    Instance *const it = instantiate(token, environment, log);
    if (it) {
        it->is_stepping = true;
    }
    return it;
}

FMI3_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(const char *name, const char *token, const char *resources, bool visible, bool logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3Callback update, fmi3Callback lock, fmi3Callback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log, (void)update, (void)lock, (void)unlock;
    return NULL;
}

FMI3_EXPORT void fmi3FreeInstance(fmi3Instance it)
{
    free(it);
}

FMI3_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, bool has_tolerance, double tolerance, double start, bool has_stop, double stop)
{
    Instance *const it = instance;
    (void)has_stop, (void)stop;
    it->t = start;
    it->tolerance = has_tolerance ? tolerance : 0;
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3Reset(fmi3Instance it)
{
    reset(it);
    return fmi3OK;
}

/* Modes hold nothing here: a scene has no events and no discrete states. */
#define FMI3_MODE(name)                                                                                                                              \
    FMI3_EXPORT fmi3Status name(fmi3Instance it)                                                                                                     \
    {                                                                                                                                                \
        (void)it;                                                                                                                                    \
        return fmi3OK;                                                                                                                               \
    }

FMI3_MODE(fmi3ExitInitializationMode)
FMI3_MODE(fmi3EnterEventMode)
FMI3_MODE(fmi3Terminate)
FMI3_MODE(fmi3EnterConfigurationMode)
FMI3_MODE(fmi3ExitConfigurationMode)
FMI3_MODE(fmi3EnterContinuousTimeMode)
FMI3_MODE(fmi3EnterStepMode)
FMI3_MODE(fmi3EvaluateDiscreteStates)

FMI3_EXPORT fmi3Status fmi3GetFloat64(fmi3Instance it, const fmi3ValueReference refs[], size_t count, double values[], size_t size)
{
    return size == count ? get(it, refs, count, values) : complain(it, "every variable is one number");
}

FMI3_EXPORT fmi3Status fmi3SetFloat64(fmi3Instance it, const fmi3ValueReference refs[], size_t count, const double values[], size_t size)
{
    return size == count ? set(it, refs, count, values) : complain(it, "every variable is one number");
}

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

FMI3_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance it, fmi3FMUState *state)
{
    if (!*state && !(*state = malloc(sizeof(Instance)))) {
        return complain(it, "out of memory");
    }
    memcpy(*state, it, sizeof(Instance));
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance it, fmi3FMUState state)
{
    memcpy(it, state, sizeof(Instance));
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance it, fmi3FMUState *state)
{
    (void)it;
    free(*state);
    *state = NULL;
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3UpdateDiscreteStates(
    fmi3Instance it, bool *again, bool *ends, bool *nominals_changed, bool *states_changed, bool *has_next, double *next)
{
    (void)it, (void)next;
    *again = *ends = *nominals_changed = *states_changed = *has_next = false;
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3CompletedIntegratorStep(fmi3Instance it, bool no_return, bool *enters_event_mode, bool *ends)
{
    (void)it, (void)no_return;
    *enters_event_mode = *ends = false;
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3SetTime(fmi3Instance instance, double t)
{
    Instance *const it = instance;
    it->t = t;
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const double states[], size_t count)
{
    Instance *const it = instance;
    if (count != FMU_Q + FMU_V) {
        return complain(it, "the states are as many as q and v");
    }
    for (int i = 0; i < FMU_Q; ++i) {
        it->q[i] = (phi_real)states[i];
    }
    for (int i = 0; i < FMU_V; ++i) {
        it->v[i] = (phi_real)states[FMU_Q + i];
    }
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetContinuousStates(fmi3Instance instance, double states[], size_t count)
{
    const Instance *const it = instance;
    if (count != FMU_Q + FMU_V) {
        return complain(it, "the states are as many as q and v");
    }
    for (int i = 0; i < FMU_Q; ++i) {
        states[i] = it->q[i];
    }
    for (int i = 0; i < FMU_V; ++i) {
        states[FMU_Q + i] = it->v[i];
    }
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, double derivatives[], size_t count)
{
    phi_real rate[FMU_Q + FMU_V];
    if (count != FMU_Q + FMU_V) {
        return complain(instance, "the states are as many as q and v");
    }
    rates(instance, rate);
    for (size_t i = 0; i < count; ++i) {
        derivatives[i] = rate[i];
    }
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance it, double nominals[], size_t count)
{
    (void)it;
    for (size_t i = 0; i < count; ++i) {
        nominals[i] = 1;
    }
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetEventIndicators(fmi3Instance it, double indicators[], size_t count)
{
    (void)it, (void)indicators, (void)count;
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance it, size_t *count)
{
    (void)it;
    *count = 0;
    return fmi3OK;
}

FMI3_EXPORT fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance it, size_t *count)
{
    (void)it;
    *count = FMU_Q + FMU_V;
    return fmi3OK;
}

/* Inputs are held from one communication point to the next; in between the flow takes steps of its own. */
FMI3_EXPORT fmi3Status fmi3DoStep(fmi3Instance instance, double t, double step, bool no_return, bool *needs_events, bool *ends, bool *returned, double *reached)
{
    Instance *const it = instance;
    (void)no_return;
    *needs_events = *ends = *returned = false;
    *reached = it->t;
    if (!it->is_stepping) {
        return complain(it, "fmi3DoStep belongs to Co-Simulation");
    }
    const double end = t + step;
    it->flow.t = (phi_real)t;
    it->flow.tolerance = (phi_real)it->tolerance;
    const int result = phi_move(FLOW_PASS &it->flow, (phi_real)end, FMU_STEPS, MOVE_PASS it->q, it->v, EVENT_PASS 0, NULL, NULL, NULL);
    it->t = result ? (double)it->flow.t : end;
    *reached = it->t;
    return result ? complain(it, result == FMU_BUDGET ? "the step budget ran out within one communication step" : "the state is not finite") : fmi3OK;
}

/* The functions of FMI 3.0 that a scene offers, on an instance. */
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
    it->flow.work = &it->work;
    const int result = phi_move(FLOW_PASS &it->flow, (phi_real)end, FMU_STEPS, MOVE_PASS it->q, it->v, EVENT_PASS 0, NULL, NULL, NULL);
    it->t = result ? (double)it->flow.t : end;
    *reached = it->t;
    return result ? complain(it, result == FMU_BUDGET ? "the step budget ran out within one communication step" : "the state is not finite") : fmi3OK;
}

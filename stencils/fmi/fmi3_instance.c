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
    phi_work work;
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

/* The functions of FMI 2.0 for Model Exchange and Co-Simulation. Types and names are those of the standard. */
#include "instance.h"

#ifdef __cplusplus
#error "compile as C"
#endif

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;
typedef struct {
    fmi2Boolean newDiscreteStatesNeeded, terminateSimulation, nominalsOfContinuousStatesChanged, valuesOfContinuousStatesChanged,
        nextEventTimeDefined;
    fmi2Real nextEventTime;
} fmi2EventInfo;

#ifdef FMI2_FUNCTION_PREFIX
#define FW_PASTE(a, b) a##b
#define FW_JOIN(a, b) FW_PASTE(a, b)
#define FN(name) FW_JOIN(FMI2_FUNCTION_PREFIX, name)
#else
#define FN(name) name
#endif
#define API(type, name) FW_EXPORT type FN(name)
#define STATUS(ok) ((ok) ? fmi2OK : fmi2Error)
#define ENTER(function, phases) \
    fw_instance *s = fw_enter(c, #function, phases); \
    if (!s) return fmi2Error
#define UNUSED(x) (void)(x)

/* prototypes, so that no function is exported undeclared */
#define DECLARE(name, arguments) API(fmi2Status, name) arguments
API(const char *, fmi2GetTypesPlatform)(void);
API(const char *, fmi2GetVersion)(void);
API(fmi2Component, fmi2Instantiate)(fmi2String, fmi2Type, fmi2String, fmi2String, const fmi2CallbackFunctions *, fmi2Boolean, fmi2Boolean);
API(void, fmi2FreeInstance)(fmi2Component);
DECLARE(fmi2SetDebugLogging, (fmi2Component, fmi2Boolean, size_t, const fmi2String *));
DECLARE(fmi2SetupExperiment, (fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real));
DECLARE(fmi2EnterInitializationMode, (fmi2Component));
DECLARE(fmi2ExitInitializationMode, (fmi2Component));
DECLARE(fmi2Terminate, (fmi2Component));
DECLARE(fmi2Reset, (fmi2Component));
DECLARE(fmi2GetReal, (fmi2Component, const fmi2ValueReference *, size_t, fmi2Real *));
DECLARE(fmi2GetInteger, (fmi2Component, const fmi2ValueReference *, size_t, fmi2Integer *));
DECLARE(fmi2GetBoolean, (fmi2Component, const fmi2ValueReference *, size_t, fmi2Boolean *));
DECLARE(fmi2GetString, (fmi2Component, const fmi2ValueReference *, size_t, fmi2String *));
DECLARE(fmi2SetReal, (fmi2Component, const fmi2ValueReference *, size_t, const fmi2Real *));
DECLARE(fmi2SetInteger, (fmi2Component, const fmi2ValueReference *, size_t, const fmi2Integer *));
DECLARE(fmi2SetBoolean, (fmi2Component, const fmi2ValueReference *, size_t, const fmi2Boolean *));
DECLARE(fmi2SetString, (fmi2Component, const fmi2ValueReference *, size_t, const fmi2String *));
DECLARE(fmi2GetFMUstate, (fmi2Component, fmi2FMUstate *));
DECLARE(fmi2SetFMUstate, (fmi2Component, fmi2FMUstate));
DECLARE(fmi2FreeFMUstate, (fmi2Component, fmi2FMUstate *));
DECLARE(fmi2SerializedFMUstateSize, (fmi2Component, fmi2FMUstate, size_t *));
DECLARE(fmi2SerializeFMUstate, (fmi2Component, fmi2FMUstate, fmi2Byte *, size_t));
DECLARE(fmi2DeSerializeFMUstate, (fmi2Component, const fmi2Byte *, size_t, fmi2FMUstate *));
DECLARE(fmi2GetDirectionalDerivative, (fmi2Component, const fmi2ValueReference *, size_t, const fmi2ValueReference *, size_t,
                                       const fmi2Real *, fmi2Real *));
DECLARE(fmi2EnterEventMode, (fmi2Component));
DECLARE(fmi2NewDiscreteStates, (fmi2Component, fmi2EventInfo *));
DECLARE(fmi2EnterContinuousTimeMode, (fmi2Component));
DECLARE(fmi2CompletedIntegratorStep, (fmi2Component, fmi2Boolean, fmi2Boolean *, fmi2Boolean *));
DECLARE(fmi2SetTime, (fmi2Component, fmi2Real));
DECLARE(fmi2SetContinuousStates, (fmi2Component, const fmi2Real *, size_t));
DECLARE(fmi2GetDerivatives, (fmi2Component, fmi2Real *, size_t));
DECLARE(fmi2GetEventIndicators, (fmi2Component, fmi2Real *, size_t));
DECLARE(fmi2GetContinuousStates, (fmi2Component, fmi2Real *, size_t));
DECLARE(fmi2GetNominalsOfContinuousStates, (fmi2Component, fmi2Real *, size_t));
DECLARE(fmi2SetRealInputDerivatives, (fmi2Component, const fmi2ValueReference *, size_t, const fmi2Integer *, const fmi2Real *));
DECLARE(fmi2GetRealOutputDerivatives, (fmi2Component, const fmi2ValueReference *, size_t, const fmi2Integer *, fmi2Real *));
DECLARE(fmi2DoStep, (fmi2Component, fmi2Real, fmi2Real, fmi2Boolean));
DECLARE(fmi2CancelStep, (fmi2Component));
DECLARE(fmi2GetStatus, (fmi2Component, const fmi2StatusKind, fmi2Status *));
DECLARE(fmi2GetRealStatus, (fmi2Component, const fmi2StatusKind, fmi2Real *));
DECLARE(fmi2GetIntegerStatus, (fmi2Component, const fmi2StatusKind, fmi2Integer *));
DECLARE(fmi2GetBooleanStatus, (fmi2Component, const fmi2StatusKind, fmi2Boolean *));
DECLARE(fmi2GetStringStatus, (fmi2Component, const fmi2StatusKind, fmi2String *));

static void report(const fw_instance *s, const char *text)
{
    const fmi2CallbackFunctions *f = s->callback;
    if (f && f->logger) f->logger(f->componentEnvironment, s->name, fmi2Error, "logStatusError", text);
}

const char *FN(fmi2GetTypesPlatform)(void) { return "default"; }
const char *FN(fmi2GetVersion)(void) { return "2.0"; }

fmi2Component FN(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                  const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    fw_handle *h = fw_create(name, guid, type == fmi2CoSimulation);
    UNUSED(resources);
    UNUSED(visible);
    if (!h) {
        if (callbacks && callbacks->logger)
            callbacks->logger(callbacks->componentEnvironment, name ? name : "", fmi2Error, "logStatusError",
                              "No instance was made: the name is missing, the GUID is not this model's, or memory is short.");
        return NULL;
    }
    memcpy(&h->body->callback, &callbacks, sizeof callbacks);
    h->body->logging = logging != 0;
    h->body->report = report;
    return h;
}

void FN(fmi2FreeInstance)(fmi2Component c) { fw_destroy(c); }

fmi2Status FN(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String *categories)
{
    ENTER(fmi2SetDebugLogging, FW_ANY);
    UNUSED(n);
    UNUSED(categories);
    s->logging = on != 0;
    return fmi2OK;
}

fmi2Status FN(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
                                   fmi2Boolean stop_defined, fmi2Real stop)
{
    ENTER(fmi2SetupExperiment, FW_INSTANTIATED);
    UNUSED(tolerance_defined);
    UNUSED(tolerance);
    if (!isfinite(start) || (stop_defined && !(stop > start))) {
        fw_error(s, "The start time %g and the stop time %g are not in order.", start, stop);
        return fmi2Error;
    }
    s->model.v.time = start;
    s->model.v.stop = stop;
    s->model.v.stop_defined = stop_defined != 0;
    return fmi2OK;
}

fmi2Status FN(fmi2EnterInitializationMode)(fmi2Component c)
{
    ENTER(fmi2EnterInitializationMode, FW_INSTANTIATED);
    return STATUS(fw_initialise(s, s->model.v.time, s->model.v.stop_defined, s->model.v.stop));
}

fmi2Status FN(fmi2ExitInitializationMode)(fmi2Component c)
{
    ENTER(fmi2ExitInitializationMode, FW_INITIALISING);
    s->model.v.phase = s->co_simulation ? FW_STEPPING : FW_EVENT;
    return fmi2OK;
}

fmi2Status FN(fmi2Terminate)(fmi2Component c)
{
    ENTER(fmi2Terminate, FW_RUNNING);
    s->model.v.phase = FW_TERMINATED;
    return fmi2OK;
}

fmi2Status FN(fmi2Reset)(fmi2Component c)
{
    ENTER(fmi2Reset, FW_ANY);
    return STATUS(fw_reset(s));
}

fmi2Status FN(fmi2GetReal)(fmi2Component c, const fmi2ValueReference *vr, size_t n, fmi2Real *value)
{
    ENTER(fmi2GetReal, FW_INITIALISING | FW_RUNNING | FW_TERMINATED);
    return STATUS(fw_get_real(s, vr, n, value));
}

fmi2Status FN(fmi2SetReal)(fmi2Component c, const fmi2ValueReference *vr, size_t n, const fmi2Real *value)
{
    ENTER(fmi2SetReal, FW_INSTANTIATED | FW_INITIALISING | FW_RUNNING);
    return STATUS(fw_set_real(s, vr, n, value));
}

fmi2Status FN(fmi2GetInteger)(fmi2Component c, const fmi2ValueReference *vr, size_t n, fmi2Integer *value)
{
    ENTER(fmi2GetInteger, FW_INITIALISING | FW_RUNNING | FW_TERMINATED);
    return STATUS(fw_get_integer(s, vr, n, value));
}

fmi2Status FN(fmi2SetInteger)(fmi2Component c, const fmi2ValueReference *vr, size_t n, const fmi2Integer *value)
{
    ENTER(fmi2SetInteger, FW_INSTANTIATED | FW_INITIALISING | FW_RUNNING);
    return STATUS(fw_set_integer(s, vr, n, value));
}

/* there are no Boolean and no String variables: only an empty list can be got or set */
#define NO_VARIABLES(name, type) \
    fmi2Status FN(name)(fmi2Component c, const fmi2ValueReference *vr, size_t n, type value) \
    { \
        ENTER(name, FW_ANY); \
        UNUSED(vr); \
        UNUSED(value); \
        if (n) fw_error(s, "This model has no variables of that type."); \
        return STATUS(n == 0); \
    }
NO_VARIABLES(fmi2GetBoolean, fmi2Boolean *)
NO_VARIABLES(fmi2GetString, fmi2String *)
NO_VARIABLES(fmi2SetBoolean, const fmi2Boolean *)
NO_VARIABLES(fmi2SetString, const fmi2String *)

fmi2Status FN(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    ENTER(fmi2GetFMUstate, FW_ANY);
    if (!state) return fmi2Error;
    *state = fw_save(s, *state);
    return STATUS(*state != NULL);
}

fmi2Status FN(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state)
{
    ENTER(fmi2SetFMUstate, FW_ANY);
    return STATUS(fw_restore(s, state));
}

fmi2Status FN(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    ENTER(fmi2FreeFMUstate, FW_ANY);
    if (!state || !fw_forget(s, *state)) return fmi2Error;
    *state = NULL;
    return fmi2OK;
}

fmi2Status FN(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    ENTER(fmi2SerializedFMUstateSize, FW_ANY);
    if (!size || !fw_find(s, state)) return fmi2Error;
    *size = sizeof(fw_serial);
    return fmi2OK;
}

fmi2Status FN(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte *bytes, size_t size)
{
    ENTER(fmi2SerializeFMUstate, FW_ANY);
    return STATUS(fw_serialise(s, state, bytes, size));
}

fmi2Status FN(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte *bytes, size_t size, fmi2FMUstate *state)
{
    fw_saved *p;
    ENTER(fmi2DeSerializeFMUstate, FW_ANY);
    if (!state) return fmi2Error;
    p = fw_deserialise(s, bytes, size, *state);
    if (p) *state = p;
    return STATUS(p != NULL);
}

fmi2Status FN(fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference *unknown, size_t n, const fmi2ValueReference *known,
                                            size_t m, const fmi2Real *seed, fmi2Real *out)
{
    ENTER(fmi2GetDirectionalDerivative, FW_INITIALISING | FW_RUNNING | FW_TERMINATED);
    return STATUS(fw_jacobian(s, unknown, n, known, m, seed, out, 0));
}

/* --- Model Exchange */

fmi2Status FN(fmi2EnterEventMode)(fmi2Component c)
{
    ENTER(fmi2EnterEventMode, FW_EVENT | FW_CONTINUOUS);
    s->model.v.phase = FW_EVENT;
    return fmi2OK;
}

fmi2Status FN(fmi2NewDiscreteStates)(fmi2Component c, fmi2EventInfo *info)
{
    ENTER(fmi2NewDiscreteStates, FW_EVENT);
    if (!info) return fmi2Error;
    memset(info, 0, sizeof *info);
    return fmi2OK;
}

fmi2Status FN(fmi2EnterContinuousTimeMode)(fmi2Component c)
{
    ENTER(fmi2EnterContinuousTimeMode, FW_EVENT);
    s->model.v.phase = FW_CONTINUOUS;
    return fmi2OK;
}

fmi2Status FN(fmi2CompletedIntegratorStep)(fmi2Component c, fmi2Boolean no_return, fmi2Boolean *event_mode, fmi2Boolean *terminate)
{
    ENTER(fmi2CompletedIntegratorStep, FW_CONTINUOUS);
    UNUSED(no_return);
    if (!event_mode || !terminate) return fmi2Error;
    *event_mode = *terminate = 0;
    return fmi2OK;
}

fmi2Status FN(fmi2SetTime)(fmi2Component c, fmi2Real time)
{
    ENTER(fmi2SetTime, FW_EVENT | FW_CONTINUOUS);
    if (!isfinite(time)) {
        fw_error(s, "The time %g is not a finite number.", time);
        return fmi2Error;
    }
    s->model.v.time = time;
    s->model.output_known = 0;
    return fmi2OK;
}

fmi2Status FN(fmi2SetContinuousStates)(fmi2Component c, const fmi2Real *x, size_t n)
{
    size_t i;
    ENTER(fmi2SetContinuousStates, FW_CONTINUOUS);
    if (n != N_STATE || (n && !x)) {
        fw_error(s, "%lu states were given, there are %d.", (unsigned long)n, N_STATE);
        return fmi2Error;
    }
    for (i = 0; i < n; i++)
        if (!isfinite(x[i])) {
            fw_error(s, "State %lu is not a finite number.", (unsigned long)i + 1);
            return fmi2Error;
        }
    if (n) memcpy(s->model.v.state, x, n * sizeof *x);
    s->model.output_known = 0;
    return fmi2OK;
}

fmi2Status FN(fmi2GetDerivatives)(fmi2Component c, fmi2Real *out, size_t n)
{
    ENTER(fmi2GetDerivatives, FW_INITIALISING | FW_EVENT | FW_CONTINUOUS | FW_TERMINATED);
    if (n != N_STATE || (n && !out)) {
        fw_error(s, "%lu derivatives were asked for, there are %d.", (unsigned long)n, N_STATE);
        return fmi2Error;
    }
    if (n) fw_derivatives(&s->model, out);
    return fmi2OK;
}

fmi2Status FN(fmi2GetEventIndicators)(fmi2Component c, fmi2Real *out, size_t n)
{
    ENTER(fmi2GetEventIndicators, FW_INITIALISING | FW_EVENT | FW_CONTINUOUS | FW_TERMINATED);
    UNUSED(out);
    return STATUS(n == 0);
}

fmi2Status FN(fmi2GetContinuousStates)(fmi2Component c, fmi2Real *x, size_t n)
{
    ENTER(fmi2GetContinuousStates, FW_INITIALISING | FW_EVENT | FW_CONTINUOUS | FW_TERMINATED);
    if (n != N_STATE || (n && !x)) {
        fw_error(s, "%lu states were asked for, there are %d.", (unsigned long)n, N_STATE);
        return fmi2Error;
    }
    if (n) memcpy(x, s->model.v.state, n * sizeof *x);
    return fmi2OK;
}

fmi2Status FN(fmi2GetNominalsOfContinuousStates)(fmi2Component c, fmi2Real *x, size_t n)
{
    size_t i;
    ENTER(fmi2GetNominalsOfContinuousStates, FW_ANY);
    if (n != N_STATE || (n && !x)) return fmi2Error;
    for (i = 0; i < n; i++) x[i] = 1.0;
    return fmi2OK;
}

/* --- Co-Simulation */

fmi2Status FN(fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference *vr, size_t n, const fmi2Integer *order,
                                           const fmi2Real *value)
{
    size_t i;
    ENTER(fmi2SetRealInputDerivatives, FW_INITIALISING | FW_STEPPING);
    if (n && (!vr || !order || !value)) return fmi2Error;
    for (i = 0; i < n; i++)
        if (vr[i] >= N_VARIABLE || variable_kind[vr[i]] != V_INPUT || order[i] != 1 || !isfinite(value[i])) {
            fw_error(s, "Value reference %u: a finite first derivative of an input is needed.", vr[i]);
            return fmi2Error;
        }
    for (i = 0; i < n; i++) s->model.v.slope[variable_index[vr[i]]] = value[i];
    return fmi2OK;
}

fmi2Status FN(fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference *vr, size_t n, const fmi2Integer *order,
                                            fmi2Real *value)
{
    ENTER(fmi2GetRealOutputDerivatives, FW_STEPPING | FW_TERMINATED);
    UNUSED(vr);
    UNUSED(order);
    UNUSED(value);
    if (n) fw_error(s, "Derivatives of outputs are not provided.");
    return STATUS(n == 0);
}

fmi2Status FN(fmi2DoStep)(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_return)
{
    ENTER(fmi2DoStep, FW_STEPPING);
    UNUSED(no_return);
    return STATUS(fw_do_step(s, t, h));
}

fmi2Status FN(fmi2CancelStep)(fmi2Component c)
{
    ENTER(fmi2CancelStep, FW_STEPPING);
    fw_error(s, "Steps are done when fmi2DoStep returns; there is nothing to cancel.");
    return fmi2Error;
}

fmi2Status FN(fmi2GetRealStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    ENTER(fmi2GetRealStatus, FW_STEPPING | FW_TERMINATED);
    if (kind != fmi2LastSuccessfulTime || !value) return fmi2Discard;
    *value = s->model.v.time;
    return fmi2OK;
}

fmi2Status FN(fmi2GetBooleanStatus)(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    ENTER(fmi2GetBooleanStatus, FW_STEPPING | FW_TERMINATED);
    if (kind != fmi2Terminated || !value) return fmi2Discard;
    *value = 0;
    return fmi2OK;
}

#define NO_STATUS(name, type) \
    fmi2Status FN(name)(fmi2Component c, const fmi2StatusKind kind, type value) \
    { \
        ENTER(name, FW_STEPPING | FW_TERMINATED); \
        UNUSED(s); \
        UNUSED(kind); \
        UNUSED(value); \
        return fmi2Discard; \
    }
NO_STATUS(fmi2GetStatus, fmi2Status *)
NO_STATUS(fmi2GetIntegerStatus, fmi2Integer *)
NO_STATUS(fmi2GetStringStatus, fmi2String *)

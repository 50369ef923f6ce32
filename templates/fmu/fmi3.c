/* The functions of FMI 3.0 for Model Exchange and Co-Simulation. Types and names are those of the standard. */
#include <stdbool.h>

#include "instance.h"

typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8, fmi3Byte;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean, fmi3Clock;
typedef const char *fmi3String;
typedef const fmi3Byte *fmi3Binary;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean, fmi3Boolean, fmi3Boolean,
                                               fmi3Boolean *, fmi3Float64 *);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

#ifdef FMI3_FUNCTION_PREFIX
#define FW_PASTE(a, b) a##b
#define FW_JOIN(a, b) FW_PASTE(a, b)
#define FN(name) FW_JOIN(FMI3_FUNCTION_PREFIX, name)
#else
#define FN(name) name
#endif
#define STATUS(ok) ((ok) ? fmi3OK : fmi3Error)
#define ENTER(function, phases) \
    fw_instance *s = fw_enter(c, #function, phases); \
    if (!s) return fmi3Error
#define UNUSED(x) (void)(x)
/* a definition with its prototype before it */
#define FUNCTION(name, arguments) \
    FW_EXPORT fmi3Status FN(name) arguments; \
    fmi3Status FN(name) arguments
#define REFERENCES const fmi3ValueReference *vr, size_t n

static void report(const fw_instance *s, const char *text)
{
    if (s->log3) ((fmi3LogMessageCallback)s->log3)(s->environment, fmi3Error, "logStatusError", text);
}

static fmi3Instance create(fmi3String name, fmi3String token, fmi3Boolean logging, fmi3InstanceEnvironment environment,
                           fmi3LogMessageCallback log, int co_simulation)
{
    fw_handle *h = fw_create(name, token, co_simulation);
    if (!h) {
        if (log)
            log(environment, fmi3Error, "logStatusError",
                "No instance was made: the name is missing, the instantiation token is not this model's, or memory is short.");
        return NULL;
    }
    h->body->environment = environment;
    h->body->log3 = (void (*)(void))log;
    h->body->logging = logging;
    h->body->report = report;
    return h;
}

FW_EXPORT const char *FN(fmi3GetVersion)(void);
const char *FN(fmi3GetVersion)(void) { return "3.0"; }

FUNCTION(fmi3SetDebugLogging, (fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String *categories))
{
    ENTER(fmi3SetDebugLogging, FW_ANY);
    UNUSED(n);
    UNUSED(categories);
    s->logging = on;
    return fmi3OK;
}

FW_EXPORT fmi3Instance FN(fmi3InstantiateModelExchange)(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                                        fmi3InstanceEnvironment, fmi3LogMessageCallback);
fmi3Instance FN(fmi3InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                              fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    UNUSED(resources);
    UNUSED(visible);
    return create(name, token, logging, environment, log, 0);
}

FW_EXPORT fmi3Instance FN(fmi3InstantiateCoSimulation)(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean, fmi3Boolean,
                                                       fmi3Boolean, const fmi3ValueReference *, size_t, fmi3InstanceEnvironment,
                                                       fmi3LogMessageCallback, fmi3IntermediateUpdateCallback);
fmi3Instance FN(fmi3InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                             fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return, REFERENCES,
                                             fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                             fmi3IntermediateUpdateCallback intermediate)
{
    UNUSED(resources);
    UNUSED(visible);
    UNUSED(early_return);
    UNUSED(vr);
    UNUSED(n);
    UNUSED(intermediate);
    if (event_mode) {
        if (log) log(environment, fmi3Error, "logStatusError", "This model has no event mode in co-simulation.");
        return NULL;
    }
    return create(name, token, logging, environment, log, 1);
}

FW_EXPORT fmi3Instance FN(fmi3InstantiateScheduledExecution)(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                                             fmi3InstanceEnvironment, fmi3LogMessageCallback, fmi3ClockUpdateCallback,
                                                             fmi3LockPreemptionCallback, fmi3UnlockPreemptionCallback);
fmi3Instance FN(fmi3InstantiateScheduledExecution)(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                                   fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                   fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                                   fmi3UnlockPreemptionCallback unlock)
{
    UNUSED(name);
    UNUSED(token);
    UNUSED(resources);
    UNUSED(visible);
    UNUSED(logging);
    UNUSED(update);
    UNUSED(lock);
    UNUSED(unlock);
    if (log) log(environment, fmi3Error, "logStatusError", "Scheduled execution is not provided.");
    return NULL;
}

FW_EXPORT void FN(fmi3FreeInstance)(fmi3Instance);
void FN(fmi3FreeInstance)(fmi3Instance c) { fw_destroy(c); }

FUNCTION(fmi3EnterInitializationMode, (fmi3Instance c, fmi3Boolean tolerance_defined, fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stop_defined, fmi3Float64 stop))
{
    ENTER(fmi3EnterInitializationMode, FW_INSTANTIATED);
    UNUSED(tolerance_defined);
    UNUSED(tolerance);
    return STATUS(fw_initialise(s, start, stop_defined, stop));
}

FUNCTION(fmi3ExitInitializationMode, (fmi3Instance c))
{
    ENTER(fmi3ExitInitializationMode, FW_INITIALISING);
    s->model.v.phase = s->co_simulation ? FW_STEPPING : FW_EVENT;
    return fmi3OK;
}

FUNCTION(fmi3EnterEventMode, (fmi3Instance c))
{
    ENTER(fmi3EnterEventMode, FW_CONTINUOUS | FW_EVENT);
    s->model.v.phase = FW_EVENT;
    return fmi3OK;
}

FUNCTION(fmi3Terminate, (fmi3Instance c))
{
    ENTER(fmi3Terminate, FW_RUNNING);
    s->model.v.phase = FW_TERMINATED;
    return fmi3OK;
}

FUNCTION(fmi3Reset, (fmi3Instance c))
{
    ENTER(fmi3Reset, FW_ANY);
    return STATUS(fw_reset(s));
}

FUNCTION(fmi3GetFloat64, (fmi3Instance c, REFERENCES, fmi3Float64 *value, size_t count))
{
    ENTER(fmi3GetFloat64, FW_INITIALISING | FW_RUNNING | FW_TERMINATED);
    if (count != n) fw_error(s, "All variables are scalars: as many values as references are needed.");
    return STATUS(count == n && fw_get_real(s, vr, n, value));
}

FUNCTION(fmi3SetFloat64, (fmi3Instance c, REFERENCES, const fmi3Float64 *value, size_t count))
{
    ENTER(fmi3SetFloat64, FW_INSTANTIATED | FW_INITIALISING | FW_RUNNING);
    if (count != n) fw_error(s, "All variables are scalars: as many values as references are needed.");
    return STATUS(count == n && fw_set_real(s, vr, n, value));
}

FUNCTION(fmi3GetInt32, (fmi3Instance c, REFERENCES, fmi3Int32 *value, size_t count))
{
    ENTER(fmi3GetInt32, FW_INITIALISING | FW_RUNNING | FW_TERMINATED);
    return STATUS(count == n && fw_get_integer(s, vr, n, value));
}

FUNCTION(fmi3SetInt32, (fmi3Instance c, REFERENCES, const fmi3Int32 *value, size_t count))
{
    ENTER(fmi3SetInt32, FW_INSTANTIATED | FW_INITIALISING | FW_RUNNING);
    return STATUS(count == n && fw_set_integer(s, vr, n, value));
}

/* of other types there are no variables: only an empty list can be got or set */
#define NO_VARIABLES(type) \
    FUNCTION(fmi3Get##type, (fmi3Instance c, REFERENCES, fmi3##type * value, size_t count)) \
    { \
        ENTER(fmi3Get##type, FW_ANY); \
        UNUSED(vr); \
        UNUSED(value); \
        UNUSED(count); \
        if (n) fw_error(s, "This model has no variables of type " #type "."); \
        return STATUS(n == 0); \
    } \
    FUNCTION(fmi3Set##type, (fmi3Instance c, REFERENCES, const fmi3##type *value, size_t count)) \
    { \
        ENTER(fmi3Set##type, FW_ANY); \
        UNUSED(vr); \
        UNUSED(value); \
        UNUSED(count); \
        if (n) fw_error(s, "This model has no variables of type " #type "."); \
        return STATUS(n == 0); \
    }
NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

#define REFUSED(name, arguments, ...) \
    FUNCTION(name, arguments) \
    { \
        ENTER(name, FW_ANY); \
        const void *unused[] = {__VA_ARGS__}; \
        UNUSED(unused); \
        if (n) fw_error(s, #name ": this model has no such variables."); \
        return STATUS(n == 0); \
    }
REFUSED(fmi3GetBinary, (fmi3Instance c, REFERENCES, size_t *sizes, fmi3Binary *value, size_t count), vr, sizes, value, &count)
REFUSED(fmi3SetBinary, (fmi3Instance c, REFERENCES, const size_t *sizes, const fmi3Binary *value, size_t count), vr, sizes, value, &count)
REFUSED(fmi3GetClock, (fmi3Instance c, REFERENCES, fmi3Clock *value), vr, value)
REFUSED(fmi3SetClock, (fmi3Instance c, REFERENCES, const fmi3Clock *value), vr, value)
REFUSED(fmi3GetIntervalDecimal, (fmi3Instance c, REFERENCES, fmi3Float64 *interval, fmi3IntervalQualifier *q), vr, interval, q)
REFUSED(fmi3GetIntervalFraction, (fmi3Instance c, REFERENCES, fmi3UInt64 *counter, fmi3UInt64 *resolution, fmi3IntervalQualifier *q), vr,
        counter, resolution, q)
REFUSED(fmi3GetShiftDecimal, (fmi3Instance c, REFERENCES, fmi3Float64 *shift), vr, shift)
REFUSED(fmi3GetShiftFraction, (fmi3Instance c, REFERENCES, fmi3UInt64 *counter, fmi3UInt64 *resolution), vr, counter, resolution)
REFUSED(fmi3SetIntervalDecimal, (fmi3Instance c, REFERENCES, const fmi3Float64 *interval), vr, interval)
REFUSED(fmi3SetIntervalFraction, (fmi3Instance c, REFERENCES, const fmi3UInt64 *counter, const fmi3UInt64 *resolution), vr, counter,
        resolution)
REFUSED(fmi3SetShiftDecimal, (fmi3Instance c, REFERENCES, const fmi3Float64 *shift), vr, shift)
REFUSED(fmi3SetShiftFraction, (fmi3Instance c, REFERENCES, const fmi3UInt64 *counter, const fmi3UInt64 *resolution), vr, counter, resolution)
REFUSED(fmi3GetOutputDerivatives, (fmi3Instance c, REFERENCES, const fmi3Int32 *order, fmi3Float64 *value, size_t count), vr, order, value,
        &count)

FUNCTION(fmi3GetNumberOfVariableDependencies, (fmi3Instance c, fmi3ValueReference vr, size_t *n))
{
    ENTER(fmi3GetNumberOfVariableDependencies, FW_ANY);
    UNUSED(vr);
    UNUSED(n);
    fw_error(s, "Dependencies do not change: see the model description.");
    return fmi3Error;
}

FUNCTION(fmi3GetVariableDependencies, (fmi3Instance c, fmi3ValueReference dependent, size_t *element, fmi3ValueReference *independent,
                                       size_t *other, fmi3DependencyKind *kind, size_t n))
{
    ENTER(fmi3GetVariableDependencies, FW_ANY);
    UNUSED(dependent);
    UNUSED(element);
    UNUSED(independent);
    UNUSED(other);
    UNUSED(kind);
    UNUSED(n);
    fw_error(s, "Dependencies do not change: see the model description.");
    return fmi3Error;
}

FUNCTION(fmi3GetFMUState, (fmi3Instance c, fmi3FMUState *state))
{
    ENTER(fmi3GetFMUState, FW_ANY);
    if (!state) return fmi3Error;
    *state = fw_save(s, *state);
    return STATUS(*state != NULL);
}

FUNCTION(fmi3SetFMUState, (fmi3Instance c, fmi3FMUState state))
{
    ENTER(fmi3SetFMUState, FW_ANY);
    return STATUS(fw_restore(s, state));
}

FUNCTION(fmi3FreeFMUState, (fmi3Instance c, fmi3FMUState *state))
{
    ENTER(fmi3FreeFMUState, FW_ANY);
    if (!state || !fw_forget(s, *state)) return fmi3Error;
    *state = NULL;
    return fmi3OK;
}

FUNCTION(fmi3SerializedFMUStateSize, (fmi3Instance c, fmi3FMUState state, size_t *size))
{
    ENTER(fmi3SerializedFMUStateSize, FW_ANY);
    if (!size || !fw_find(s, state)) return fmi3Error;
    *size = sizeof(fw_serial);
    return fmi3OK;
}

FUNCTION(fmi3SerializeFMUState, (fmi3Instance c, fmi3FMUState state, fmi3Byte *bytes, size_t size))
{
    ENTER(fmi3SerializeFMUState, FW_ANY);
    return STATUS(fw_serialise(s, state, bytes, size));
}

FUNCTION(fmi3DeserializeFMUState, (fmi3Instance c, const fmi3Byte *bytes, size_t size, fmi3FMUState *state))
{
    fw_saved *p;
    ENTER(fmi3DeserializeFMUState, FW_ANY);
    if (!state) return fmi3Error;
    p = fw_deserialise(s, bytes, size, *state);
    if (p) *state = p;
    return STATUS(p != NULL);
}

FUNCTION(fmi3GetDirectionalDerivative, (fmi3Instance c, const fmi3ValueReference *unknown, size_t n, const fmi3ValueReference *known,
                                        size_t m, const fmi3Float64 *seed, size_t n_seed, fmi3Float64 *out, size_t n_out))
{
    ENTER(fmi3GetDirectionalDerivative, FW_INITIALISING | FW_RUNNING | FW_TERMINATED);
    return STATUS(n_seed == m && n_out == n && fw_jacobian(s, unknown, n, known, m, seed, out, 0));
}

FUNCTION(fmi3GetAdjointDerivative, (fmi3Instance c, const fmi3ValueReference *unknown, size_t n, const fmi3ValueReference *known, size_t m,
                                    const fmi3Float64 *seed, size_t n_seed, fmi3Float64 *out, size_t n_out))
{
    ENTER(fmi3GetAdjointDerivative, FW_INITIALISING | FW_RUNNING | FW_TERMINATED);
    return STATUS(n_seed == n && n_out == m && fw_jacobian(s, unknown, n, known, m, seed, out, 1));
}

FUNCTION(fmi3EnterConfigurationMode, (fmi3Instance c))
{
    ENTER(fmi3EnterConfigurationMode, FW_ANY);
    fw_error(s, "There are no structural parameters to configure.");
    return fmi3Error;
}

FUNCTION(fmi3ExitConfigurationMode, (fmi3Instance c))
{
    ENTER(fmi3ExitConfigurationMode, FW_ANY);
    fw_error(s, "There are no structural parameters to configure.");
    return fmi3Error;
}

FUNCTION(fmi3EvaluateDiscreteStates, (fmi3Instance c))
{
    ENTER(fmi3EvaluateDiscreteStates, FW_INITIALISING | FW_EVENT);
    UNUSED(s);
    return fmi3OK;
}

FUNCTION(fmi3UpdateDiscreteStates, (fmi3Instance c, fmi3Boolean *more, fmi3Boolean *terminate, fmi3Boolean *nominals, fmi3Boolean *values,
                                    fmi3Boolean *next_defined, fmi3Float64 *next))
{
    ENTER(fmi3UpdateDiscreteStates, FW_EVENT);
    UNUSED(s);
    if (!more || !terminate || !nominals || !values || !next_defined || !next) return fmi3Error;
    *more = *terminate = *nominals = *values = *next_defined = false;
    *next = 0.0;
    return fmi3OK;
}

/* --- Model Exchange */

FUNCTION(fmi3EnterContinuousTimeMode, (fmi3Instance c))
{
    ENTER(fmi3EnterContinuousTimeMode, FW_EVENT);
    s->model.v.phase = FW_CONTINUOUS;
    return fmi3OK;
}

FUNCTION(fmi3CompletedIntegratorStep, (fmi3Instance c, fmi3Boolean no_return, fmi3Boolean *event_mode, fmi3Boolean *terminate))
{
    ENTER(fmi3CompletedIntegratorStep, FW_CONTINUOUS);
    UNUSED(no_return);
    UNUSED(s);
    if (!event_mode || !terminate) return fmi3Error;
    *event_mode = *terminate = false;
    return fmi3OK;
}

FUNCTION(fmi3SetTime, (fmi3Instance c, fmi3Float64 time))
{
    ENTER(fmi3SetTime, FW_EVENT | FW_CONTINUOUS);
    if (!isfinite(time)) {
        fw_error(s, "The time %g is not a finite number.", time);
        return fmi3Error;
    }
    s->model.v.time = time;
    s->model.output_known = 0;
    return fmi3OK;
}

FUNCTION(fmi3SetContinuousStates, (fmi3Instance c, const fmi3Float64 *x, size_t n))
{
    size_t i;
    ENTER(fmi3SetContinuousStates, FW_CONTINUOUS);
    if (n != N_STATE || (n && !x)) {
        fw_error(s, "%lu states were given, there are %d.", (unsigned long)n, N_STATE);
        return fmi3Error;
    }
    for (i = 0; i < n; i++)
        if (!isfinite(x[i])) {
            fw_error(s, "State %lu is not a finite number.", (unsigned long)i + 1);
            return fmi3Error;
        }
    if (n) memcpy(s->model.v.state, x, n * sizeof *x);
    s->model.output_known = 0;
    return fmi3OK;
}

FUNCTION(fmi3GetContinuousStateDerivatives, (fmi3Instance c, fmi3Float64 *out, size_t n))
{
    ENTER(fmi3GetContinuousStateDerivatives, FW_INITIALISING | FW_EVENT | FW_CONTINUOUS | FW_TERMINATED);
    if (n != N_STATE || (n && !out)) {
        fw_error(s, "%lu derivatives were asked for, there are %d.", (unsigned long)n, N_STATE);
        return fmi3Error;
    }
    if (n) fw_derivatives(&s->model, out);
    return fmi3OK;
}

FUNCTION(fmi3GetEventIndicators, (fmi3Instance c, fmi3Float64 *out, size_t n))
{
    ENTER(fmi3GetEventIndicators, FW_INITIALISING | FW_EVENT | FW_CONTINUOUS | FW_TERMINATED);
    UNUSED(s);
    UNUSED(out);
    return STATUS(n == 0);
}

FUNCTION(fmi3GetContinuousStates, (fmi3Instance c, fmi3Float64 *x, size_t n))
{
    ENTER(fmi3GetContinuousStates, FW_INITIALISING | FW_EVENT | FW_CONTINUOUS | FW_TERMINATED);
    if (n != N_STATE || (n && !x)) {
        fw_error(s, "%lu states were asked for, there are %d.", (unsigned long)n, N_STATE);
        return fmi3Error;
    }
    if (n) memcpy(x, s->model.v.state, n * sizeof *x);
    return fmi3OK;
}

FUNCTION(fmi3GetNominalsOfContinuousStates, (fmi3Instance c, fmi3Float64 *x, size_t n))
{
    size_t i;
    ENTER(fmi3GetNominalsOfContinuousStates, FW_ANY);
    UNUSED(s);
    if (n != N_STATE || (n && !x)) return fmi3Error;
    for (i = 0; i < n; i++) x[i] = 1.0;
    return fmi3OK;
}

FUNCTION(fmi3GetNumberOfEventIndicators, (fmi3Instance c, size_t *n))
{
    ENTER(fmi3GetNumberOfEventIndicators, FW_ANY);
    UNUSED(s);
    if (!n) return fmi3Error;
    *n = 0;
    return fmi3OK;
}

FUNCTION(fmi3GetNumberOfContinuousStates, (fmi3Instance c, size_t *n))
{
    ENTER(fmi3GetNumberOfContinuousStates, FW_ANY);
    UNUSED(s);
    if (!n) return fmi3Error;
    *n = N_STATE;
    return fmi3OK;
}

/* --- Co-Simulation */

FUNCTION(fmi3EnterStepMode, (fmi3Instance c))
{
    ENTER(fmi3EnterStepMode, FW_ANY);
    fw_error(s, "This model has no event mode in co-simulation.");
    return fmi3Error;
}

FUNCTION(fmi3DoStep, (fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_return, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, fmi3Float64 *last))
{
    int ok;
    ENTER(fmi3DoStep, FW_STEPPING);
    UNUSED(no_return);
    if (!event || !terminate || !early || !last) return fmi3Error;
    ok = fw_do_step(s, t, h);
    *event = *terminate = *early = false;
    *last = s->model.v.time;
    return STATUS(ok);
}

FUNCTION(fmi3ActivateModelPartition, (fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time))
{
    ENTER(fmi3ActivateModelPartition, FW_ANY);
    UNUSED(clock);
    UNUSED(time);
    fw_error(s, "Scheduled execution is not provided.");
    return fmi3Error;
}

/* Drives the FMI 2 functions of the oscillator rightly and wrongly, for the sanitizers and valgrind. Exit status 0: all as it should be. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void *component;
typedef struct { void (*logger)(void *, const char *, int, const char *, const char *, ...); void *a, *f, *s; void *e; } callbacks;
typedef struct { int f[5]; double next; } event_info;
component fmi2Instantiate(const char *, int, const char *, const char *, const callbacks *, int, int);
void fmi2FreeInstance(component);
int fmi2SetupExperiment(component, int, double, double, int, double), fmi2EnterInitializationMode(component), fmi2ExitInitializationMode(component);
int fmi2Terminate(component), fmi2Reset(component), fmi2EnterContinuousTimeMode(component), fmi2NewDiscreteStates(component, event_info *);
int fmi2GetReal(component, const unsigned *, size_t, double *), fmi2SetReal(component, const unsigned *, size_t, const double *);
int fmi2GetInteger(component, const unsigned *, size_t, int *), fmi2SetInteger(component, const unsigned *, size_t, const int *);
int fmi2GetBoolean(component, const unsigned *, size_t, int *), fmi2SetString(component, const unsigned *, size_t, const char **);
int fmi2DoStep(component, double, double, int), fmi2GetDerivatives(component, double *, size_t), fmi2SetContinuousStates(component, const double *, size_t);
int fmi2GetFMUstate(component, void **), fmi2SetFMUstate(component, void *), fmi2FreeFMUstate(component, void **), fmi2SetTime(component, double);
int fmi2SerializedFMUstateSize(component, void *, size_t *), fmi2SerializeFMUstate(component, void *, char *, size_t);
int fmi2DeSerializeFMUstate(component, const char *, size_t, void **);
int fmi2GetDirectionalDerivative(component, const unsigned *, size_t, const unsigned *, size_t, const double *, double *);
int fmi2GetRealStatus(component, int, double *), fmi2CancelStep(component);

static int messages;
static component kept[64]; /* handles stay reachable: the library keeps sixteen bytes of each to recognise a second freeing */
static int keeping;

static void log_message(void *e, const char *name, int status, const char *category, const char *text, ...)
{
    (void)e; (void)name; (void)status; (void)category;
    if (strlen(text) > 0) messages++;
}
static callbacks calls = {log_message, NULL, NULL, NULL, NULL};

#define MUST(condition) do { if (!(condition)) { printf("line %d: %s\n", __LINE__, #condition); exit(1); } } while (0)
#define OK(call) MUST((call) == 0)
#define REFUSED(call) do { int before = messages; MUST((call) == 3); MUST(messages > before); } while (0)

static component fresh(int type, int ready)
{
    component c = fmi2Instantiate("one", type, TOKEN, NULL, &calls, 0, 1);
    MUST(c);
    kept[keeping++] = c;
    if (ready) {
        OK(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0));
        OK(fmi2EnterInitializationMode(c));
        OK(fmi2ExitInitializationMode(c));
    }
    return c;
}

int main(void)
{
    component c;
    void *state = NULL, *stale, *copy = NULL;
    double value = 1.0, many[4], not_a_number = NAN;
    unsigned vr = FORCE, wrong = 4000000000u, out = POSITION, time_vr = 0;
    int whole = 1, n;
    size_t size = 0;
    char *bytes;
    event_info info;

    /* instances that cannot be */
    MUST(!fmi2Instantiate("one", 1, "another model", NULL, &calls, 0, 1));
    MUST(!fmi2Instantiate("", 1, TOKEN, NULL, &calls, 0, 1));
    MUST(!fmi2Instantiate(NULL, 1, NULL, NULL, NULL, 0, 1));
    fmi2FreeInstance(NULL);
    MUST(fmi2DoStep(NULL, 0.0, 0.1, 1) == 3);

    /* calls out of order */
    c = fresh(1, 0);
    REFUSED(fmi2DoStep(c, 0.0, 0.1, 1));
    REFUSED(fmi2ExitInitializationMode(c));
    REFUSED(fmi2GetReal(c, &out, 1, &value));
    REFUSED(fmi2Terminate(c));
    OK(fmi2SetReal(c, &vr, 1, &value));
    REFUSED(fmi2SetupExperiment(c, 0, 0.0, 5.0, 1, 2.0));
    OK(fmi2SetupExperiment(c, 0, 0.0, 0.0, 1, 10.0));
    OK(fmi2EnterInitializationMode(c));
    REFUSED(fmi2EnterInitializationMode(c));
    OK(fmi2ExitInitializationMode(c));
    REFUSED(fmi2EnterContinuousTimeMode(c));
    REFUSED(fmi2GetDerivatives(c, many, 2));

    /* values that cannot be */
    REFUSED(fmi2SetReal(c, &wrong, 1, &value));
    REFUSED(fmi2GetReal(c, &wrong, 1, &value));
    REFUSED(fmi2SetReal(c, &out, 1, &value));
    REFUSED(fmi2SetReal(c, &time_vr, 1, &value));
    REFUSED(fmi2SetReal(c, &vr, 1, &not_a_number));
    value = INFINITY;
    REFUSED(fmi2SetReal(c, &vr, 1, &value));
    REFUSED(fmi2GetReal(c, NULL, 3, &value));
    REFUSED(fmi2SetReal(c, &vr, 1, NULL));
    REFUSED(fmi2GetInteger(c, &vr, 1, &whole));
    REFUSED(fmi2SetInteger(c, &wrong, 1, &whole));
    REFUSED(fmi2GetBoolean(c, &vr, 1, &whole));
    REFUSED(fmi2SetString(c, &vr, 1, NULL));
    OK(fmi2GetReal(c, NULL, 0, NULL));
    OK(fmi2GetReal(c, &vr, 1, &value));
    MUST(value == 1.0); /* what was refused changed nothing */

    /* steps that cannot be */
    REFUSED(fmi2DoStep(c, 0.0, -0.1, 1));
    REFUSED(fmi2DoStep(c, 0.0, 0.0, 1));
    REFUSED(fmi2DoStep(c, 0.0, NAN, 1));
    REFUSED(fmi2DoStep(c, NAN, 0.1, 1));
    REFUSED(fmi2DoStep(c, 3.0, 0.1, 1));
    REFUSED(fmi2DoStep(c, 0.0, 11.0, 1)); /* beyond the stop time */
    REFUSED(fmi2CancelStep(c));
    OK(fmi2DoStep(c, 0.0, 0.5, 1));
    OK(fmi2GetRealStatus(c, 2, &value));
    MUST(value == 0.5);

    /* states that were never stored, or freed */
    OK(fmi2GetFMUstate(c, &state));
    OK(fmi2SerializedFMUstateSize(c, state, &size));
    bytes = malloc(size);
    MUST(bytes);
    REFUSED(fmi2SerializeFMUstate(c, state, bytes, size - 1));
    OK(fmi2SerializeFMUstate(c, state, bytes, size));
    OK(fmi2DeSerializeFMUstate(c, bytes, size, &copy));
    REFUSED(fmi2DeSerializeFMUstate(c, bytes, size - 1, &copy));
    bytes[0] ^= 1;
    REFUSED(fmi2DeSerializeFMUstate(c, bytes, size, &copy));
    free(bytes);
    stale = state;
    OK(fmi2FreeFMUstate(c, &state));
    MUST(!state);
    OK(fmi2FreeFMUstate(c, &state));
    REFUSED(fmi2SetFMUstate(c, stale));
    REFUSED(fmi2FreeFMUstate(c, &stale));
    REFUSED(fmi2SetFMUstate(c, NULL));

    /* sensitivities */
    REFUSED(fmi2GetDirectionalDerivative(c, &vr, 1, &vr, 1, &value, many));
    REFUSED(fmi2GetDirectionalDerivative(c, &out, 1, &wrong, 1, &value, many));
    OK(fmi2GetDirectionalDerivative(c, &out, 1, &vr, 1, &value, many));

    /* the end, twice (the copy of the state that is left goes with the instance) */
    OK(fmi2Terminate(c));
    REFUSED(fmi2DoStep(c, 0.5, 0.1, 1));
    OK(fmi2GetReal(c, &out, 1, &value));
    OK(fmi2Reset(c));
    fmi2FreeInstance(c);
    fmi2FreeInstance(c);
    MUST(fmi2DoStep(c, 0.0, 0.1, 1) == 3);
    MUST(fmi2GetReal(c, &out, 1, &value) == 3);

    /* model exchange */
    c = fresh(0, 1);
    REFUSED(fmi2DoStep(c, 0.0, 0.1, 1));
    OK(fmi2NewDiscreteStates(c, &info));
    OK(fmi2EnterContinuousTimeMode(c));
    REFUSED(fmi2GetDerivatives(c, many, 3));
    REFUSED(fmi2SetContinuousStates(c, many, 1));
    many[0] = many[1] = NAN;
    REFUSED(fmi2SetContinuousStates(c, many, 2));
    REFUSED(fmi2SetTime(c, INFINITY));
    OK(fmi2GetDerivatives(c, many, 2));
    fmi2FreeInstance(c);

    /* many instances, none freed in order */
    for (n = 0; n < 20; n++) {
        c = fresh(1, 1);
        OK(fmi2DoStep(c, 0.0, 0.1 * (n + 1), 1));
    }
    for (n = 0; n < keeping; n += 2) fmi2FreeInstance(kept[n]);
    for (n = 1; n < keeping; n += 2) fmi2FreeInstance(kept[n]);
    printf("%d refusals told\n", messages);
    return 0;
}

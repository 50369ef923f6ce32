/* What FMI 2 and FMI 3 share: instances, the order of calls, access to variables, stored states. */
#ifndef FOWTIO_INSTANCE_H
#define FOWTIO_INSTANCE_H

#include <stdarg.h>
#include <stdio.h>

#include "core.h"

#if defined(_WIN32)
#define FW_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define FW_EXPORT __attribute__((visibility("default")))
#else
#define FW_EXPORT
#endif

enum { FW_INSTANTIATED = 1, FW_INITIALISING = 2, FW_EVENT = 4, FW_CONTINUOUS = 8, FW_STEPPING = 16, FW_TERMINATED = 32 };
#define FW_RUNNING (FW_EVENT | FW_CONTINUOUS | FW_STEPPING)
#define FW_ANY (FW_INSTANTIATED | FW_INITIALISING | FW_RUNNING | FW_TERMINATED)

#define FW_ALIVE 0x464F5754u
#define FW_SEAL 0x31575446u

typedef struct fw_saved {
    struct fw_saved *next;
    fw_values v;
} fw_saved;

struct fw_instance;
typedef void (*fw_logger)(const struct fw_instance *, const char *text);

typedef struct fw_instance {
    fw_model model;
    int co_simulation, logging;
    char name[128];
    fw_saved *saved;
    fw_logger report;
    void *environment, *callback; /* of the importer */
    void (*log3)(void);
} fw_instance;

/* What the importer holds. It outlives the instance (16 bytes), so that a call after the instance was freed, or a second
   freeing, is recognised without a table of instances that all of them would share. */
typedef struct {
    uint32_t alive;
    fw_instance *body;
} fw_handle;

static inline void fw_error(const fw_instance *s, const char *format, ...)
{
    char text[256], *p;
    va_list arguments;
    if (!s->logging || !s->report) return;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (p = text; *p; p++)
        if (*p == '%') *p = '#'; /* importers may print it as a format */
    s->report(s, text);
}

/* The instance behind a handle when a function may be called now; NULL, and a message, otherwise. */
static inline fw_instance *fw_enter(void *c, const char *function, int phases)
{
    fw_handle *h = c;
    if (!h || h->alive != FW_ALIVE || !h->body) return NULL;
    if (!(h->body->model.v.phase & phases)) {
        fw_error(h->body, "%s cannot be called now: see the order of calls in the FMI standard.", function);
        return NULL;
    }
    return h->body;
}

static inline fw_handle *fw_create(const char *name, const char *token, int co_simulation)
{
    fw_handle *h;
    if (!name || !*name || !token || strcmp(token, INSTANTIATION_TOKEN) != 0) return NULL;
    h = calloc(1, sizeof *h);
    if (!h) return NULL;
    h->body = calloc(1, sizeof *h->body);
    if (!h->body) {
        free(h);
        return NULL;
    }
    h->alive = FW_ALIVE;
    h->body->co_simulation = co_simulation;
    strncpy(h->body->name, name, sizeof h->body->name - 1);
    fw_defaults(&h->body->model);
    h->body->model.v.phase = FW_INSTANTIATED;
    return h;
}

static inline void fw_destroy(void *c)
{
    fw_handle *h = c;
    if (!h || h->alive != FW_ALIVE || !h->body) return;
    while (h->body->saved) {
        fw_saved *next = h->body->saved->next;
        free(h->body->saved);
        h->body->saved = next;
    }
    fw_release(&h->body->model);
    free(h->body);
    h->body = NULL;
    h->alive = 0;
}

static inline int fw_reset(fw_instance *s)
{
    fw_defaults(&s->model);
    s->model.v.phase = FW_INSTANTIATED;
    return 1;
}

static inline int fw_initialise(fw_instance *s, double start, int stop_defined, double stop)
{
    if (!isfinite(start) || (stop_defined && !(stop > start))) {
        fw_error(s, "The start time %g and the stop time %g are not in order.", start, stop);
        return 0;
    }
    s->model.v.time = start;
    s->model.v.stop_defined = stop_defined;
    s->model.v.stop = stop_defined ? stop : 0.0;
    s->model.v.phase = FW_INITIALISING;
    if (!fw_prepare(&s->model)) {
        fw_error(s, "There is not enough memory for sea and wind.");
        return 0;
    }
    fw_start_state(&s->model);
    return 1;
}

/* After a parameter or an input has changed before the start, what follows from it. */
static inline int fw_refresh(fw_instance *s)
{
    if (s->model.v.phase != FW_INITIALISING) return 1;
    if (!fw_prepare(&s->model)) {
        fw_error(s, "There is not enough memory for sea and wind.");
        return 0;
    }
    fw_start_state(&s->model);
    return 1;
}

static inline int fw_get_real(fw_instance *s, const uint32_t *vr, size_t n, double *value)
{
    double derivative[N_STATE + 1];
    int known = 0;
    size_t i;
    if (n && (!vr || !value)) {
        fw_error(s, "A null pointer was given for %lu values.", (unsigned long)n);
        return 0;
    }
    for (i = 0; i < n; i++) {
        int k;
        if (vr[i] >= N_VARIABLE || variable_kind[vr[i]] == V_INTEGER) {
            fw_error(s, "There is no real variable with value reference %lu.", (unsigned long)vr[i]);
            return 0;
        }
        k = variable_index[vr[i]];
        switch (variable_kind[vr[i]]) {
        case V_TIME: value[i] = s->model.v.time; break;
        case V_INPUT: value[i] = s->model.v.input[k]; break;
        case V_PARAMETER: value[i] = s->model.v.parameter[k]; break;
        case V_CONSTANT: value[i] = constant[k]; break;
        case V_STATE: value[i] = s->model.v.state[k]; break;
        case V_OUTPUT: value[i] = fw_outputs(&s->model)[k]; break;
        default:
            if (!known) fw_derivatives(&s->model, derivative);
            known = 1;
            value[i] = derivative[k];
        }
    }
    return 1;
}

static inline int fw_set_real(fw_instance *s, const uint32_t *vr, size_t n, const double *value)
{
    int before = s->model.v.phase & (FW_INSTANTIATED | FW_INITIALISING);
    size_t i;
    if (n && (!vr || !value)) {
        fw_error(s, "A null pointer was given for %lu values.", (unsigned long)n);
        return 0;
    }
    for (i = 0; i < n; i++) { /* look at all before any is set */
        int kind;
        if (vr[i] >= N_VARIABLE) {
            fw_error(s, "There is no variable with value reference %lu.", (unsigned long)vr[i]);
            return 0;
        }
        kind = variable_kind[vr[i]];
        if (kind != V_INPUT && !(kind == V_PARAMETER && before)) {
            fw_error(s, "The variable with value reference %lu cannot be set now.", (unsigned long)vr[i]);
            return 0;
        }
        if (!isfinite(value[i])) {
            fw_error(s, "The value %g for value reference %lu is not a finite number.", value[i], (unsigned long)vr[i]);
            return 0;
        }
        if (kind == V_PARAMETER) {
            int k = variable_index[vr[i]];
            if (value[i] < parameter_least[k] || value[i] > parameter_most[k]) {
                fw_error(s, "The value %g for value reference %lu lies outside %g to %g.", value[i], (unsigned long)vr[i],
                         parameter_least[k], parameter_most[k]);
                return 0;
            }
        }
    }
    for (i = 0; i < n; i++) {
        double *place = variable_kind[vr[i]] == V_INPUT ? s->model.v.input : s->model.v.parameter;
        place[variable_index[vr[i]]] = value[i];
    }
    s->model.output_known = 0;
    return fw_refresh(s);
}

static inline int fw_get_integer(fw_instance *s, const uint32_t *vr, size_t n, int32_t *value)
{
    size_t i;
    for (i = 0; i < n; i++) {
        if (!vr || !value || vr[i] >= N_VARIABLE || variable_kind[vr[i]] != V_INTEGER) {
            fw_error(s, "There is no integer variable with the value reference given.");
            return 0;
        }
        value[i] = s->model.v.integer[variable_index[vr[i]]];
    }
    return 1;
}

static inline int fw_set_integer(fw_instance *s, const uint32_t *vr, size_t n, const int32_t *value)
{
    size_t i;
    for (i = 0; i < n; i++) {
        int k;
        if (!vr || !value || vr[i] >= N_VARIABLE || variable_kind[vr[i]] != V_INTEGER) {
            fw_error(s, "There is no integer variable with the value reference given.");
            return 0;
        }
        k = variable_index[vr[i]];
        if (!(s->model.v.phase & (FW_INSTANTIATED | FW_INITIALISING)) || value[i] < integer_least[k] || value[i] > integer_most[k]) {
            fw_error(s, "The integer with value reference %lu cannot be set now, or not to %ld.", (unsigned long)vr[i], (long)value[i]);
            return 0;
        }
    }
    for (i = 0; i < n; i++) s->model.v.integer[variable_index[vr[i]]] = value[i];
    return fw_refresh(s);
}

static inline int fw_do_step(fw_instance *s, double t, double h)
{
    fw_values *v = &s->model.v;
    if (!isfinite(t) || !isfinite(h) || !(h > 0.0)) {
        fw_error(s, "A step of %g s from %g s is not possible: the step must be positive.", h, t);
        return 0;
    }
    if (fabs(t - v->time) > 1e-6 * (h + 1.0) + 1e-12 * fabs(t)) {
        fw_error(s, "The step starts at %g s, but the instance is at %g s.", t, v->time);
        return 0;
    }
    if (v->stop_defined && t + h > v->stop + 1e-6 * (h + 1.0)) {
        fw_error(s, "The step ends at %g s, after the stop time of %g s.", t + h, v->stop);
        return 0;
    }
    if (fw_moving(&s->model) && h / LARGEST_PART > 1e8) {
        fw_error(s, "A step of %g s is too long.", h);
        return 0;
    }
    v->time = t;
    fw_step(&s->model, h);
    return 1;
}

/* Sensitivities of unknowns to knowns: forward (adjoint 0) or transposed (1). */
static inline int fw_jacobian(fw_instance *s, const uint32_t *unknown, size_t n, const uint32_t *known, size_t m, const double *seed,
                              double *out, int adjoint)
{
    size_t i, j;
    if ((n && !unknown) || (m && !known) || ((n || m) && (!seed || !out))) return 0;
    for (i = 0; i < n; i++)
        if (unknown[i] >= N_VARIABLE || (variable_kind[unknown[i]] != V_OUTPUT && variable_kind[unknown[i]] != V_DERIVATIVE)) {
            fw_error(s, "Value reference %lu is no output and no derivative of a state.", (unsigned long)unknown[i]);
            return 0;
        }
    for (j = 0; j < m; j++)
        if (known[j] >= N_VARIABLE || (variable_kind[known[j]] != V_INPUT && variable_kind[known[j]] != V_STATE)) {
            fw_error(s, "Value reference %lu is no input and no state.", (unsigned long)known[j]);
            return 0;
        }
    for (i = 0; i < (adjoint ? m : n); i++) out[i] = 0.0;
    for (i = 0; i < n; i++)
        for (j = 0; j < m; j++) {
            double d = fw_partial(variable_kind[unknown[i]] == V_OUTPUT, variable_index[unknown[i]], variable_kind[known[j]] == V_INPUT,
                                  variable_index[known[j]]);
            if (adjoint) out[j] += d * seed[i];
            else out[i] += d * seed[j];
        }
    return 1;
}

/* --- stored states: kept in a list, so that what was freed or never made is recognised */

static inline fw_saved *fw_find(const fw_instance *s, const void *saved)
{
    fw_saved *p = s->saved;
    while (p && p != saved) p = p->next;
    return p;
}

static inline fw_saved *fw_save(fw_instance *s, void *old)
{
    fw_saved *p = fw_find(s, old);
    if (!p) {
        p = calloc(1, sizeof *p);
        if (!p) return NULL;
        p->next = s->saved;
        s->saved = p;
    }
    p->v = s->model.v;
    return p;
}

static inline int fw_restore(fw_instance *s, const void *saved)
{
    fw_saved *p = fw_find(s, saved);
    if (!p) {
        fw_error(s, "This state was not stored by this instance, or was freed.");
        return 0;
    }
    s->model.v = p->v;
    return fw_prepare(&s->model);
}

static inline int fw_forget(fw_instance *s, void *saved)
{
    fw_saved **p = &s->saved;
    if (!saved) return 1;
    while (*p && *p != saved) p = &(*p)->next;
    if (!*p) {
        fw_error(s, "This state was not stored by this instance, or was freed.");
        return 0;
    }
    saved = *p;
    *p = (*p)->next;
    free(saved);
    return 1;
}

typedef struct {
    uint32_t seal;
    char token[64];
    fw_values v;
} fw_serial;

static inline int fw_serialise(fw_instance *s, const void *saved, void *bytes, size_t size)
{
    fw_saved *p = fw_find(s, saved);
    fw_serial *serial;
    if (!p || !bytes || size < sizeof *serial) {
        fw_error(s, "The state is not known, or the memory for it is too small.");
        return 0;
    }
    serial = calloc(1, sizeof *serial);
    if (!serial) return 0;
    serial->seal = FW_SEAL;
    strncpy(serial->token, INSTANTIATION_TOKEN, sizeof serial->token - 1);
    serial->v = p->v;
    memcpy(bytes, serial, sizeof *serial);
    free(serial);
    return 1;
}

static inline fw_saved *fw_deserialise(fw_instance *s, const void *bytes, size_t size, void *old)
{
    fw_serial *serial = NULL;
    fw_saved *p = NULL;
    char token[64] = INSTANTIATION_TOKEN;
    if (bytes && size >= sizeof *serial) serial = malloc(sizeof *serial);
    if (serial) {
        memcpy(serial, bytes, sizeof *serial);
        if (serial->seal == FW_SEAL && memcmp(serial->token, token, sizeof token) == 0) p = fw_save(s, old);
    }
    if (p) p->v = serial->v;
    else fw_error(s, "These bytes are not a state of this model.");
    free(serial);
    return p;
}

#endif

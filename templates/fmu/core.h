/* The linear model in modal form: exact steps, derivatives, outputs, and an internal sea and wind. C99, libc and libm only.

   No global variable that changes: all that a simulation changes lies in fw_values, all that it needs in fw_model.
   Licence: see LICENSE beside this file. */
#ifndef FOWTIO_CORE_H
#define FOWTIO_CORE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "model_data.h"

#define FW_MODES (N_REAL + N_PAIR)

/* What get and set state copy: plain values, no pointers. */
typedef struct {
    double time, stop;
    int stop_defined, phase;
    double state[N_STATE + 1];
    double input[N_INPUT + 1];
    double slope[N_INPUT + 1];    /* time derivative of an input, for the next step only */
    double previous[N_INPUT + 1]; /* inputs at the start of the last step, for interpolation */
    double parameter[N_PARAMETER + 1];
    int32_t integer[N_INTEGER + 1];
} fw_values;

typedef struct {
    fw_values v;
    double output[N_OUTPUT + 1];
    int output_known;
    double step; /* the step that the factors below belong to */
    double factor[FW_MODES + 1][6]; /* e^(lh); its integral; its integral with the ramp: real and imaginary parts */
#if HAS_SEA
    int sea_first, sea_count, sea_outputs, sea_column[8];
    double sea_parameter[4];
    int32_t sea_seed;
    double *sea; /* blocks of components of the forces that are not zero, and of the elevation */
#endif
#if HAS_TURBULENCE
    double wind_intensity;
    int32_t wind_seed;
    double *wind; /* blocks of components of wind and its two gradients */
#endif
    double signal_time; /* the time that the signal below belongs to */
    double signal[N_COLUMN + 1];
} fw_model;

static inline double fw_random(uint64_t seed, uint64_t number)
{
    /* splitmix64 (Steele, Lea, Flood 2014): a uniform number in [0, 1) for every pair of seed and number */
    uint64_t z = seed * UINT64_C(0x9E3779B97F4A7C15) + (number + 1) * UINT64_C(0xD1B54A32D192ED03);
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    z ^= z >> 31;
    return (double)(z >> 11) * (1.0 / 9007199254740992.0);
}

/* Add up components: for every output the real part of the sum of (re + i im) e^(i (first + k) dw t), four components at a time,
   whose factors do not wait for each other. A block holds, for every output, four re and four im. */
static inline void fw_sum(const double *block, int count, int outputs, int first, double dw, double t, double *out)
{
    double turn = fmod(dw * t, 6.283185307179586);
    double sr = cos(fmod(4.0 * turn, 6.283185307179586)), si = sin(fmod(4.0 * turn, 6.283185307179586));
    double zr[4], zi[4], sum[8][4] = {{0}};
    int k, j, c;
    for (c = 0; c < 4; c++) {
        zr[c] = cos(fmod((first + c) * turn, 6.283185307179586));
        zi[c] = sin(fmod((first + c) * turn, 6.283185307179586));
    }
    for (k = 0; k < count; k += 4) {
        for (j = 0; j < outputs; j++, block += 8)
            for (c = 0; c < 4; c++) sum[j][c] += zr[c] * block[c] - zi[c] * block[4 + c];
        for (c = 0; c < 4; c++) {
            double next = zr[c] * sr - zi[c] * si;
            zi[c] = zr[c] * si + zi[c] * sr;
            zr[c] = next;
        }
    }
    for (j = 0; j < outputs; j++) out[j] = (sum[j][0] + sum[j][1]) + (sum[j][2] + sum[j][3]);
}

/* The place of output j of component k in blocks of `outputs` outputs; the imaginary part lies four behind. */
static inline size_t fw_place(int k, int j, int outputs) { return ((size_t)(k / 4) * (size_t)outputs + (size_t)j) * 8 + (size_t)(k % 4); }

#if HAS_SEA
static inline double fw_jonswap(double f, double height, double period, double gamma)
{
    /* IEC 61400-3 annex B: one-sided spectrum in m2/Hz */
    double x = f * period, width = x <= 1.0 ? 0.07 : 0.09, q = (x - 1.0) / width;
    return 0.3125 * height * height * period * pow(x, -5.0) * exp(-1.25 * pow(x, -4.0)) * (1.0 - 0.287 * log(gamma))
           * pow(gamma, exp(-0.5 * q * q));
}

/* Wave force of one component, per metre, into force[12]: real and imaginary parts of six; linear in frequency and heading. */
static inline void fw_wave_force(double omega, double heading, double *force)
{
    const double turn = 6.283185307179586;
    double angle = heading, share = 0.0, weight;
    int h = 0, k = 0, j;
    if (N_HEADING > 1) {
        while (angle < sea_heading[0] - 1e-9) angle += turn;
        while (angle > sea_heading[0] + turn + 1e-9) angle -= turn;
        while (h < N_HEADING - 2 && sea_heading[h + 1] <= angle) h++;
        share = (angle - sea_heading[h]) / (sea_heading[h + 1] - sea_heading[h]);
        share = share < 0.0 ? 0.0 : share > 1.0 ? 1.0 : share;
    }
    while (k < N_SEA_OMEGA - 2 && sea_omega[k + 1] <= omega) k++;
    weight = (omega - sea_omega[k]) / (sea_omega[k + 1] - sea_omega[k]);
    weight = weight < 0.0 ? 0.0 : weight > 1.0 ? 1.0 : weight;
    for (j = 0; j < 12; j++) {
        double low = (1.0 - weight) * (double)sea_force[h][k][j] + weight * (double)sea_force[h][k + 1][j];
        if (N_HEADING > 1) {
            int g = h + 1;
            low = (1.0 - share) * low
                  + share * ((1.0 - weight) * (double)sea_force[g][k][j] + weight * (double)sea_force[g][k + 1][j]);
        }
        force[j] = low;
    }
}

/* Make the components of the sea from its parameters; 0 when memory is short. */
static inline int fw_make_sea(fw_model *m)
{
    const double *p = m->v.parameter;
    double now[4], df = 1.0 / REPEAT_PERIOD, force[12], largest[6] = {0};
    int32_t seed = m->v.integer[I_SEA_SEED];
    int last, k, j;
    now[0] = p[P_SEA_HS]; now[1] = p[P_SEA_TP]; now[2] = p[P_SEA_GAMMA]; now[3] = p[P_SEA_HEADING];
    if (m->sea && m->sea_seed == seed && memcmp(now, m->sea_parameter, sizeof now) == 0) return 1;
    free(m->sea);
    m->sea = NULL;
    m->sea_count = m->sea_outputs = 0;
    if (now[0] > 0.0) {
        m->sea_first = (int)ceil(0.4 / now[1] / df);
        if (m->sea_first < 1) m->sea_first = 1;
        last = (int)floor(fmin(5.0 / now[1], SEA_TOP) / df);
        m->sea_count = last >= m->sea_first ? last - m->sea_first + 1 : 0;
    }
    for (k = 0; k < m->sea_count; k++) {
        fw_wave_force(6.283185307179586 * (m->sea_first + k) * df, now[3], force);
        for (j = 0; j < 6; j++) largest[j] = fmax(largest[j], fmax(fabs(force[2 * j]), fabs(force[2 * j + 1])));
    }
    for (j = 0; j < 6; j++) { /* what symmetry makes zero but for rounding is left out */
        int of = j < 3 ? 0 : 3;
        if (largest[j] > 1e-7 * fmax(largest[of], fmax(largest[of + 1], largest[of + 2]))) m->sea_column[m->sea_outputs++] = j;
    }
    m->sea_column[m->sea_outputs++] = 6;
    m->sea = calloc(((size_t)m->sea_count + 4) * 16, sizeof *m->sea);
    if (!m->sea) return 0;
    memcpy(m->sea_parameter, now, sizeof now);
    m->sea_seed = seed;
    for (k = 0; k < m->sea_count; k++) {
        double f = (m->sea_first + k) * df;
        double a = sqrt(2.0 * fw_jonswap(f, now[0], now[1], now[2]) * df);
        double phase = 6.283185307179586 * fw_random((uint64_t)(uint32_t)seed, (uint64_t)(m->sea_first + k));
        double re = a * cos(phase), im = a * sin(phase);
        fw_wave_force(6.283185307179586 * f, now[3], force);
        for (j = 0; j < m->sea_outputs; j++) {
            double *place = m->sea + fw_place(k, j, m->sea_outputs);
            int column = m->sea_column[j];
            double fr = column < 6 ? force[2 * column] : 1.0, fi = column < 6 ? force[2 * column + 1] : 0.0;
            place[0] = re * fr - im * fi;
            place[4] = re * fi + im * fr;
        }
    }
    return 1;
}
#endif

#if HAS_TURBULENCE
/* Make the components of the turbulence from its parameters; 0 when memory is short. */
static inline int fw_make_wind(fw_model *m)
{
    double intensity = m->v.parameter[P_WIND_TI];
    int32_t seed = m->v.integer[I_WIND_SEED];
    int k, j;
    if (m->wind && m->wind_seed == seed && m->wind_intensity == intensity) return 1;
    if (!m->wind) m->wind = calloc((N_WIND + 4) * 6, sizeof *m->wind);
    if (!m->wind) return 0;
    m->wind_seed = seed;
    m->wind_intensity = intensity;
    for (k = 0; k < N_WIND; k++)
        for (j = 0; j < 3; j++) {
            double phase = 6.283185307179586 * fw_random((uint64_t)(uint32_t)seed, (uint64_t)(3 * k + j) + (UINT64_C(1) << 32));
            double a = intensity * (double)wind_amplitude[j > 0][k];
            m->wind[fw_place(k, j, 3)] = a * cos(phase);
            m->wind[fw_place(k, j, 3) + 4] = a * sin(phase);
        }
    return 1;
}
#endif

/* Whether sea or turbulence are on, so that columns change within a step. */
static inline int fw_moving(const fw_model *m)
{
    int on = 0;
#if HAS_SEA
    on = on || m->sea_count > 0;
#endif
#if HAS_TURBULENCE
    on = on || m->v.parameter[P_WIND_TI] != 0.0;
#endif
    (void)m;
    return on;
}

/* Make all that depends on parameters; 0 when memory is short. */
static inline int fw_prepare(fw_model *m)
{
    int ok = 1;
#if HAS_SEA
    ok = ok && fw_make_sea(m);
#endif
#if HAS_TURBULENCE
    ok = ok && fw_make_wind(m);
#endif
    m->signal_time = NAN;
    m->output_known = 0;
    return ok;
}

/* What sea, turbulence and the wind's offset add to the columns at a time. */
static inline const double *fw_signal(fw_model *m, double t)
{
    if (m->signal_time == t) return m->signal;
    memset(m->signal, 0, sizeof m->signal);
#if HAS_SEA
    if (m->sea_count > 0) {
        double s[8];
        int j;
        fw_sum(m->sea, m->sea_count, m->sea_outputs, m->sea_first, 6.283185307179586 / REPEAT_PERIOD, t, s);
        for (j = 0; j < m->sea_outputs; j++) m->signal[m->sea_column[j] < 6 ? COLUMN_WAVE + m->sea_column[j] : COLUMN_SEA] += s[j];
    }
#endif
#if HAS_TURBULENCE
    m->signal[COLUMN_WIND] += m->v.parameter[P_WIND_OFFSET];
    if (m->v.parameter[P_WIND_TI] != 0.0) {
        double s[4];
        int j;
        fw_sum(m->wind, N_WIND, 3, 1, 6.283185307179586 / REPEAT_PERIOD, t, s);
        for (j = 0; j < 3; j++) m->signal[COLUMN_WIND + j] += s[j];
    }
#endif
    m->signal_time = t;
    return m->signal;
}

/* The columns u at a time, for inputs given. */
static inline void fw_columns(fw_model *m, double t, const double *input, double *u)
{
    int i;
    memcpy(u, fw_signal(m, t), sizeof(double) * N_COLUMN);
    for (i = 0; i < N_INPUT; i++) u[input_column[i]] += input[i] - input_offset[i];
}

/* out = B u, columns that are zero skipped. */
static inline void fw_drive(const double *u, double *out)
{
    int c, k;
    memset(out, 0, sizeof(double) * N_STATE);
    for (c = 0; c < N_COLUMN; c++) {
        double x = u[c];
        if (x != 0.0)
            for (k = 0; k < N_STATE; k++) out[k] += matrix_b[c][k] * x;
    }
}

static inline void fw_complex_factors(double re, double im, double h, double *f)
{
    /* with x = l h: e^x; h (e^x - 1)/x; h (e^x - 1 - x)/x^2, by series where the quotients would cancel */
    double xr = re * h, xi = im * h, size = xr * xr + xi * xi;
    double er = exp(xr) * cos(xi), ei = exp(xr) * sin(xi);
    double ar, ai, br, bi;
    if (size < 0.25) {
        int k;
        ar = br = 0.0;
        ai = bi = 0.0;
        for (k = 18; k >= 0; k--) { /* Horner: phi = sum x^k/(k+1)! and sum x^k/(k+2)! */
            double t = (ar * xr - ai * xi) / (k + 2);
            ai = (ar * xi + ai * xr) / (k + 2);
            ar = 1.0 + t;
            t = (br * xr - bi * xi) / (k + 3);
            bi = (br * xi + bi * xr) / (k + 3);
            br = 1.0 + t;
        }
        br *= 0.5;
        bi *= 0.5;
    } else {
        double nr = er - 1.0, ni = ei;
        ar = (nr * xr + ni * xi) / size;
        ai = (ni * xr - nr * xi) / size;
        nr = ar - 1.0;
        ni = ai;
        br = (nr * xr + ni * xi) / size;
        bi = (ni * xr - nr * xi) / size;
    }
    f[0] = er; f[1] = ei; f[2] = h * ar; f[3] = h * ai; f[4] = h * br; f[5] = h * bi;
}

static inline void fw_factors(fw_model *m, double h)
{
    int k;
    if (m->step == h) return;
    for (k = 0; k < N_REAL; k++) fw_complex_factors(pole_real[k], 0.0, h, m->factor[k]);
    for (k = 0; k < N_PAIR; k++) fw_complex_factors(-pole_decay[k], -pole_frequency[k], h, m->factor[N_REAL + k]);
    m->step = h;
}

/* One exact step of every mode for drives that go linearly from a to b. */
static inline void fw_advance(fw_model *m, const double *a, const double *b)
{
    double *z = m->v.state;
    int k;
    for (k = 0; k < N_REAL; k++) {
        const double *f = m->factor[k];
        z[k] = f[0] * z[k] + f[2] * a[k] + f[4] * (b[k] - a[k]);
    }
    for (k = 0; k < N_PAIR; k++) {
        const double *f = m->factor[N_REAL + k];
        int i = N_REAL + 2 * k, j = i + 1;
        double zr = z[i], zi = z[j], dr = b[i] - a[i], di = b[j] - a[j];
        z[i] = f[0] * zr - f[1] * zi + f[2] * a[i] - f[3] * a[j] + f[4] * dr - f[5] * di;
        z[j] = f[0] * zi + f[1] * zr + f[2] * a[j] + f[3] * a[i] + f[4] * di + f[5] * dr;
    }
}

/* Advance by h: inputs are held, or follow their slopes, or (interpolation 1) go from their last values to the present ones. */
static inline void fw_step(fw_model *m, double h)
{
    double from[N_INPUT + 1], to[N_INPUT + 1], now[N_INPUT + 1], u[N_COLUMN + 1];
    double drive[2][N_STATE + 1];
    double start = m->v.time;
    long parts = fw_moving(m) ? (long)ceil(h / LARGEST_PART - 1e-9) : 1, k;
    int i, at = 0;
    if (parts < 1) parts = 1;
    for (i = 0; i < N_INPUT; i++) {
        from[i] = m->v.integer[I_INTERPOLATION] ? m->v.previous[i] : m->v.input[i];
        to[i] = m->v.integer[I_INTERPOLATION] ? m->v.input[i] : m->v.input[i] + h * m->v.slope[i];
    }
    fw_factors(m, h / (double)parts);
    fw_columns(m, start, from, u);
    fw_drive(u, drive[at]);
    for (k = 1; k <= parts; k++, at = !at) {
        double share = (double)k / (double)parts;
        for (i = 0; i < N_INPUT; i++) now[i] = from[i] + share * (to[i] - from[i]);
        fw_columns(m, k == parts ? start + h : start + share * h, now, u);
        fw_drive(u, drive[!at]);
        fw_advance(m, drive[at], drive[!at]);
    }
    m->v.time = start + h;
    for (i = 0; i < N_INPUT; i++) {
        m->v.input[i] = m->v.previous[i] = to[i];
        m->v.slope[i] = 0.0;
    }
    m->output_known = 0;
}

static inline void fw_derivatives(fw_model *m, double *out)
{
    double u[N_COLUMN + 1];
    const double *z = m->v.state;
    int k;
    fw_columns(m, m->v.time, m->v.input, u);
    fw_drive(u, out);
    for (k = 0; k < N_REAL; k++) out[k] += pole_real[k] * z[k];
    for (k = 0; k < N_PAIR; k++) {
        int i = N_REAL + 2 * k;
        out[i] += -pole_decay[k] * z[i] + pole_frequency[k] * z[i + 1];
        out[i + 1] += -pole_frequency[k] * z[i] - pole_decay[k] * z[i + 1];
    }
}

static inline const double *fw_outputs(fw_model *m)
{
    double u[N_COLUMN + 1];
    int k, c;
    if (m->output_known) return m->output;
    memcpy(m->output, output_mean, sizeof(double) * N_OUTPUT);
    for (k = 0; k < N_STATE; k++) {
        double z = m->v.state[k];
        if (z != 0.0)
            for (c = 0; c < N_OUTPUT; c++) m->output[c] += matrix_c[k][c] * z;
    }
    fw_columns(m, m->v.time, m->v.input, u);
    for (k = 0; k < N_COLUMN; k++)
        if (u[k] != 0.0)
            for (c = 0; c < N_OUTPUT; c++) m->output[c] += matrix_d[k][c] * u[k];
    m->output_known = 1;
    return m->output;
}

/* Partial derivatives: of the derivative of state i or of output i, by state j or input j. */
static inline double fw_partial(int of_output, int i, int by_input, int j)
{
    if (by_input) return of_output ? matrix_d[input_column[j]][i] : matrix_b[input_column[j]][i];
    if (of_output) return matrix_c[j][i];
    if (i < N_REAL || j < N_REAL) return i == j ? pole_real[i] : 0.0;
    if ((i - N_REAL) / 2 != (j - N_REAL) / 2) return 0.0;
    if (i == j) return -pole_decay[(i - N_REAL) / 2];
    return i < j ? pole_frequency[(i - N_REAL) / 2] : -pole_frequency[(i - N_REAL) / 2];
}

static inline void fw_defaults(fw_model *m)
{
    memset(&m->v, 0, sizeof m->v);
    memcpy(m->v.input, input_start, sizeof(double) * N_INPUT);
    memcpy(m->v.parameter, parameter_start, sizeof(double) * N_PARAMETER);
    memcpy(m->v.integer, integer_start, sizeof(int32_t) * N_INTEGER);
    m->step = m->signal_time = NAN;
    m->output_known = 0;
}

/* The state at the start: initial deviations and rates, turned into modes. */
static inline void fw_start_state(fw_model *m)
{
    int i, k;
    memset(m->v.state, 0, sizeof m->v.state);
    for (i = 0; i < N_INITIAL; i++) {
        double x = m->v.parameter[P_INITIAL + i];
        if (x != 0.0)
            for (k = 0; k < N_STATE; k++) m->v.state[k] += matrix_initial[i][k] * x;
    }
    memcpy(m->v.previous, m->v.input, sizeof m->v.previous);
    m->output_known = 0;
}

static inline void fw_release(fw_model *m)
{
#if HAS_SEA
    free(m->sea);
    m->sea = NULL;
#endif
#if HAS_TURBULENCE
    free(m->wind);
    m->wind = NULL;
#endif
    (void)m;
}

#endif

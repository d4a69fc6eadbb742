/* SPDX-License-Identifier: MIT */
/* Reads what scene_flat.py prints; World = index * spacing, first axis fastest. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

struct scene {
    char name[64], file[1024];
    int dims[3], size[2], warmup, frames, nop, ncol;
    double spacing[3], unit, pos[3], focal[3], up[3], angle, light[4], orbit;
    double op[64][2], col[64][4];
};

static int scene_read(FILE *f, struct scene *s)
{
    char key[32];
    memset(s, 0, sizeof *s);
    while (fscanf(f, "%31s", key) == 1) {
        double *v = 0;
        int n = 0;
        if (!strcmp(key, "name"))
            n = fscanf(f, "%63s", s->name);
        else if (!strcmp(key, "file"))
            n = fscanf(f, " %1023[^\n]", s->file);
        else if (!strcmp(key, "dims"))
            n = fscanf(f, "%d%d%d", s->dims, s->dims + 1, s->dims + 2);
        else if (!strcmp(key, "size"))
            n = fscanf(f, "%d%d", s->size, s->size + 1);
        else if (!strcmp(key, "orbit"))
            n = fscanf(f, "%lf%d%d", &s->orbit, &s->warmup, &s->frames);
        else if (!strcmp(key, "opacity")) {
            n = fscanf(f, "%d", &s->nop);
            for (int i = 0; i < s->nop * 2; i++)
                n = fscanf(f, "%lf", &s->op[i / 2][i % 2]);
        } else if (!strcmp(key, "color")) {
            n = fscanf(f, "%d", &s->ncol);
            for (int i = 0; i < s->ncol * 4; i++)
                n = fscanf(f, "%lf", &s->col[i / 4][i % 4]);
        } else {
            int want = 3;
            v = !strcmp(key, "spacing")    ? s->spacing
                : !strcmp(key, "position") ? s->pos
                : !strcmp(key, "focal")    ? s->focal
                : !strcmp(key, "up")       ? s->up
                : !strcmp(key, "shading")  ? (want = 4, s->light)
                                           : (want = 1, (double *)0);
            if (!v)
                v = !strcmp(key, "unit") ? &s->unit : !strcmp(key, "angle") ? &s->angle : 0;
            if (!v)
                return 0;
            for (int i = 0; i < want; i++)
                n = fscanf(f, "%lf", v + i);
        }
        if (n < 1)
            return 0;
    }
    return s->dims[0] > 0;
}

static unsigned char *scene_load(const struct scene *s)
{
    size_t n = (size_t)s->dims[0] * s->dims[1] * s->dims[2];
    unsigned char *d = malloc(n + 64); /* slack: 4-byte loads at the last voxel stay inside */
    FILE *f = fopen(s->file, "rb");
    if (!f || !d || fread(d, 1, n, f) != n) {
        perror(s->file);
        exit(1);
    }
    fclose(f);
    memset(d + n, 0, 64);
    return d;
}

/* Piecewise linear, clamped; row = 2 or 4 doubles, the value first; out = row - 1 doubles. */
static void curve(const double *p, int n, int row, double x, double *out)
{
    int k = 0;
    while (k < n - 1 && x > p[(k + 1) * row])
        k++;
    double t = k < n - 1 ? (x - p[k * row]) / (p[(k + 1) * row] - p[k * row]) : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    for (int c = 1; c < row; c++)
        out[c - 1] = p[k * row + c] + (k < n - 1 ? t * (p[(k + 1) * row + c] - p[k * row + c]) : 0);
}

/* The camera of frame k: turned k * orbit degrees about up (VTK's Azimuth). right, up, back are orthonormal. */
static void scene_camera(const struct scene *s, int k, double pos[3], double right[3], double up[3], double back[3])
{
    double a = s->orbit * k * M_PI / 180, c = cos(a), n = 0, d[3], u[3], x[3], dot = 0, l = 0;
    for (int i = 0; i < 3; i++)
        n += s->up[i] * s->up[i];
    for (int i = 0; i < 3; i++) {
        u[i] = s->up[i] / sqrt(n);
        d[i] = s->pos[i] - s->focal[i];
        dot += u[i] * d[i];
    }
    for (int i = 0; i < 3; i++)
        x[i] = u[(i + 1) % 3] * d[(i + 2) % 3] - u[(i + 2) % 3] * d[(i + 1) % 3];
    for (int i = 0; i < 3; i++) {
        back[i] = c * d[i] + sin(a) * x[i] + (1 - c) * dot * u[i];
        pos[i] = s->focal[i] + back[i];
        l += back[i] * back[i];
    }
    for (int i = 0; i < 3; i++)
        back[i] /= sqrt(l);
    for (int i = 0; i < 3; i++)
        right[i] = u[(i + 1) % 3] * back[(i + 2) % 3] - u[(i + 2) % 3] * back[(i + 1) % 3];
    l = sqrt(right[0] * right[0] + right[1] * right[1] + right[2] * right[2]);
    for (int i = 0; i < 3; i++)
        right[i] /= l;
    for (int i = 0; i < 3; i++)
        up[i] = back[(i + 1) % 3] * right[(i + 2) % 3] - back[(i + 2) % 3] * right[(i + 1) % 3];
}

static double now_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1e3 + t.tv_nsec * 1e-6;
}

static void print_list(const char *key, const double *ms, int n)
{
    printf(", \"%s\": [", key);
    for (int i = 0; i < n; i++)
        printf("%s%.2f", i ? ", " : "", ms[i]);
    printf("]");
}

static long peak_mb(void)
{
    struct rusage r;
    getrusage(RUSAGE_SELF, &r);
    return r.ru_maxrss / 1024;
}

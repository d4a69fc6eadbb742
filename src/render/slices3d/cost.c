/* SPDX-License-Identifier: MIT */
/* The cost model of sections 2 and 3.5 (3.3 and 3.4.5 of the dissertation), beside what it is a model of. Everything is measured on the
 * spot: fragments by the GPU's own queries, times by whole passes over the same view.
 *
 *   F      fragments of all slices             T_s  time of one with the simple shader
 *   F_t    of phi_t's back faces               T_z  of one that the z-buffer discards early; the papers take T_s for it
 *   F_p    of phi_p's front faces              T_c  with the complex shader, the volume's
 *   F_c'   that the z-buffer lets through
 *   F_c    that two passes a slice let through (section 2)
 *
 *   (2)  two passes, with T_z as measured:  F T_c / (F_s T_s + (F - F_c) T_z + F_c T_c), F_s = F
 *   (5)  the same with T_z = T_s:           1 / (alpha gamma + 1 - alpha + gamma), alpha = (F - F_c) / F, gamma = T_s / T_c
 *   (6)  worth while where                  (1 - gamma) (alpha + 1) > 1
 *   (9)  this frame's way of culling:       F T_c / ((F_t + F_p) T_s + (F - F_c') T_s + F_c' T_c) */
#include "fail.h"
#include "slices3d.h"
#include "timer.h"

struct cost {
    double f, f_t, f_p, f_c, f_c2;    /* the last: F_c' */
    double t_s, t_z, t_c;             /* ms a fragment */
    double basic, two_passes, culled; /* ms a frame, as measured */
};

/* ms of a pass, waited for; the second time, when drivers have compiled all they want. */
typedef bool pass(struct pel_slices3d *s, struct pel_error *error);
static bool time_pass(struct pel_slices3d *s, pass *run, double *ms, struct pel_error *error)
{
    bool ok = true;
    for (int i = 0; i < 2 && ok; i++) {
        glFinish();
        double start = pel_now_ms();
        ok = run(s, error);
        glFinish();
        *ms = pel_now_ms() - start;
    }
    return ok;
}

/* The frame as it was drawn. */
static bool draw_culled(struct pel_slices3d *s, struct pel_error *error)
{
    return pel_slices3d_measure_stretches(s, s->options.cull, error) && pel_slices3d_init_z(s, s->options.cull, error) &&
           pel_slices3d_draw_slices(s, s->options.cull, s->options.slab, error);
}

static bool count_all(struct pel_slices3d *s, struct pel_error *error)
{
    return pel_slices3d_count(s, PEL_CULL_NONE, &s->counters[3], error);
}

/* Against a z-buffer that lets nothing through. */
static bool discard_all(struct pel_slices3d *s, struct pel_error *error)
{
    return pel_slices3d_count(s, PEL_CULL_ESS, &s->counters[3], error);
}

static bool draw_basic(struct pel_slices3d *s, struct pel_error *error)
{
    return pel_slices3d_draw_slices(s, PEL_CULL_NONE, 0, error);
}

static bool draw_two_passes(struct pel_slices3d *s, struct pel_error *error)
{
    static const GLfloat back = 1;
    glDepthMask(GL_TRUE);
    glClearNamedFramebufferfv(s->target.name, GL_DEPTH, 0, &back);
    return pel_slices3d_draw_slices(s, PEL_CULL_NONE, 1, error);
}

static bool measure(struct pel_slices3d *s, struct cost *c, struct pel_error *error)
{
    double simple, discarded;
    const enum pel_cull cull = s->options.cull;
    if (!time_pass(s, draw_culled, &c->culled, error) || !pel_slices3d_init_z(s, cull, error) ||
        !pel_slices3d_count(s, cull, &s->counters[3], error))
        return false;
    c->f_c2 = (double)pel_gpu_counter_value(&s->counters[3]);
    if (!pel_slices3d_count_faces(s, false, &s->counters[3], error))
        return false;
    c->f_t = (double)pel_gpu_counter_value(&s->counters[3]);
    if (!pel_slices3d_count_faces(s, true, &s->counters[3], error))
        return false;
    c->f_p = (double)pel_gpu_counter_value(&s->counters[3]);
    if (!pel_slices3d_use_box(s, false, error) || !pel_slices3d_measure_stretches(s, PEL_CULL_NONE, error) ||
        !time_pass(s, count_all, &simple, error))
        return false;
    c->f = (double)pel_gpu_counter_value(&s->counters[3]);
    const GLfloat front = 0;
    glDepthMask(GL_TRUE);
    glClearNamedFramebufferfv(s->target.name, GL_DEPTH, 0, &front);
    if (!time_pass(s, discard_all, &discarded, error) || !time_pass(s, draw_basic, &c->basic, error))
        return false;
    if (!time_pass(s, draw_two_passes, &c->two_passes, error))
        return false;
    /* A pixel that is stopped counts once in the stop's own pass. */
    c->f_c = (double)pel_gpu_counter_value(&s->counters[2]);
    double per = c->f > 0 ? 1 / c->f : 0;
    c->t_s = simple * per, c->t_z = discarded * per, c->t_c = c->basic * per;
    return true;
}

static double ratio(double a, double b)
{
    return b > 0 ? a / b : 0;
}

static void count_mille(const struct pel_frame *frame, const char *name, double value)
{
    pel_frame_count(frame, name, value > 0 ? (uint64_t)(value * 1000 + 0.5) : 0);
}

bool pel_slices3d_note_cost(struct pel_slices3d *s, const struct pel_frame *frame, struct pel_error *error)
{
    struct cost c = { .f = 0 };
    if (!measure(s, &c, error))
        return false;
    double now = pel_now_ms();
    pel_frame_stage(frame, "cost: basic", now - c.basic);
    pel_frame_stage(frame, "cost: two passes", now - c.two_passes);
    const struct {
        const char *name;
        double value;
    } counts[] = { { "F", c.f },
                   { "F_t", c.f_t },
                   { "F_p", c.f_p },
                   { "F_c'", c.f_c2 },
                   { "F_c of two passes", c.f_c },
                   { "T_s, ps", c.t_s * 1e9 },
                   { "T_z, ps", c.t_z * 1e9 },
                   { "T_c, ps", c.t_c * 1e9 } };
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        pel_frame_count(frame, counts[i].name, (uint64_t)counts[i].value);
    double gamma = ratio(c.t_s, c.t_c), alpha = ratio(c.f - c.f_c, c.f), culled = ratio(c.f - c.f_c2, c.f);
    count_mille(frame, "gamma, per mille", gamma);
    count_mille(frame, "alpha of two passes, per mille", alpha);
    count_mille(frame, "alpha of culling, per mille", culled);
    count_mille(frame, "two passes, (6), per mille", (1 - gamma) * (alpha + 1));
    count_mille(frame, "two passes, predicted (2), per mille", ratio(c.f * c.t_c, c.f * c.t_s + (c.f - c.f_c) * c.t_z + c.f_c * c.t_c));
    count_mille(frame, "two passes, predicted (5), per mille", ratio(1, alpha * gamma + 1 - alpha + gamma));
    count_mille(frame, "two passes, measured, per mille", ratio(c.basic, c.two_passes));
    count_mille(frame, "culling, predicted (9), per mille",
                ratio(c.f * c.t_c, (c.f_t + c.f_p) * c.t_s + (c.f - c.f_c2) * c.t_s + c.f_c2 * c.t_c));
    count_mille(frame, "culling, measured, per mille", ratio(c.basic, c.culled));
    return true;
}

/* SPDX-License-Identifier: MIT */
/* What the image tests share: small volumes from formulas, scenes, drawing with a technique, and checks that print what they measured.
 * Only the public interface is used: these tests see what a user sees. */
#ifndef PEL_TESTS_PICTURES_H
#define PEL_TESTS_PICTURES_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <pellucid/pellucid.h>

/* The techniques that must give these answers; NULL at the end. */
extern const char *const techniques[];

/* Fails with the number that was measured; passes silently. The text says what was measured. */
void check_at_most(double measured, double allowed, const char *format, ...) __attribute__((format(printf, 3, 4)));
void check_at_least(double measured, double wanted, const char *format, ...) __attribute__((format(printf, 3, 4)));

/* A formula of the index position. */
typedef double formula(const double index[3]);

/* A volume of `dims` samples of f(index); the volume is initialised here, and its placement is the identity. */
void make_volume(struct pel_volume *volume, size_t nx, size_t ny, size_t nz, enum pel_type type, formula *f);
/* Fills the samples anew with the formula, wherever the volume was placed since, and updates the range. */
void fill_volume(struct pel_volume *volume, formula *f);
double constant_one(const double index[3]);

/* A scene of the volume: camera fitted, transfer function a gray ramp over 0..1 with the opacity text given (NULL: value itself), unit
 * distance the mean spacing, no shading, step 0.5, no termination. */
void make_scene(struct pel_scene *scene, const struct pel_volume *volume, const char *opacity);
/* Colour the same at every value. */
void set_flat_color(struct pel_scene *scene, double r, double g, double b);

/* A parallel camera looking along `forward` at the centre of the volume from `distance` away; `scale` is half the height of the view. */
void look_parallel(struct pel_scene *scene, const double forward[3], double distance, double scale);

/* Draws with a new renderer; 0 threads: 2. The image is allocated here, with depth. */
void draw(const struct pel_scene *scene, const char *technique, int width, int height, struct pel_image *image);
void draw_with(const struct pel_scene *scene, const char *technique, int threads, int width, int height, struct pel_image *image);

/* The same with a renderer that is kept; `depth`: the image has one. */
void draw_by(struct pel_renderer *renderer, const struct pel_scene *scene, const char *technique, int width, int height, bool depth,
             struct pel_image *image);
/* Sets a technique's option from its text. */
void set_option_of(struct pel_renderer *renderer, const char *technique, const char *name, const char *value);
/* The renderer must refuse the scene, with a message that has the word. */
void expect_refusal_by(struct pel_renderer *renderer, const struct pel_scene *scene, const char *technique, const char *word);
/* A counter of the last frame. */
uint64_t frame_counter(const struct pel_renderer *renderer, const char *name);
/* Reads a file of the real data; false, loudly, where it is not there. */
bool read_real(struct pel_volume *volume, const char *name);

/* The instruction sets that this machine and this build have, the narrowest first. */
int available_isas(const char *names[3]);
/* Draws with PELLUCID_ISA set, and sees to it that the kernels are those that were asked for. */
void draw_isa(const struct pel_scene *scene, const char *isa, int width, int height, struct pel_image *image);

/* Greatest difference of any channel; NaN counts as infinite. Greatest difference of depths, infinite where one alone is infinite. */
double largest_difference(const struct pel_image *a, const struct pel_image *b);
double largest_depth_difference(const struct pel_image *a, const struct pel_image *b);
double psnr(const struct pel_image *a, const struct pel_image *b);
void check_same_bytes(const struct pel_image *a, const struct pel_image *b, const char *what);

/* The stretch [t0, t1] of a pixel's ray in the scene's volume, box and planes, worked out on its own; false where it misses. */
bool ray_stretch(const struct pel_scene *scene, int width, int height, int x, int y, double origin[3], double direction[3], double t[2]);

/* Trilinear reconstruction at a world point, worked out on its own (no voids). */
double reconstruct(const struct pel_volume *volume, const double world[3]);

/* Pixel channel 0..3. */
static inline double channel(const struct pel_image *image, int x, int y, int c)
{
    return (double)image->rgba[4 * ((size_t)y * (size_t)image->width + (size_t)x) + (size_t)c];
}

static inline double depth_at(const struct pel_image *image, int x, int y)
{
    return (double)image->depth[(size_t)y * (size_t)image->width + (size_t)x];
}

static inline double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

#endif

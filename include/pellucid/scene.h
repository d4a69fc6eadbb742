/* SPDX-License-Identifier: MIT */
/* Scene: what a picture is of. A volume, its transfer function, camera, lights, clipping, background and the optics; everything that
 * decides what the picture should be, and nothing about how (technique, device, threads) it is made. One JSON file loads and saves it
 * (pellucid/io.h), shared by the tool, the viewer and the API. */
#ifndef PELLUCID_SCENE_H
#define PELLUCID_SCENE_H

#include <pellucid/camera.h>
#include <pellucid/option.h>
#include <pellucid/transfer.h>
#include <pellucid/volume.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

enum pel_mode {
    PEL_MODE_COMPOSITE,  /* emission and absorption, front to back (equation 1.8 of the dissertation, paper 002) */
    PEL_MODE_MIP,        /* greatest sample along the ray, through the transfer function */
    PEL_MODE_MINIP,      /* least sample */
    PEL_MODE_AVERAGE,    /* mean sample */
    PEL_MODE_XRAY,       /* absorption only (equations 1.2 to 1.4): transparency exp(-integral of tau) */
    PEL_MODE_ISOSURFACE, /* surfaces of equal value, opaque or translucent, in order along the ray */
    PEL_MODE_SLICE,      /* the plane `slice` and `more_slices`, coloured by the transfer function */
};

enum pel_classification {
    PEL_CLASSIFICATION_POST,          /* interpolate values, then look up */
    PEL_CLASSIFICATION_PRE,           /* look up at the voxels, interpolate opacity and opacity-weighted colour */
    PEL_CLASSIFICATION_PREINTEGRATED, /* integrate the transfer function between successive samples */
};

enum pel_reconstruction {
    PEL_RECONSTRUCTION_AUTO,    /* nearest for labels, else linear */
    PEL_RECONSTRUCTION_LINEAR,
    PEL_RECONSTRUCTION_NEAREST,
};

/* The optics: how values become light. */
struct pel_render_settings {
    enum pel_mode mode;
    double step;        /* distance between samples along a ray, in voxels of the least spacing; > 0 */
    bool jitter;        /* move each ray's samples by a fixed pseudo-random part of the step: noise in place of rings. Deterministic */
    int refine;         /* frames of a still view that are averaged into a finer picture (pel_renderer_draw); 0: none */
    double termination; /* a ray ends once its opacity reaches this; 1: never */
    bool skip;          /* pass over what cannot be seen; never changes a byte of the picture */
    enum pel_classification classification;
    enum pel_reconstruction reconstruction;
    bool shade;         /* gradient Blinn-Phong in composite mode; isosurfaces are always shaded */
    double ambient, diffuse, specular, specular_power;
    bool invert;        /* X-ray: bright where it absorbs, as a radiograph shows it */
};

extern const struct pel_option pel_render_options[]; /* rows of struct pel_render_settings */

struct pel_isosurface {
    double value;
    double color[3];
    double opacity; /* of one crossing, 0 to 1 */
};

struct pel_light {
    bool headlight;      /* shines along each view ray; direction is ignored */
    double direction[3]; /* world, towards the light */
    double color[3];
};

/* The half space on the side that the normal points to is kept. World coordinates. */
struct pel_plane {
    double origin[3], normal[3];
};

#define PEL_MAX_CLIP_PLANES 6
#define PEL_MAX_SLICES 8
#define PEL_MAX_ISOSURFACES 16
#define PEL_MAX_LIGHTS 4

/* Where the volume came from and what is known better than its file says, so that a scene file can tell. Paths in a scene file are relative
 * to it. Drawing does not look here: after reading the volume, apply it. */
struct pel_source {
    char path[PEL_OPTION_TEXT_SIZE];
    char array[128]; /* which array of a file with several, or "" */
    char raw[128];   /* layout of a raw file (see pel_read_params), or "" */
    bool has_spacing, has_void;
    double spacing[3]; /* in place of the file's: PEL_LEAST_SPACING to PEL_MOST_SPACING */
    double void_value; /* samples with this value stand for no data; finite */
};
#define PEL_LEAST_SPACING 1e-30
#define PEL_MOST_SPACING 1e30

/* Gives a volume that was read from the source what the source knows better: spacing, void value (and with it a new range). */
void pel_source_apply(const struct pel_source *source, struct pel_volume *volume);

#define PEL_MAX_TECHNIQUE_OPTIONS 48

/* Which technique draws the scene, and options of its own as text, so that a scene file can tell. Drawing does not look here: see
 * pel_renderer_take_technique. */
struct pel_technique_choice {
    char name[32]; /* "slices2d", or "": not said */
    int option_count;
    struct {
        char name[48], value[128];
    } options[PEL_MAX_TECHNIQUE_OPTIONS];
};

struct pel_scene {
    const struct pel_volume *volume; /* borrowed; must outlive every draw. One component */
    struct pel_source source;
    struct pel_technique_choice technique;
    struct pel_transfer transfer;
    struct pel_camera camera;
    struct pel_render_settings render;
    struct pel_isosurface isosurfaces[PEL_MAX_ISOSURFACES]; /* PEL_MODE_ISOSURFACE; in any order */
    int isosurface_count;
    struct pel_plane slice;                                 /* PEL_MODE_SLICE; the side of its normal does not matter */
    struct pel_plane more_slices[PEL_MAX_SLICES - 1];       /* further ones in the same picture; the nearer hides the farther where opaque */
    int more_slice_count;
    struct pel_light lights[PEL_MAX_LIGHTS];
    int light_count;                                        /* starts as 1, a white headlight */
    struct pel_plane clip_planes[PEL_MAX_CLIP_PLANES];
    int clip_plane_count;
    bool clip_box_enabled;
    double clip_box[6];   /* world: xmin, xmax, ymin, ymax, zmin, zmax; inside is kept */
    double background[4]; /* RGBA, not premultiplied; starts as opaque black */
    bool linear_light;    /* composite in linear light instead of display values */
};

bool pel_scene_init(struct pel_scene *scene, struct pel_error *error);
void pel_scene_finish(struct pel_scene *scene);

/* Parts of a scene that are chosen from its volume where nobody says them. `transfer` is any of the three after it. */
struct pel_scene_parts {
    bool transfer, colors, opacities, unit_distance, camera, isosurfaces, slice;
};

/* Chooses the parts named from the volume, for the mode of the scene: the automatic transfer function (`transfer` alone: all of it), one
 * isosurface at the object's boundary, a slice square to the third axis through the middle, the camera that pel_scene_fit_camera places,
 * before a single slice face on. width and height are the picture's. Needs scene->volume. On failure parts may have been chosen. */
bool pel_scene_choose(struct pel_scene *scene, const struct pel_scene_parts *parts, int width, int height, struct pel_error *error);

/* Places the camera as pel_camera_fit does, but so that what the scene shows fills the view: the samples that the transfer function or the
 * isosurfaces let be seen. MinIP, average and slice show the whole box. Looks at a sparse set of samples; needs scene->volume. */
void pel_scene_fit_camera(struct pel_scene *scene, int width, int height);

/* Refuses what cannot be drawn: no volume, several components, a camera that is none, settings out of range, no isosurface in
 * PEL_MODE_ISOSURFACE, a zero normal. */
bool pel_scene_check(const struct pel_scene *scene, struct pel_error *error);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif

/* SPDX-License-Identifier: MIT */
/* The options that say what a picture is of, shared by `render` and `bench`, and how a scene is made from them and a file. */
#ifndef TOOL_SCENE_ARGUMENTS_H
#define TOOL_SCENE_ARGUMENTS_H

#include "arguments.h"
#include "progress.h"

/* The groups of the shared options; a command's own group comes after them. */
enum {
    GROUP_INPUT,
    GROUP_TRANSFER,
    GROUP_SURFACES,
    GROUP_OPTICS,
    GROUP_LIGHT,
    GROUP_CAMERA,
    GROUP_MOVES,
    GROUP_ENGINE,
    GROUP_OWN, /* the command's; then those of the techniques */
};

/* What the flags set. Fields of the library's own structs come in `render` and `camera`. */
struct scene_arguments {
    char scene[PEL_OPTION_TEXT_SIZE], array[PEL_OPTION_TEXT_SIZE], raw[PEL_OPTION_TEXT_SIZE];
    double spacing[3], void_value;
    bool labels;

    char colormap[PEL_OPTION_TEXT_SIZE], opacity[PEL_OPTION_TEXT_SIZE];
    double range[2], unit_distance;

    char isovalue[PEL_OPTION_TEXT_SIZE], iso_color[PEL_OPTION_TEXT_SIZE], iso_opacity[PEL_OPTION_TEXT_SIZE]; /* the last given */
    struct {
        double items[PEL_MAX_ISOSURFACES];
        int count;
    } isovalues, iso_opacities;
    double iso_colors[PEL_MAX_ISOSURFACES][4];
    int iso_color_count;

    double slice[6], clip_plane[6], clip_box[6];
    double slices[PEL_MAX_SLICES][6];
    int slice_count;
    double clip_planes[PEL_MAX_CLIP_PLANES][6];
    int clip_plane_count;

    struct pel_render_settings render;

    double light[3], lights[PEL_MAX_LIGHTS][3];
    int light_count;
    double light_color[4], light_colors[PEL_MAX_LIGHTS][4];
    int light_color_count;
    double background[4];
    bool linear_light;

    struct pel_camera camera;
    double azimuth, elevation, roll, zoom;

    int size[2];
    char technique[PEL_OPTION_TEXT_SIZE];
    char device[PEL_OPTION_TEXT_SIZE]; /* "auto", "cpu", "gpu", "gpu:1" */
    double gpu_memory; /* MB */
    int threads;
    bool quiet;

    max_align_t techniques[MAX_GROUPS - GROUP_OWN][32]; /* the objects of their options, in the order of the groups */
};

extern const struct pel_option input_rows[], transfer_rows[], surface_rows[], light_rows[], move_rows[], engine_rows[];
extern const struct option_extra input_extras[], transfer_extras[], surface_extras[], light_extras[], move_extras[], engine_extras[];

/* The rows of struct option_group for them, to begin a command's list with. */
#define SCENE_OPTION_GROUPS                                                                                                                \
    { "Input", input_rows, input_extras }, { "Transfer function", transfer_rows, transfer_extras },                                        \
        { "Surfaces, slice and clipping", surface_rows, surface_extras }, { "Optics", pel_render_options, NULL },                          \
        { "Light", light_rows, light_extras }, { "Camera", pel_camera_options, NULL },                                                     \
        { "Moves of the camera, in this order", move_rows, move_extras },                                                                  \
    {                                                                                                                                      \
        "Engine", engine_rows, engine_extras                                                                                               \
    }

/* Points the groups at the struct, which must be zeroed and outlive the arguments. */
void scene_arguments_attach(struct arguments *arguments, struct scene_arguments *values);

/* Appends the numbers of a text with commas to the up to PEL_MAX_ISOSURFACES items that there are. */
bool append_numbers(double *items, int *count, double least, double most, const char *flag, const char *text, struct pel_error *error);

/* The same for --isovalue, each of which must be another. */
bool append_isovalues(double *items, int *count, const char *text, struct pel_error *error);

/* A scene, its volume, and what is known of the file. */
struct loaded_scene {
    struct pel_scene scene;
    struct pel_volume volume;
    struct pel_file_info info;
    struct pel_camera base_camera; /* before the moves */
    const char *technique;
    struct pel_device *device; /* to draw on, or NULL: the CPU */
    char device_note[256];     /* why --device auto took the CPU, or "" */
    double load_ms; /* reading the file */
};

/* Checks the arguments, reads the scene file and the volume (`path`: NULL where the scene file names it), and sets the scene up. On failure
 * there is nothing to finish. */
bool scene_load(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values, const char *path,
                struct progress *progress, struct pel_error *error);
void scene_unload(struct loaded_scene *loaded);

/* What a scene chose for this technique, and the flags over it, as the scene's choice; what it chose for another is dropped. */
bool scene_merge_technique(const struct pel_technique_info *technique, const struct arguments *arguments,
                           struct pel_technique_choice *choice, struct pel_error *error);

/* Notes the options that were given and change nothing: those of other techniques, and those of isosurfaces in another mode. */
void scene_tell_idle(const struct arguments *arguments, const struct scene_arguments *values, const struct pel_technique_info *technique,
                     enum pel_mode mode);

/* Sets the scene's camera: the base camera with the moves of the flags, after a further turn by `azimuth` degrees. */
void scene_move_camera(struct loaded_scene *loaded, const struct scene_arguments *values, double azimuth);

/* Reads a volume and tells its notes; a vector field is replaced by its magnitude if asked for. */
bool volume_load(const char *path, const char *array, const char *raw, bool scalar, struct progress *progress, bool quiet,
                 struct pel_volume *volume, struct pel_file_info *info, struct pel_error *error);

/* Whether every sample is void. */
bool volume_is_void(const struct pel_volume *volume);

/* Makes the scene's parts; used by scene_load. */
bool scene_check_device(const struct loaded_scene *loaded, const struct scene_arguments *values, struct pel_error *error);
bool scene_open_device(struct loaded_scene *loaded, const struct scene_arguments *values, struct pel_error *error);
/* Takes the device out of the scene, for the caller to destroy, where it was chosen automatically and the CPU can draw instead; notes why. */
bool scene_leave_device(struct loaded_scene *loaded, const struct scene_arguments *values, const char *why);
bool scene_set_transfer(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values,
                        const struct pel_scene_parts *has, struct pel_error *error);
bool scene_set_surfaces(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values,
                        const struct pel_scene_parts *has, struct pel_error *error);
bool scene_set_camera(struct loaded_scene *loaded, const struct arguments *arguments, const struct scene_arguments *values,
                      const struct pel_scene_parts *has, struct pel_error *error);

#endif

/* SPDX-License-Identifier: MIT */
/* Files: volumes, fields, images, transfer functions and scenes, in and out; meshes out.
 *
 * A format is found by content first (gzip is looked through), then by name. Sizes that a file claims are held against its length before
 * anything is allocated. Writers write beside the target and rename at the end: a failure or an interruption leaves no half file. */
#ifndef PELLUCID_IO_H
#define PELLUCID_IO_H

#include <pellucid/image.h>
#include <pellucid/mesh.h>
#include <pellucid/scene.h>
#include <pellucid/transfer.h>
#include <pellucid/volume.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

struct pel_read_params {
    const char *array; /* name of the array to read from a file that has several; NULL: its active or first scalar array, else its first */
    const char *raw;   /* "256x256x256:u8", "64x64x64:f32:be", "3x41x35x15:f32:le+1024" (4 numbers: components first; :le is the default;
                          +skip: bytes before the data): read the file as raw samples. NULL: find the format */
    struct pel_progress progress;

    /* A header may name data files anywhere (NRRD, MetaImage). Where it comes from somebody who should not see every file that this process
     * can read, say which may be opened: asked with the path of each, before it is opened; false refuses it. NULL: all. */
    bool (*may_open)(void *user, const char *path);
    void *may_open_user;
};
#define PEL_READ_PARAMS_INIT { NULL, NULL, { NULL, NULL }, NULL, NULL }

#define PEL_MAX_ARRAYS 64
#define PEL_MAX_NOTES 8

/* What a file is, beside the volume. */
struct pel_file_info {
    char format[32]; /* "nrrd", "nifti", "tiff", "dicom", "vtk", "vti", "metaimage", "raw" */
    int array_count;
    struct {
        char name[128];
        enum pel_type type;
        int components;
    } arrays[PEL_MAX_ARRAYS];
    int note_count;
    char notes[PEL_MAX_NOTES][256]; /* things a user should know: "spacing of axis 0 is nan; taken as 1" */
};

/* Reads a volume or field from a file, or from a folder (DICOM series, TIFF stack), into an initialised, empty volume, with range and
 * labels set. `info` is nullable. On failure the volume stays empty. */
bool pel_read_volume(const char *path, const struct pel_read_params *params, struct pel_volume *volume, struct pel_file_info *info,
                     struct pel_error *error);

struct pel_write_params {
    bool compress; /* gzip or zlib inside the format, where it can */
    struct pel_progress progress;
};
#define PEL_WRITE_PARAMS_INIT { false, { NULL, NULL } }

/* Writes by the name's ending: .nrrd .nhdr (data in a .raw beside it) .vti .mha .mhd (likewise) .raw. */
bool pel_write_volume(const char *path, const struct pel_volume *volume, const struct pel_write_params *params, struct pel_error *error);

/* The formats, for lists in help and docs; NULL-terminated through pel_format_at. */
struct pel_format_info {
    const char *name, *summary;
    const char *endings; /* ".nrrd .nhdr" */
    bool reads, writes;
};
const struct pel_format_info *pel_format_at(size_t index);

struct pel_image_write_params {
    bool keep_alpha;       /* PNG: keep alpha (unassociated) instead of blending over the background */
    double background[4];  /* what a PNG without alpha is blended over; not premultiplied */
    int compression;       /* PNG: zlib level 0 to 9 */
};
#define PEL_IMAGE_WRITE_PARAMS_INIT { false, { 0, 0, 0, 1 }, 3 }

/* .png: 8-bit sRGB. .nrrd: float32, axes (RGBA, x, y), premultiplied as held in memory. "-": PNG on standard output. */
bool pel_write_image(const char *path, const struct pel_image *image, const struct pel_image_write_params *params, struct pel_error *error);
/* The depth as a float32 .nrrd (axes x, y), +inf where nothing was met. Fails where the image has none. */
bool pel_write_depth(const char *path, const struct pel_image *image, struct pel_error *error);
/* PNG (8 or 16 bits, gray to RGBA) or float NRRD (1, 3 or 4 values a pixel), into an initialised image. */
bool pel_read_image(const char *path, struct pel_image *image, struct pel_error *error);

/* Writes by the name's ending, in world coordinates, with normals: .ply .stl (both binary) .obj (text) .vtp (binary). Of several surfaces
 * PLY and VTP tell each vertex' isovalue, OBJ has a group each; STL has the triangles alone. Far from the world's zero, where floats are
 * coarse, PLY and VTP have doubles and OBJ more digits; STL cannot. `progress` is nullable. */
bool pel_write_mesh(const char *path, const struct pel_mesh *mesh, const struct pel_progress *progress, struct pel_error *error);

/* Whether the name's ending is one that pel_write_mesh knows; PEL_ERROR_ARGUMENT, with those it knows, where not. Touches no file. */
bool pel_check_mesh_path(const char *path, struct pel_error *error);

/* ParaView colour maps: .json (a list of presets; the first is taken unless `name` says which) and .xml. Values stretch over
 * [lo, hi] where the file's are 0..1 normalised; the opacity curve is taken too if the file has one. */
bool pel_read_transfer(const char *path, const char *name, double lo, double hi, struct pel_transfer *transfer, struct pel_error *error);
bool pel_write_transfer(const char *path, const struct pel_transfer *transfer, struct pel_error *error); /* ParaView .json */
/* The same from and to text in memory. `text` has a 0 behind its `size` bytes; what to_text gives is to be freed, NULL on failure. */
bool pel_transfer_from_text(const char *text, size_t size, const char *name, double lo, double hi, struct pel_transfer *transfer,
                            struct pel_error *error);
char *pel_transfer_to_text(const struct pel_transfer *transfer, struct pel_error *error);

/* Scene file (JSON). Reading fills everything but scene->volume: the caller reads scene->source and sets it. Keys that are not known are
 * refused by name. What the file does not say keeps the value it had; `has` (nullable) tells which of the parts that are
 * otherwise chosen from the volume were said. */
bool pel_read_scene(const char *path, struct pel_scene *scene, struct pel_scene_parts *has, struct pel_error *error);
bool pel_write_scene(const char *path, const struct pel_scene *scene, struct pel_error *error);

/* The same from and to text in memory. Paths in it are relative to the file `path`, which need not exist; NULL: they are as the process
 * sees them. Where the text is refused the scene stays as it was; messages begin with the key, "camera.parallel-scale: ". What to_text gives
 * is to be freed, and reads back to the last bit; NULL where a number is not finite or a path is not UTF-8. */
bool pel_scene_from_text(const char *text, size_t size, const char *path, struct pel_scene *scene, struct pel_scene_parts *has,
                         struct pel_error *error);
char *pel_scene_to_text(const struct pel_scene *scene, const char *path, struct pel_error *error);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif

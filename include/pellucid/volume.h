/* SPDX-License-Identifier: MIT */
/* Volume: samples on a regular grid, placed in the world.
 *
 * Samples sit at voxel centres. Index (0,0,0) is the centre of the first voxel and lies at `origin`; the box of a volume
 * runs from the first centre to the last, (dims-1)*spacing along each axis. An axis with a single sample is given the
 * thickness of one spacing, half to each side, so that a lone image can be seen.
 *
 * Memory order: component fastest, then x (axis 0), y, z. Samples are kept in the file's own type.
 * Thread safety: a volume may be read from several threads; changing it needs the caller's own lock. */
#ifndef PELLUCID_VOLUME_H
#define PELLUCID_VOLUME_H

#include <stdbool.h>
#include <stddef.h>

#include <pellucid/error.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Type of one stored number. */
enum pel_type { PEL_U8, PEL_I8, PEL_U16, PEL_I16, PEL_U32, PEL_I32, PEL_F32, PEL_F64, PEL_TYPE_COUNT };

/* What the world axes mean in a patient. RAS: +x right, +y anterior, +z superior (NIfTI). LPS: +x left, +y posterior,
 * +z superior (DICOM, ITK, MetaImage). UNKNOWN: nothing is known (engineering data). */
enum pel_space { PEL_SPACE_UNKNOWN, PEL_SPACE_RAS, PEL_SPACE_LPS };

struct pel_volume {
    size_t dims[3];    /* samples along x, y, z; each >= 1 */
    enum pel_type type;
    int components;    /* numbers a sample, 1 to 4; 3 is a vector field or RGB, 4 is RGBA */
    void *data;        /* owned, from malloc; dims[0]*dims[1]*dims[2]*components numbers */

    double origin[3];       /* world position of the first sample's centre */
    double direction[3][3]; /* direction[a]: unit world vector along which index axis a grows; need not be orthogonal */
    double spacing[3];      /* world distance between samples along each index axis; > 0 */
    enum pel_space space;
    char units[16];         /* unit of world lengths ("mm"), or "" */

    bool has_void;     /* samples equal to void_value stand for "no data" */
    double void_value; /* NaN samples are void always, whether or not this is set */
    bool labels;       /* few integer values that name things: never interpolated. Set by pel_volume_detect_labels or a reader */

    double range[2]; /* least and greatest finite non-void value (of the magnitude where components > 1; 0, 0 where all are void); see
                        pel_volume_update_range */
    char name[128];  /* what the file calls the data, or "" */
};

/* Makes an empty volume: 0 samples, identity placement, spacing 1. Needs no finish until data is attached. */
void pel_volume_init(struct pel_volume *volume);

/* Gives an initialised volume dims, type and zeroed samples. Placement is left as it is. Fails with PEL_ERROR_ARGUMENT on a zero
 * dimension or a bad component count, PEL_ERROR_MEMORY where the size overflows or cannot be had. */
bool pel_volume_allocate(struct pel_volume *volume, const size_t dims[3], enum pel_type type, int components, struct pel_error *error);

/* Frees the samples and makes the volume empty again. Accepts one that was only initialised. */
void pel_volume_finish(struct pel_volume *volume);

/* Samples: dims[0]*dims[1]*dims[2]. Bytes: samples * components * size of the type. */
size_t pel_volume_samples(const struct pel_volume *volume);
size_t pel_volume_bytes(const struct pel_volume *volume);

/* Bytes of one number (1, 2, 4 or 8); name ("u8", "f32", ...); type of a name, PEL_TYPE_COUNT where there is none
 * (C and VTK and NRRD names such as "uint8", "unsigned char", "float", "short" are known too). */
size_t pel_type_size(enum pel_type type);
const char *pel_type_name(enum pel_type type);
enum pel_type pel_type_from_name(const char *name);

/* "RAS", "LPS" or "unknown". */
const char *pel_space_name(enum pel_space space);

/* One number, as double. Indices must be in range. For loops over many samples the library has faster ways. */
double pel_volume_get(const struct pel_volume *volume, size_t x, size_t y, size_t z, int component);

/* True where a number is NaN or the void value. A sample of several components is void where one of them is. */
bool pel_volume_is_void(const struct pel_volume *volume, double value);

/* Index space (voxels, fractions allowed) to world and back. The inverse fails never: a volume that a reader gave, or that
 * pel_volume_check accepts, has an invertible direction matrix. */
void pel_volume_index_to_world(const struct pel_volume *volume, const double index[3], double world[3]);
void pel_volume_world_to_index(const struct pel_volume *volume, const double world[3], double index[3]);

/* The 3x4 affine matrix: world = matrix * (i, j, k, 1). */
void pel_volume_matrix(const struct pel_volume *volume, double matrix[3][4]);

/* World bounds of the box: xmin, xmax, ymin, ymax, zmin, zmax. */
void pel_volume_bounds(const struct pel_volume *volume, double bounds[6]);

/* Mean of the three spacings: the default unit distance of opacities. Least of the three: the voxel of the step length. */
double pel_volume_mean_spacing(const struct pel_volume *volume);
double pel_volume_least_spacing(const struct pel_volume *volume);

/* Checks placement and shape: finite origin, spacing > 0, unit directions with a determinant away from 0, dims and components
 * in range, data present. Readers call it last, so that no later code need doubt a volume. */
bool pel_volume_check(const struct pel_volume *volume, struct pel_error *error);

/* Turns the world by 180 degrees about z where needed, so that the volume's world axes mean `space`: LPS <-> RAS negates x and y of
 * origin and directions; samples stay where they are in memory. From UNKNOWN it only sets the word. */
void pel_volume_to_space(struct pel_volume *volume, enum pel_space space);

/* Recomputes `range` from the samples. Readers and generators call it. */
void pel_volume_update_range(struct pel_volume *volume);

/* Decides whether the samples are labels: an integer type, one component, at most 64 distinct values, and neighbouring values that do
 * not lead into one another as a reconstructed signal's would (most boundaries jump across values that exist). Sets `labels`, returns it.
 */
bool pel_volume_detect_labels(struct pel_volume *volume);

/* A new one-component f32 volume with the length of each vector of `field`, same placement. Sample is void where any component is. */
bool pel_volume_magnitude(const struct pel_volume *field, struct pel_volume *magnitude, struct pel_error *error);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif

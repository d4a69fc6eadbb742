/* SPDX-License-Identifier: MIT */
/* What the ray-casting kernels are given. The driver (raycast.c) fills one job a frame; the kernels (kernel.c, compiled once for each
 * instruction set and kind of voxel) draw tiles of it. Nothing in a job changes while tiles are drawn. */
#ifndef PEL_CPU_KERNEL_H
#define PEL_CPU_KERNEL_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <pellucid/scene.h>

#include "minmax.h"

/* Kinds of voxel that have a kernel each. Fetched ("raw") values are affine in the data's: value = raw * value_scale + value_offset.
 *   U8   u8 and i8 (by flipping the sign bit); raw is 2^14 times the unsigned byte: the lerp along x is one multiply-add of 16-bit pairs
 *   U16  i16 and u16 (likewise); raw is 2^14 times the signed word
 *   F32  raw is the value
 *   WIDE u32, i32, f64; raw is 0..1 over the volume's range, subtracted in double so that nothing is lost to float */
enum pel_kernel_kind { PEL_KERNEL_U8, PEL_KERNEL_U16, PEL_KERNEL_F32, PEL_KERNEL_WIDE, PEL_KERNEL_KINDS };

#define PEL_SPAN_SHIFT 2 /* pixels a block of the span masks, as a power of two */
#define PEL_SPAN_WORDS 4 /* of 64 slabs of depth each, a block */
#define PEL_SPAN_SLABS (64 * PEL_SPAN_WORDS)

struct pel_job {
    /* The picture. */
    int width, height;
    float *rgba, *depth; /* depth may be NULL */

    /* Rays in index space. The point P and the direction D of pixel (x, y) are linear in x and y; the ray is P + s D, and the world
     * distance along it is (s + s_base) * |Dw|, Dw being D in the world. P lies near the volume, so that float loses nothing. */
    double p0[3], px[3], py[3], d0[3], dx[3], dy[3];
    double w0[3], wx[3], wy[3]; /* Dw */
    double s_base, s_least;     /* s >= s_least: in front of a perspective camera */
    double along;               /* a component of D smaller than this counts as 0 */
    double box_lo[3], box_hi[3];
    int plane_count;
    double planes[PEL_MAX_CLIP_PLANES + 6][4]; /* a x + b y + c z + d >= 0 is kept; index space */
    double step;                               /* world length */
    int jitter;                                /* 0: none, else 1 + the frame's number (jitter.h) */

    /* Voxels. */
    const void *data;
    enum pel_type type;
    int32_t dims[3], last_cell[3];   /* last_cell: greatest corner of a trilinear cell, dims - 2, at least 0 */
    int32_t row, slice;              /* voxels from one row and slice to the next */
    int32_t flip;                    /* exclusive or of a 32-bit fetch: the sign bits */
    double wide_offset, wide_scale;  /* WIDE: raw = (v - offset) * scale */
    bool voids;                      /* some voxel is void */
    bool has_void_value;             /* some of them by value: compare raw voxels with void_raw (not WIDE) */
    bool wide_void;                  /* WIDE: compare the stored number with void_value */
    float gradient_scale;            /* 1 / the volume's range, raw */
    float void_raw;                  /* fetched value of the void value, before interpolation */
    double void_value;

    /* Classification: entry = raw * table_scale + table_offset, cut off to a whole number (half an entry is in the offset). */
    int32_t table_last;
    float table_scale, table_offset;
    float table_slack;               /* entries by which rounding may move a look-up, and more */
    const uint32_t *next_visible;    /* the first entry from here on that is not clear */
    const float *opacity;            /* per unit distance */
    const float *red, *green, *blue; /* not multiplied by opacity */
    const float *alpha;              /* opacity of one step */
    const float *alpha_red, *alpha_green, *alpha_blue; /* colour times it */
    const float *tau;                /* extinction over one step; X-ray and pre-integration */
    const float *sum_tau, *sum_red, *sum_green, *sum_blue; /* pre-integration: integrals of tau and tau x colour over entries */
    float step_over_unit;

    /* Skipping. */
    bool skip;
    int32_t cell_dims[3];
    int cell_row_shift,
        cell_slice_shift; /* of marks and distance: rows and slices start at multiples of powers of two, so that no lane multiplies */
    const uint8_t *marks;             /* a byte a cell: 0 where it may be seen */
    const uint8_t *distance; /* for each octant of directions a map of distances in cells (distance_map.h) to the nearest cell that may be
                                seen; 0: this one may */
    int32_t map_bytes;                /* from one octant's map to the next */
    const float *cell_bound,
        *block_bound; /* MIP: most, MinIP: least, of cells and blocks; raw. Kept even where skip is off: samples are held to it */
    int32_t block_dims[3];
    const uint64_t *spans;            /* nullable: a mask of depth slabs a block of pixels (spans.h) */
    bool looks;                       /* the masks do not tell all: look at the distance map, too */
    int span_columns;
    double span_lo, span_scale;       /* slab of s: (s - lo) * scale */

    /* Optics. */
    enum pel_mode mode;
    enum pel_classification classification;
    bool nearest, shade, invert, headlight_only, orthogonal;
    float termination;
    float ambient, diffuse, specular, power;
    float all_diffuse[3], all_specular[3]; /* the coefficient times the lights' colours, summed */
    float steps_a_voxel;   /* least spacing / step */
    float to_world[3][3];  /* index vector to world, in least spacings */
    float normal[3][3];    /* index gradient to world: inverse transpose, likewise */
    float metric[6];       /* |world gradient|^2 = m0 gx^2 + m1 gy^2 + m2 gz^2 + m3 gx gy + m4 gx gz + m5 gy gz */
    int light_count;
    struct { bool headlight; float direction[3], color[3]; } lights[PEL_MAX_LIGHTS];
    float least_raw, most_raw; /* of the whole volume */

    /* Isosurfaces, by rising value, raw. */
    enum pel_roots roots;
    int iso_count;
    float iso_margin; /* raw: what rounding may move a reconstructed value by */
    float iso[PEL_MAX_ISOSURFACES], iso_color[PEL_MAX_ISOSURFACES][3], iso_opacity[PEL_MAX_ISOSURFACES];
    int slice_count;
    double slice_planes[PEL_MAX_SLICES][4]; /* index space */
};

struct pel_counts {
    uint64_t in_box;  /* samples that the stretches of the rays that were set up hold */
    uint64_t taken;
    uint64_t culled; /* rays that were never set up, since their block of pixels holds nothing */
};

typedef void (*pel_kernel)(const struct pel_job *job, int x0, int y0, int x1, int y1, struct pel_counts *counts);

/* How cubes of voxels are projected onto the span masks. Camera space is right, up, forward. */
struct pel_projection {
    _Atomic uint64_t *masks;
    int blocks[2];              /* columns and rows of the masks */
    bool parallel;
    float origin[3], axis[3][3]; /* camera space of the middle of the first cube, and of a voxel along each index axis */
    float reach[3];             /* half the extent of a cube in camera space, and more than rounding can move it */
    float focal[2], middle[2];  /* pixels a unit of tangent (parallel: of length), and the picture's middle */
    float slab_start, slabs;    /* slab of a depth: (depth - start) * slabs */
};

/* Marks slabs from first to last in the blocks from (x0, y0) to (x1, y1), all inclusive. */
static inline void pel_mark_span(const struct pel_projection *p, int x0, int x1, int y0, int y1, int first, int last)
{
    for (int word = first >> 6; word <= last >> 6; word++) {
        int from = word == first >> 6 ? first & 63 : 0, to = word == last >> 6 ? last & 63 : 63;
        uint64_t bits = (~(uint64_t)0 >> (63 - (to - from))) << from;
        for (int y = y0; y <= y1; y++)
            for (int x = x0; x <= x1; x++) {
                _Atomic uint64_t *mask = p->masks + ((size_t)y * (size_t)p->blocks[0] + (size_t)x) * PEL_SPAN_WORDS + word;
                if ((atomic_load_explicit(mask, memory_order_relaxed) & bits) != bits)
                    atomic_fetch_or_explicit(mask, bits, memory_order_relaxed);
            }
    }
}

/* Projects the voxel cells of the cell at voxel (x, y, z) that an isosurface may pass through. Not for volumes with voids. */
typedef void (*pel_project_surface)(const struct pel_job *job, const struct pel_projection *p, int x, int y, int z);

/* Scanlines from v0 up to v1 of shear-warp's intermediate image (shear.h). */
struct pel_shear;
struct pel_scanline;
typedef void (*pel_shear_kernel)(const struct pel_job *job, const struct pel_shear *shear, int v0, int v1, struct pel_scanline *line,
                                 struct pel_counts *counts);

/* Which patches may be seen in a slab of cells along z, as bits in rows of `row` bytes (shear_runs.h). Not for WIDE. */
typedef void (*pel_patch_kernel)(const struct pel_job *job, const int axis[3], int slab, uint8_t *seen, ptrdiff_t row);

/* Turns the cells of a slab along z that are wanted (turned.h): a byte a cell, rows along x. Not for WIDE. */
struct pel_turned;
typedef void (*pel_turn_kernel)(const struct pel_job *job, int slab, const uint8_t *wanted, const struct pel_turned *turned);

/* Row y of the picture from the intermediate image (warp.h). */
struct pel_warp;
typedef void (*pel_warp_kernel)(const struct pel_job *job, const struct pel_shear *shear, const struct pel_warp *warp, int y);

/* One instruction set's kernels, by kind. */
struct pel_kernels {
    pel_project_surface project_surface;
    pel_kernel composite, composite_shaded, composite_general, preintegrated, projection, isosurface, isosurface_steps, slice;
    pel_shear_kernel shear, shear_shaded;
    pel_patch_kernel patches;
    pel_turn_kernel turn;
    pel_warp_kernel warp;
};

/* Name of the set in use ("x86-64-v3"), and its kernels. `wanted` (nullable) forces one; false and an error where the machine lacks it or
 * there is none of that name. */
bool pel_kernels_find(const char *wanted, const struct pel_kernels *kernels[PEL_KERNEL_KINDS], const char **name, struct pel_error *error);

#endif

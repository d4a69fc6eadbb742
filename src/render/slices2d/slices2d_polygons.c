/* SPDX-License-Identifier: MIT */
#include "slices2d_polygons.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "slices2d_schedule.h"
#include "vec.h"

/* Index axes of stack space (slices2d_space.glsl). */
static const int axes[3][3] = { { 1, 2, 0 }, { 0, 2, 1 }, { 0, 1, 2 } };

int pel_slices2d_parts(const struct pel_job *job, bool perspective, double blend, struct pel_slices2d_part parts[PEL_SHEAR_PARTS])
{
    int which[PEL_SHEAR_PARTS];
    double weights[PEL_SHEAR_PARTS];
    bool split;
    int count = pel_shear_parts_blended(job, perspective, blend, which, weights, &split);
    for (int i = 0; i < count; i++)
        parts[i] = (struct pel_slices2d_part) { which[i] / 2, which[i] % 2 ? -1 : 1, split, weights[i] };
    return count;
}

static void where_eye_is(const struct pel_job *job, double eye[3])
{
    for (int a = 0; a < 3; a++)
        eye[a] = job->p0[a] + job->s_least * job->d0[a];
}

/* Rows of the matrix from stack space to pixels. Every ray of a perspective camera goes through the eye: q - eye is w (d0 + x dx + y dy);
 * in parallel q - p0 is x px + y py and a multiple of d0. */
static void picture_matrix(const struct pel_job *job, bool perspective, const int axis[3], float rows[3][4])
{
    double columns[3][3], inverse[3][3], from[3];
    where_eye_is(job, from);
    for (int i = 0; i < 3; i++) {
        columns[i][0] = perspective ? job->dx[i] : job->px[i];
        columns[i][1] = perspective ? job->dy[i] : job->py[i];
        columns[i][2] = job->d0[i];
        if (!perspective)
            from[i] = job->p0[i];
    }
    pel_invert3((const double(*)[3])columns, inverse);
    for (int r = 0; r < 3; r++) {
        bool one = !perspective && r == 2;
        for (int a = 0; a < 3; a++)
            rows[r][a] = one ? 0 : (float)inverse[r][axis[a]];
        rows[r][3] = one ? 1 : (float)-pel_dot(inverse[r], from);
    }
}

static double first_slice_at(const struct pel_job *job, const struct pel_slices2d_part *part)
{
    return part->sign > 0 ? 0 : job->dims[part->axis] - 1;
}

/* Slices of voxels from slice to slice; there is nothing between a single one and the next. */
static double spacing_of(const struct pel_job *job, const struct pel_slices2d_part *part, const struct pel_slices2d_layout *layout)
{
    return job->dims[part->axis] > 1 ? (double)layout->every / layout->supersampling : 1;
}

static int slices_of(const struct pel_job *job, const struct pel_slices2d_part *part, const struct pel_slices2d_layout *layout)
{
    const struct pel_slices2d_quality quality = { layout->supersampling, layout->every, layout->each };
    return pel_slices2d_scheduled(&quality, job->dims[part->axis]);
}

/* Number of the first slice: a single slice of voxels has a stretch before it, too. */
static int base_of(const struct pel_job *job, const struct pel_slices2d_part *part, const struct pel_slices2d_layout *layout)
{
    return layout->surfaces && job->dims[part->axis] == 1 ? -1 : 0;
}

int pel_slices2d_lay(const struct pel_job *job, bool perspective, const struct pel_slices2d_part *part,
                     const struct pel_slices2d_layout *layout, struct pel_slices2d_block *block)
{
    const int c = part->axis, *axis = axes[c], count = slices_of(job, part, layout), base = base_of(job, part, layout);
    const double step = part->sign * spacing_of(job, part, layout), first = first_slice_at(job, part);
    double eye[3], pixel = 0;
    where_eye_is(job, eye);
    for (int a = 0; a < 3; a++)
        pixel = fmax(pixel, fabs(job->px[a]) + fabs(job->py[a]));
    *block = (struct pel_slices2d_block) {
        .stack = { (float)first, (float)step, perspective ? (float)((eye[c] - first) / step) : -1e9f, (float)count },
        .polygons = { layout->each, base, part->split, part->sign < 0 },
        .rules = { (float)(0.5 + 4 * pixel), perspective, layout->surfaces ? 0 : 0.5f, layout->surfaces ? 1 : 0.5f },
    };
    for (int a = 0; a < 3; a++)
        block->eye[a] = (float)(perspective ? eye[axis[a]] : job->d0[axis[a]] / job->d0[c] * step);
    picture_matrix(job, perspective, axis, block->to_picture);
    int stretches = layout->surfaces ? count - 1 - 2 * base : count;
    return (stretches + layout->each - 1) / layout->each;
}

/* What of a layer of cells may be seen: cells from and to along u and v. */
struct extent {
    int from[2], to[2];
};

static void widen(struct extent *e, int u, int v)
{
    const int at[2] = { u, v };
    for (int i = 0; i < 2; i++) {
        e->from[i] = at[i] < e->from[i] ? at[i] : e->from[i];
        e->to[i] = at[i] + 1 > e->to[i] ? at[i] + 1 : e->to[i];
    }
}

static void layer_extents(const struct pel_job *job, const int axis[3], bool all, struct extent *extents)
{
    const int *cells = job->cell_dims;
    int at[3];
    for (int i = 0; i < cells[axis[2]]; i++)
        extents[i] =
            all ? (struct extent) { { 0, 0 }, { cells[axis[0]], cells[axis[1]] } } : (struct extent) { { INT32_MAX, INT32_MAX }, { 0, 0 } };
    for (at[2] = 0; !all && at[2] < cells[2]; at[2]++)
        for (at[1] = 0; at[1] < cells[1]; at[1]++) {
            const uint8_t *row = job->marks + ((size_t)at[2] << job->cell_slice_shift) + ((size_t)at[1] << job->cell_row_shift);
            for (at[0] = 0; at[0] < cells[0]; at[0]++)
                if (!row[at[0]])
                    widen(&extents[at[axis[2]]], at[axis[0]], at[axis[1]]);
        }
}

/* The layers of cells that a polygon's slices read. */
static void layers_of(const struct pel_job *job, const struct pel_slices2d_part *part, const struct pel_slices2d_layout *layout,
                      int polygon, int layers[2])
{
    const int last = job->cell_dims[part->axis] - 1;
    double m = base_of(job, part, layout) + polygon * layout->each, end = m + layout->each - (layout->surfaces ? 0 : 1), k[2];
    k[0] = first_slice_at(job, part) + part->sign * m * spacing_of(job, part, layout);
    k[1] = first_slice_at(job, part) + part->sign * end * spacing_of(job, part, layout);
    for (int i = 0; i < 2; i++) {
        int cell = (int)floor((i ? fmax(k[0], k[1]) + 1e-6 : fmin(k[0], k[1]) - 1e-6) / PEL_CELL_SIZE);
        layers[i] = cell < 0 ? 0 : cell > last ? last : cell;
    }
}

int pel_slices2d_seen(const struct pel_job *job, const struct pel_slices2d_part *part, const struct pel_slices2d_layout *layout,
                      int polygons, bool all, uint32_t (*seen)[2], struct pel_error *error)
{
    const int *axis = axes[part->axis];
    struct extent *extents = pel_alloc((size_t)job->cell_dims[axis[2]], sizeof *extents, "layers of cells", error);
    if (!extents)
        return -1;
    layer_extents(job, axis, all, extents);
    int count = 0;
    for (int p = 0; p < polygons; p++) {
        int layers[2];
        struct extent e = { { INT32_MAX, INT32_MAX }, { 0, 0 } };
        layers_of(job, part, layout, p, layers);
        for (int l = layers[0]; l <= layers[1]; l++)
            if (extents[l].to[0] > 0) {
                widen(&e, extents[l].from[0], extents[l].from[1]);
                widen(&e, extents[l].to[0] - 1, extents[l].to[1] - 1);
            }
        seen[p][0] = seen[p][1] = 0;
        for (int i = 0; i < 2 && e.to[0] > 0; i++) {
            int to = e.to[i] * PEL_CELL_SIZE,
                last = job->dims[axis[i]]; /* a single voxel reaches half a voxel to both sides: the polygon's margin */
            seen[p][i] = (uint32_t)(e.from[i] * PEL_CELL_SIZE) | (uint32_t)(to < last ? to : last) << 16;
        }
        count += e.to[0] > 0;
    }
    free(extents);
    return count;
}

/* SPDX-License-Identifier: MIT */
/* Built slab by slab: the voxel slices that a slab of leaves touches become bins, are folded along z, then along y, then along x, each a
 * loop over bytes that the compiler vectorises. Higher levels are folded from the level below, eight nodes to one. */
#include "octree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "parallel.h"
#include "samples.h"

int pel_octree_level_of(int size)
{
    int level = 0;
    while (level < PEL_OCTREE_LEVELS - 1 && 1 << level < size)
        level++;
    return level;
}

static int nodes_along(size_t voxels, int size)
{
    return voxels > 1 ? (int)((voxels - 2) / (size_t)size) + 1 : 1;
}

static size_t total(const int dims[3])
{
    return (size_t)dims[0] * (size_t)dims[1] * (size_t)dims[2];
}

static bool level_init(struct pel_octree_level *level, const struct pel_volume *volume, int size, struct pel_error *error)
{
    for (int a = 0; a < 3; a++)
        level->dims[a] = nodes_along(volume->dims[a], size);
    level->lo = pel_alloc_aligned(total(level->dims), 1, "min-max octree", error);
    level->hi = pel_alloc_aligned(total(level->dims), 1, "min-max octree", error);
    return level->lo && level->hi;
}

/* ---- bins ---- */

static void choose_bins(struct pel_octree *o, const struct pel_volume *v)
{
    bool integer = v->type != PEL_F32 && v->type != PEL_F64;
    double span = v->range[1] - v->range[0];
    o->voids = v->has_void || !integer;
    int bins = PEL_OCTREE_BINS - o->voids;
    o->least = v->range[0];
    o->exact = integer && span < bins;
    o->width = o->exact || !(span > 0) || !isfinite(span) ? 1 : span / bins;
}

static inline uint8_t bin_of(const struct pel_octree *o, double value)
{
    if (isnan(value))
        return 0; /* a void */
    double bin = floor((value - o->least) / o->width);
    int last = PEL_OCTREE_BINS - 1 - o->voids;
    return (uint8_t)((bin < 0 ? 0 : bin > last ? last : (int)bin) + o->voids);
}

bool pel_octree_interval(const struct pel_octree *o, int lo, int hi, double *least, double *most)
{
    if (lo > hi || hi < o->voids)
        return false;
    if (lo < o->voids)
        lo = o->voids; /* what lies between a void and a value is not reconstructed */
    double slack = o->exact ? 0 : 1e-9 * (fabs(o->least) + o->width * PEL_OCTREE_BINS);
    *least = o->least + (lo - o->voids) * o->width - slack;
    *most = o->least + (hi - o->voids + !o->exact) * o->width + slack;
    return true;
}

/* ---- leaves ---- */

struct work {
    struct pel_octree *octree;
    const struct pel_volume *volume;
    uint8_t table[256]; /* bins of bytes */
    uint8_t *scratch;   /* a thread's: a slice of bins, and two of their extremes */
    double *row;        /* a thread's: a row of values */
    size_t slice;       /* voxels of one */
};

/* A row of voxels as bins; bytes through a table. */
static void bin_row(const struct work *w, size_t first, size_t n, double *values, uint8_t *to)
{
    const struct pel_volume *v = w->volume;
    if (v->type == PEL_U8 || v->type == PEL_I8) {
        const uint8_t *from = (const uint8_t *)v->data + first;
        for (size_t i = 0; i < n; i++)
            to[i] = w->table[from[i]];
        return;
    }
    pel_samples_load(v, first, n, values);
    for (size_t i = 0; i < n; i++)
        to[i] = bin_of(w->octree, isfinite(values[i]) ? values[i] : NAN);
}

static void fold(uint8_t *restrict lo, uint8_t *restrict hi, const uint8_t *restrict with_lo, const uint8_t *restrict with_hi, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        lo[i] = with_lo[i] < lo[i] ? with_lo[i] : lo[i];
        hi[i] = with_hi[i] > hi[i] ? with_hi[i] : hi[i];
    }
}

/* Extremes of `size` + 1 bytes for each node, the last ones of the row where it ends. */
static void fold_along_x(const uint8_t *lo, const uint8_t *hi, size_t n, int size, int nodes, uint8_t *to_lo, uint8_t *to_hi)
{
    for (int x = 0; x < nodes; x++) {
        size_t first = (size_t)x * (size_t)size, last = first + (size_t)size < n ? first + (size_t)size : n - 1;
        uint8_t a = lo[first], b = hi[first];
        for (size_t i = first + 1; i <= last; i++) {
            a = lo[i] < a ? lo[i] : a;
            b = hi[i] > b ? hi[i] : b;
        }
        to_lo[x] = a;
        to_hi[x] = b;
    }
}

static void leaf_slab(void *context, size_t z, int thread)
{
    const struct work *w = context;
    const struct pel_volume *v = w->volume;
    const struct pel_octree_level *leaves = &w->octree->levels[w->octree->leaf];
    size_t size = (size_t)1 << w->octree->leaf, nx = v->dims[0], ny = v->dims[1];
    size_t z_end = z * size + size < v->dims[2] ? z * size + size : v->dims[2] - 1;
    uint8_t *bins = w->scratch + (size_t)thread * 3 * w->slice, *lo = bins + w->slice, *hi = lo + w->slice;
    for (size_t k = z * size; k <= z_end; k++) {
        for (size_t y = 0; y < ny; y++)
            bin_row(w, (k * ny + y) * nx, nx, w->row + (size_t)thread * nx, bins + y * nx);
        if (k > z * size) {
            fold(lo, hi, bins, bins, nx * ny);
        } else {
            memcpy(lo, bins, nx * ny);
            memcpy(hi, bins, nx * ny);
        }
    }
    for (size_t y = 0; y < (size_t)leaves->dims[1]; y++) {
        uint8_t *row_lo = bins, *row_hi = bins + nx; /* the bins are not needed any more; a slice has two rows, or one is enough */
        size_t last = y * size + size < ny ? y * size + size : ny - 1;
        memcpy(row_lo, lo + y * size * nx, nx);
        memcpy(row_hi, hi + y * size * nx, nx);
        for (size_t j = y * size + 1; j <= last; j++)
            fold(row_lo, row_hi, lo + j * nx, hi + j * nx, nx);
        size_t at = (z * (size_t)leaves->dims[1] + y) * (size_t)leaves->dims[0];
        fold_along_x(row_lo, row_hi, nx, (int)size, leaves->dims[0], leaves->lo + at, leaves->hi + at);
    }
}

static bool make_leaves(struct pel_octree *o, const struct pel_volume *v, int threads, struct pel_error *error)
{
    threads = pel_threads(threads);
    struct work w = { .octree = o, .volume = v, .slice = v->dims[0] * (v->dims[1] > 1 ? v->dims[1] : 2) };
    for (int i = 0; i < 256; i++) {
        int value = v->type == PEL_I8 ? (int8_t)i : i;
        w.table[i] = v->has_void && (double)value == v->void_value ? 0 : bin_of(o, value);
    }
    w.scratch = pel_alloc_aligned((size_t)threads * 3, w.slice, "min-max octree", error);
    w.row = pel_alloc_aligned((size_t)threads * v->dims[0], sizeof *w.row, "min-max octree", error);
    bool ok = w.scratch && w.row && level_init(&o->levels[o->leaf], v, 1 << o->leaf, error);
    if (ok)
        pel_parallel_for(threads, (size_t)o->levels[o->leaf].dims[2], leaf_slab, &w);
    free(w.row);
    free(w.scratch);
    return ok;
}

/* ---- the levels above ---- */

static void fold_level(struct pel_octree_level *to, const struct pel_octree_level *from)
{
    size_t at = 0;
    for (int z = 0; z < to->dims[2]; z++)
        for (int y = 0; y < to->dims[1]; y++)
            for (int x = 0; x < to->dims[0]; x++, at++) {
                uint8_t lo = 255, hi = 0;
                for (int k = 2 * z; k < 2 * z + 2 && k < from->dims[2]; k++)
                    for (int j = 2 * y; j < 2 * y + 2 && j < from->dims[1]; j++)
                        for (int i = 2 * x; i < 2 * x + 2 && i < from->dims[0]; i++) {
                            size_t child = ((size_t)k * (size_t)from->dims[1] + (size_t)j) * (size_t)from->dims[0] + (size_t)i;
                            lo = from->lo[child] < lo ? from->lo[child] : lo;
                            hi = from->hi[child] > hi ? from->hi[child] : hi;
                        }
                to->lo[at] = lo;
                to->hi[at] = hi;
            }
}

bool pel_octree_init(struct pel_octree *octree, const struct pel_volume *volume, int leaf, int threads, struct pel_error *error)
{
    memset(octree, 0, sizeof *octree);
    octree->leaf = leaf;
    choose_bins(octree, volume);
    bool ok = make_leaves(octree, volume, threads, error);
    for (int l = leaf + 1; ok && l < PEL_OCTREE_LEVELS; l++) {
        ok = level_init(&octree->levels[l], volume, 1 << l, error);
        if (ok)
            fold_level(&octree->levels[l], &octree->levels[l - 1]);
    }
    if (!ok)
        pel_octree_finish(octree);
    return ok;
}

void pel_octree_finish(struct pel_octree *octree)
{
    for (int l = 0; l < PEL_OCTREE_LEVELS; l++) {
        free(octree->levels[l].lo);
        free(octree->levels[l].hi);
    }
    memset(octree, 0, sizeof *octree);
}

size_t pel_octree_bytes(const struct pel_octree *octree)
{
    size_t bytes = 0;
    for (int l = octree->leaf; l < PEL_OCTREE_LEVELS; l++)
        bytes += 2 * total(octree->levels[l].dims);
    return bytes;
}

/* SPDX-License-Identifier: MIT */
/* The ranges of macro-cells (section 4.1) by the CPU, for software devices, where a shader takes ten times as long. What peel_range.glsl
 * makes, texel for texel: in the texture's own type, of cells of any edge, and where a cell has a void with its neighbours' voxels; that is
 * why it is not the grid of minmax.h.
 *
 * A row of cells at a time: the rows of voxels that it touches are folded into one row of extremes, and that along x into cells. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "parallel.h"
#include "peel.h"

#define LAYERS 16 /* of cells that a thread makes before they are sent */

/* A thread's rows of samples as they are sent: one of the volume; the extremes of the cells' own voxels; the extremes of these and their
 * neighbours, and which of their own are void, where there are voids. */
enum { ROW_SAMPLES, ROW_LEAST, ROW_MOST, ROW_WIDE_LEAST, ROW_WIDE_MOST, ROW_VOIDS, ROWS };

struct ranging {
    const struct pel_volume *volume;
    const struct pel_gpu_format *format;
    const int *grid; /* and the cells' edge */
    char *rows;      /* ROWS a thread */
    size_t row_size; /* bytes of one */
    char *ranges;    /* of a chunk's cells, in pairs */
    size_t first;    /* layer of cells that it begins with */
};

/* Voxels along an axis that a cell and, with `wide` 1, its neighbours have: from `first` up to and with `last`. */
static void stretch(const struct ranging *r, int axis, size_t cell, size_t wide, size_t *first, size_t *last)
{
    size_t edge = (size_t)r->grid[3], most = r->volume->dims[axis] - 1, from = cell * edge, to = from + edge + wide;
    *first = from > wide ? from - wide : 0;
    *last = to < most ? to : most;
}

#define RANGES(NAME, T, LOW, HIGH)                                                                                                         \
    static void clear_##NAME(const struct ranging *r, void *const rows[ROWS])                                                              \
    {                                                                                                                                      \
        size_t n = r->volume->dims[0];                                                                                                     \
        for (size_t i = 0; i < n; i++) {                                                                                                   \
            ((T *)rows[ROW_LEAST])[i] = ((T *)rows[ROW_WIDE_LEAST])[i] = HIGH;                                                             \
            ((T *)rows[ROW_MOST])[i] = ((T *)rows[ROW_WIDE_MOST])[i] = LOW;                                                                \
        }                                                                                                                                  \
        memset(rows[ROW_VOIDS], 0, n);                                                                                                     \
    }                                                                                                                                      \
    static void fold_##NAME(const struct ranging *r, void *const rows[ROWS], bool own)                                                     \
    {                                                                                                                                      \
        const T *restrict v = rows[ROW_SAMPLES];                                                                                           \
        T *restrict lo = rows[own ? ROW_LEAST : ROW_WIDE_LEAST], *restrict hi = rows[own ? ROW_MOST : ROW_WIDE_MOST];                      \
        bool *restrict voids = rows[ROW_VOIDS];                                                                                            \
        const float offset = r->format->texel_offset, gap = r->format->void_raw, within = r->format->void_within;                          \
        size_t n = r->volume->dims[0];                                                                                                     \
        for (size_t i = 0; i < n && !r->format->voids; i++) {                                                                              \
            lo[i] = v[i] < lo[i] ? v[i] : lo[i];                                                                                           \
            hi[i] = v[i] > hi[i] ? v[i] : hi[i];                                                                                           \
        }                                                                                                                                  \
        for (size_t i = 0; i < n && r->format->voids; i++) {                                                                               \
            float raw = (float)v[i] + offset;                                                                                              \
            bool is_void = !(fabsf(raw) <= 3.4e38f) | (fabsf(raw - gap) <= within);                                                        \
            voids[i] |= is_void & own;                                                                                                     \
            lo[i] = !is_void && v[i] < lo[i] ? v[i] : lo[i];                                                                               \
            hi[i] = !is_void && v[i] > hi[i] ? v[i] : hi[i];                                                                               \
        }                                                                                                                                  \
    }                                                                                                                                      \
    static void gather_##NAME(const struct ranging *r, void *const rows[ROWS], void *to)                                                   \
    {                                                                                                                                      \
        T *pair = to;                                                                                                                      \
        for (size_t x = 0; x < (size_t)r->grid[0]; x++, pair += 2) {                                                                       \
            size_t first, last;                                                                                                            \
            bool voids = false;                                                                                                            \
            stretch(r, 0, x, 0, &first, &last);                                                                                            \
            for (size_t i = first; i <= last && r->format->voids; i++)                                                                     \
                voids |= ((const bool *)rows[ROW_VOIDS])[i];                                                                               \
            if (voids)                                                                                                                     \
                stretch(r, 0, x, 1, &first, &last);                                                                                        \
            const T *lo = rows[ROW_LEAST], *hi = rows[ROW_MOST], *wide_lo = rows[ROW_WIDE_LEAST], *wide_hi = rows[ROW_WIDE_MOST];          \
            T a = HIGH, b = LOW;                                                                                                           \
            for (size_t i = first; i <= last; i++) {                                                                                       \
                a = lo[i] < a ? lo[i] : a;                                                                                                 \
                b = hi[i] > b ? hi[i] : b;                                                                                                 \
            }                                                                                                                              \
            for (size_t i = first; i <= last && voids; i++) {                                                                              \
                a = wide_lo[i] < a ? wide_lo[i] : a;                                                                                       \
                b = wide_hi[i] > b ? wide_hi[i] : b;                                                                                       \
            }                                                                                                                              \
            pair[0] = a;                                                                                                                   \
            pair[1] = b;                                                                                                                   \
        }                                                                                                                                  \
    }

RANGES(u8, uint8_t, 0, UINT8_MAX)
RANGES(u16, uint16_t, 0, UINT16_MAX)
RANGES(f32, float, -3.4e38f, 3.4e38f)

/* By the bytes of a sample as it is sent. */
static const struct {
    void (*clear)(const struct ranging *r, void *const rows[ROWS]);
    void (*fold)(const struct ranging *r, void *const rows[ROWS], bool own);
    void (*gather)(const struct ranging *r, void *const rows[ROWS], void *to);
} by_bytes[] = {
    [1] = { clear_u8, fold_u8, gather_u8 },
    [2] = { clear_u16, fold_u16, gather_u16 },
    [4] = { clear_f32, fold_f32, gather_f32 },
};

/* The rows of voxels of a row of cells; where there are voids, those around them, too. */
static void fold_rows(const struct ranging *r, void *const rows[ROWS], int bytes, size_t cy, size_t cz)
{
    size_t y[2], z[2], own_y[2], own_z[2], wide = r->format->voids, nx = r->volume->dims[0];
    stretch(r, 1, cy, wide, &y[0], &y[1]);
    stretch(r, 2, cz, wide, &z[0], &z[1]);
    stretch(r, 1, cy, 0, &own_y[0], &own_y[1]);
    stretch(r, 2, cz, 0, &own_z[0], &own_z[1]);
    by_bytes[bytes].clear(r, rows);
    for (size_t k = z[0]; k <= z[1]; k++)
        for (size_t j = y[0]; j <= y[1]; j++) {
            bool own = j >= own_y[0] && j <= own_y[1] && k >= own_z[0] && k <= own_z[1];
            pel_gpu_samples(r->format, r->volume, (k * r->volume->dims[1] + j) * nx, nx, rows[ROW_SAMPLES]);
            by_bytes[bytes].fold(r, rows, own);
        }
}

static void range_layer(void *context, size_t layer, int thread)
{
    const struct ranging *r = context;
    int bytes;
    void *rows[ROWS];
    pel_gpu_sample_type(r->volume, &bytes);
    for (size_t i = 0; i < ROWS; i++)
        rows[i] = r->rows + ((size_t)thread * ROWS + i) * r->row_size;
    for (size_t cy = 0; cy < (size_t)r->grid[1]; cy++) {
        fold_rows(r, rows, bytes, cy, r->first + layer);
        by_bytes[bytes].gather(r, rows, r->ranges + (layer * (size_t)r->grid[1] + cy) * (size_t)r->grid[0] * 2 * (size_t)bytes);
    }
}

bool pel_peel_send_ranges(struct pel_peel *p, const struct pel_volume *volume, int threads, struct pel_error *error)
{
    const int *grid = p->view.grid;
    int bytes;
    GLenum type = pel_gpu_sample_type(volume, &bytes);
    size_t layer = (size_t)grid[0] * (size_t)grid[1] * 2 * (size_t)bytes, layers;
    struct ranging r = { .volume = volume, .format = &p->format, .grid = grid };
    threads = pel_threads(threads);
    layers = (size_t)threads * LAYERS;
    layers = layers > (size_t)grid[2] ? (size_t)grid[2] : layers;
    r.row_size = (volume->dims[0] * (size_t)bytes + 63) & ~(size_t)63;
    r.rows = pel_alloc_aligned((size_t)threads * ROWS, r.row_size, "rows of macro-cells", error);
    r.ranges = r.rows ? pel_alloc_aligned(layers, layer, "ranges of macro-cells", error) : NULL;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    for (; r.ranges && r.first < (size_t)grid[2]; r.first += layers) {
        size_t count = (size_t)grid[2] - r.first < layers ? (size_t)grid[2] - r.first : layers;
        pel_parallel_for(threads, count, range_layer, &r);
        glTextureSubImage3D(p->ranges.name, 0, 0, 0, (GLint)r.first, grid[0], grid[1], (GLsizei)count, GL_RG, type, r.ranges);
    }
    bool ok = r.ranges && pel_device_check(p->device, "ranges of cells", error);
    free(r.rows);
    free(r.ranges);
    return ok;
}

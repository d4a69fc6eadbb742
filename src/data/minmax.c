/* SPDX-License-Identifier: MIT */
/* Built a row of cells at a time: the 5 x 5 voxel rows that a row of cells touches are folded into one row of extremes (a loop over x that
 * the compiler vectorises in the voxels' own type), which is then folded along x, five voxels a cell. */
#include "minmax.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "fail.h"
#include "parallel.h"

struct work {
    const struct pel_volume *volume;
    struct pel_minmax *minmax;
    char *rows;      /* two rows of the voxels' type a thread: least and most */
    size_t row_size; /* bytes of one */
    bool *voids;     /* one a thread */
};

/* Folds one voxel row into least and most. Integers have no NaN; a void value is compared in the voxels' type. */
#define FOLD_INTEGER(NAME, T, LOW, HIGH)                                                                                                   \
    static bool fold_##NAME(const void *row, size_t n, void *least_row, void *most_row, bool has_void, double void_value)                  \
    {                                                                                                                                      \
        const T *restrict v = row;                                                                                                         \
        T *restrict lo = least_row, *restrict hi = most_row;                                                                               \
        bool fits = has_void && void_value >= (double)LOW && void_value <= (double)HIGH;                                                   \
        T gap = fits ? (T)void_value : 0;                                                                                                  \
        if (!fits || (double)gap != void_value) {                                                                                          \
            for (size_t i = 0; i < n; i++) {                                                                                               \
                lo[i] = v[i] < lo[i] ? v[i] : lo[i];                                                                                       \
                hi[i] = v[i] > hi[i] ? v[i] : hi[i];                                                                                       \
            }                                                                                                                              \
            return false;                                                                                                                  \
        }                                                                                                                                  \
        bool any = false;                                                                                                                  \
        for (size_t i = 0; i < n; i++) {                                                                                                   \
            bool is = v[i] == gap;                                                                                                         \
            any |= is;                                                                                                                     \
            lo[i] = !is && v[i] < lo[i] ? v[i] : lo[i];                                                                                    \
            hi[i] = !is && v[i] > hi[i] ? v[i] : hi[i];                                                                                    \
        }                                                                                                                                  \
        return any;                                                                                                                        \
    }

#define FOLD_REAL(NAME, T, BIGGEST)                                                                                                        \
    static bool fold_##NAME(const void *row, size_t n, void *least_row, void *most_row, bool has_void, double void_value)                  \
    {                                                                                                                                      \
        const T *restrict v = row;                                                                                                         \
        T *restrict lo = least_row, *restrict hi = most_row;                                                                               \
        T gap = has_void ? (T)void_value : (T)NAN;                                                                                         \
        int any = 0;                                                                                                                       \
        for (size_t i = 0; i < n; i++) {                                                                                                   \
            int good = (v[i] <= BIGGEST) & (v[i] >= -BIGGEST) & (v[i] != gap);                                                             \
            any |= !good;                                                                                                                  \
            lo[i] = good & (v[i] < lo[i]) ? v[i] : lo[i];                                                                                  \
            hi[i] = good & (v[i] > hi[i]) ? v[i] : hi[i];                                                                                  \
        }                                                                                                                                  \
        return any;                                                                                                                        \
    }

/* Folds the extremes of a voxel row into the cells, and starts the rows anew. An integer row that met voids only keeps least > most. */
#define GATHER(NAME, T, LOW, HIGH)                                                                                                         \
    static void clear_##NAME(void *least_row, void *most_row, size_t n)                                                                    \
    {                                                                                                                                      \
        T *lo = least_row, *hi = most_row;                                                                                                 \
        for (size_t i = 0; i < n; i++)                                                                                                     \
            lo[i] = HIGH, hi[i] = LOW;                                                                                                     \
    }                                                                                                                                      \
    static void gather_##NAME(const void *least_row, const void *most_row, size_t n, size_t cells, float *least, float *most)              \
    {                                                                                                                                      \
        const T *lo = least_row, *hi = most_row;                                                                                           \
        for (size_t c = 0; c < cells; c++) {                                                                                               \
            size_t first = c * PEL_CELL_SIZE, last = first + PEL_CELL_SIZE < n ? first + PEL_CELL_SIZE : n - 1;                            \
            T a = HIGH, b = LOW;                                                                                                           \
            for (size_t i = first; i <= last; i++) {                                                                                       \
                a = lo[i] < a ? lo[i] : a;                                                                                                 \
                b = hi[i] > b ? hi[i] : b;                                                                                                 \
            }                                                                                                                              \
            least[c] = a > b ? INFINITY : round_down((double)a);                                                                           \
            most[c] = a > b ? -INFINITY : round_up((double)b);                                                                             \
        }                                                                                                                                  \
    }

static float round_down(double v)
{
    float f = (float)v;
    return (double)f > v ? nextafterf(f, -INFINITY) : f;
}

static float round_up(double v)
{
    float f = (float)v;
    return (double)f < v ? nextafterf(f, INFINITY) : f;
}

FOLD_INTEGER(u8, uint8_t, 0, UINT8_MAX)
FOLD_INTEGER(i8, int8_t, INT8_MIN, INT8_MAX)
FOLD_INTEGER(u16, uint16_t, 0, UINT16_MAX)
FOLD_INTEGER(i16, int16_t, INT16_MIN, INT16_MAX)
FOLD_INTEGER(u32, uint32_t, 0, UINT32_MAX)
FOLD_INTEGER(i32, int32_t, INT32_MIN, INT32_MAX)
FOLD_REAL(f32, float, 3.402823466e38f)
FOLD_REAL(f64, double, 1.7976931348623157e308)
GATHER(u8, uint8_t, 0, UINT8_MAX)
GATHER(i8, int8_t, INT8_MIN, INT8_MAX)
GATHER(u16, uint16_t, 0, UINT16_MAX)
GATHER(i16, int16_t, INT16_MIN, INT16_MAX)
GATHER(u32, uint32_t, 0, UINT32_MAX)
GATHER(i32, int32_t, INT32_MIN, INT32_MAX)
GATHER(f32, float, -INFINITY, INFINITY)
GATHER(f64, double, -(double)INFINITY, (double)INFINITY)

#define ROW(NAME) { fold_##NAME, clear_##NAME, gather_##NAME }
static const struct {
    bool (*fold)(const void *row, size_t n, void *least, void *most, bool has_void, double void_value);
    void (*clear)(void *least, void *most, size_t n);
    void (*gather)(const void *least_row, const void *most_row, size_t n, size_t cells, float *least, float *most);
} by_type[PEL_TYPE_COUNT] = {
    [PEL_U8] = ROW(u8),   [PEL_I8] = ROW(i8),   [PEL_U16] = ROW(u16), [PEL_I16] = ROW(i16),
    [PEL_U32] = ROW(u32), [PEL_I32] = ROW(i32), [PEL_F32] = ROW(f32), [PEL_F64] = ROW(f64),
};

static void cell_slab(void *context, size_t cz, int thread)
{
    struct work *w = context;
    const struct pel_volume *v = w->volume;
    struct pel_minmax_level *cells = &w->minmax->cells;
    char *lo = w->rows + (size_t)thread * 2 * w->row_size, *hi = lo + w->row_size;
    size_t nx = v->dims[0], row_bytes = nx * pel_type_size(v->type);
    size_t z1 = cz * PEL_CELL_SIZE + PEL_CELL_SIZE < v->dims[2] ? cz * PEL_CELL_SIZE + PEL_CELL_SIZE : v->dims[2] - 1;
    for (size_t cy = 0; cy < cells->dims[1]; cy++) {
        size_t y1 = cy * PEL_CELL_SIZE + PEL_CELL_SIZE < v->dims[1] ? cy * PEL_CELL_SIZE + PEL_CELL_SIZE : v->dims[1] - 1;
        by_type[v->type].clear(lo, hi, nx);
        for (size_t z = cz * PEL_CELL_SIZE; z <= z1; z++)
            for (size_t y = cy * PEL_CELL_SIZE; y <= y1; y++) {
                const char *row = (const char *)v->data + (z * v->dims[1] + y) * row_bytes;
                if (by_type[v->type].fold(row, nx, lo, hi, v->has_void, v->void_value))
                    w->voids[thread] = true;
            }
        size_t at = (cz * cells->dims[1] + cy) * cells->dims[0];
        by_type[v->type].gather(lo, hi, nx, cells->dims[0], cells->least + at, cells->most + at);
    }
}

/* Extremes of the up to 4^3 cells of each block in a slab of blocks. */
static void block_slab(void *context, size_t bz, int thread)
{
    (void)thread;
    struct work *w = context;
    const struct pel_minmax_level *cells = &w->minmax->cells;
    struct pel_minmax_level *blocks = &w->minmax->blocks;
    float *least = blocks->least + bz * blocks->dims[0] * blocks->dims[1], *most = blocks->most + bz * blocks->dims[0] * blocks->dims[1];
    for (size_t i = 0; i < blocks->dims[0] * blocks->dims[1]; i++)
        least[i] = INFINITY, most[i] = -INFINITY;
    for (size_t z = bz * 4; z < bz * 4 + 4 && z < cells->dims[2]; z++)
        for (size_t y = 0; y < cells->dims[1]; y++)
            for (size_t x = 0; x < cells->dims[0]; x++) {
                size_t from = (z * cells->dims[1] + y) * cells->dims[0] + x, to = (y / 4) * blocks->dims[0] + x / 4;
                least[to] = cells->least[from] < least[to] ? cells->least[from] : least[to];
                most[to] = cells->most[from] > most[to] ? cells->most[from] : most[to];
            }
}

static bool level_init(struct pel_minmax_level *level, const size_t dims[3], struct pel_error *error)
{
    memcpy(level->dims, dims, sizeof level->dims);
    size_t count = dims[0] * dims[1] * dims[2];
    level->least = pel_alloc_aligned(count + 1, sizeof(float), "min-max grid", error);
    level->most = pel_alloc_aligned(count + 1, sizeof(float), "min-max grid", error);
    return level->least && level->most;
}

bool pel_minmax_init(struct pel_minmax *minmax, const struct pel_volume *volume, int threads, struct pel_error *error)
{
    memset(minmax, 0, sizeof *minmax);
    threads = pel_threads(threads);
    size_t cells[3], blocks[3];
    for (int a = 0; a < 3; a++) {
        cells[a] = (volume->dims[a] - 1) / PEL_CELL_SIZE + 1;
        blocks[a] = (cells[a] - 1) / 4 + 1;
    }
    struct work w = { .volume = volume, .minmax = minmax, .row_size = (volume->dims[0] * pel_type_size(volume->type) + 63) & ~(size_t)63 };
    w.rows = pel_alloc_aligned((size_t)threads * 2, w.row_size, "min-max rows", error);
    w.voids = pel_alloc((size_t)threads, sizeof *w.voids, "min-max flags", error);
    bool ok = w.rows && w.voids && level_init(&minmax->cells, cells, error) && level_init(&minmax->blocks, blocks, error);
    if (ok) {
        pel_parallel_for(threads, cells[2], cell_slab, &w);
        pel_parallel_for(threads, blocks[2], block_slab, &w);
        for (int i = 0; i < threads; i++)
            minmax->has_voids |= w.voids[i];
    } else {
        pel_minmax_finish(minmax);
    }
    free(w.rows);
    free(w.voids);
    return ok;
}

void pel_minmax_finish(struct pel_minmax *minmax)
{
    free(minmax->cells.least);
    free(minmax->cells.most);
    free(minmax->blocks.least);
    free(minmax->blocks.most);
    memset(minmax, 0, sizeof *minmax);
}

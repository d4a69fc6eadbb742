/* SPDX-License-Identifier: MIT */
/* Voxels of a scanline that are neighbours in memory: whole vectors are loaded where fetch.h gathers. This is what object-aligned slices
 * are for: at a pixel a voxel all lanes have the same weights.
 *
 * Along x the volume itself has such rows. Where scanlines run along y (the principal axis is x), a band of scanlines turns the voxels that
 * it is about to read into rows (turn_block), a few slices at a time: no turned copy of the volume is kept. The arithmetic is that of
 * fetch.h to the bit, since a pixel may be fetched either way. */
#ifndef PEL_CPU_KERNEL_SHEAR_FETCH_H
#define PEL_CPU_KERNEL_SHEAR_FETCH_H

#include "fetch.h"
#include "shear.h"

PEL_INLINE vf vf_load(const float *from)
{
    vf v;
    memcpy(&v, from, sizeof v);
    return v;
}

PEL_INLINE void vf_store(float *to, vf v)
{
    memcpy(to, &v, sizeof v);
}

/* A scanline's place in a slice. */
struct slice_row {
    float i, di;  /* i(u) = i + u di */
    int whole;    /* unit: the whole part of i; `i` is the rest */
    int j;        /* the row of voxels before it */
    float weight; /* how far it is towards the next */
    int m;
    bool near;                              /* unit steps in a slice of voxels that has others around: no gathering is needed */
    bool turned;                            /* then: the rows were turned */
    const void *rows;                       /* then: where they are */
    ptrdiff_t offset, next_row, next_slice; /* then: voxel of pixel 0, and from row to row and slice to slice */
    int32_t pair;                           /* then: the weights of two neighbours (x_weights of fetch.h) */
};

#if PEL_KIND != PEL_KIND_WIDE

#if PEL_KIND == PEL_KIND_U8
typedef uint8_t narrow_type;
#elif PEL_KIND == PEL_KIND_U16
typedef uint16_t narrow_type;
#else
typedef float narrow_type;
#endif

#if PEL_KIND == PEL_KIND_U8 || PEL_KIND == PEL_KIND_U16

typedef narrow_type narrow __attribute__((vector_size(W * sizeof(narrow_type))));
typedef vi row_voxels;

/* W neighbours along a row; 16-bit numbers in their lanes' lower halves. `j` rows, `k` slices and `x` voxels on. */
PEL_INLINE vi row_load(const struct pel_job *job, const struct slice_row *r, int u, int x, int j, int k)
{
    narrow n;
    memcpy(&n, (const narrow_type *)r->rows + r->offset + u + x + j * r->next_row + k * r->next_slice, sizeof n);
#if PEL_KIND == PEL_KIND_U8
    return __builtin_convertvector(n ^ (narrow_type)job->flip, vi);
#else
    typedef int16_t narrow_signed __attribute__((vector_size(W * 2)));
    return __builtin_convertvector((narrow_signed)(n ^ (narrow_type)job->flip), vi);
#endif
}

/* The raw value. */
PEL_INLINE vf row_float(vi voxels)
{
    return vi_to_vf(voxels) * 16384.0f;
}

PEL_INLINE vi row_pair(vi left, vi right)
{
    return (PEL_KIND == PEL_KIND_U8 ? left : left & 0xffff) | (right << 16);
}

PEL_INLINE vi row_weights(const struct slice_row *r)
{
    return vi_set(r->pair);
}

/* As middle_lerp and slope_lerp of fetch.h. */
PEL_INLINE vf row_lerp(const struct slice_row *r, vi left, vi right)
{
    return vi_to_vf(vi_madd16(row_pair(left, right), row_weights(r)));
}

PEL_INLINE vf row_slope(const struct slice_row *r, const vi v[4])
{
    vi w = row_weights(r), front = vi_madd16(row_pair(v[0], v[1]), w), back = vi_madd16(row_pair(v[2], v[3]), w);
#if PEL_KIND == PEL_KIND_U8
    return vi_to_vf(back - front);
#else
    return vi_to_vf(back) - vi_to_vf(front);
#endif
}

#else

typedef vf row_voxels;

PEL_INLINE vf row_load(const struct pel_job *job, const struct slice_row *r, int u, int x, int j, int k)
{
    (void)job;
    return vf_load((const float *)r->rows + r->offset + u + x + j * r->next_row + k * r->next_slice);
}

PEL_INLINE vf row_float(vf voxels)
{
    return voxels;
}

PEL_INLINE vf row_lerp(const struct slice_row *r, vf left, vf right)
{
    return vf_lerp(left, right, vf_set(r->i));
}

PEL_INLINE vf row_slope(const struct slice_row *r, const vf v[4])
{
    return vf_lerp(v[2] - v[0], v[3] - v[1], vf_set(r->i));
}

#endif

/* The next scanline reads a row farther: it is fetched while this one goes on. */
PEL_INLINE void near_prefetch(const struct slice_row *r, int u, int rows)
{
    __builtin_prefetch((const narrow_type *)r->rows + r->offset + u + rows * r->next_row);
}

PEL_INLINE vf row_value(const struct pel_job *job, const struct slice_row *r, int u, int j, int k)
{
    return row_lerp(r, row_load(job, r, u, 0, j, k), row_load(job, r, u, 1, j, k));
}

/* A turned voxel's raw value. */
PEL_INLINE vf turned(const struct pel_job *job, const struct slice_row *r, int u, int x, int j, int k)
{
    return row_float(row_load(job, r, u, x, j, k));
}

/* The value in a slice of voxels: bilinear. The same bits as fetch_value gives. */
PEL_INLINE vf near_value(const struct pel_job *job, const struct slice_row *r, int u)
{
    vf weight = vf_set(r->weight);
    if (!r->turned)
        return vf_lerp(row_value(job, r, u, 0, 0), row_value(job, r, u, 1, 0), weight);
    vf part = vf_set(r->i);
    return vf_lerp(vf_lerp(turned(job, r, u, 0, 0, 0), turned(job, r, u, 1, 0, 0), part),
                   vf_lerp(turned(job, r, u, 0, 1, 0), turned(job, r, u, 1, 1, 0), part), weight);
}

PEL_INLINE void straight_gradient(const struct pel_job *job, const struct slice_row *r, int u, vf to[3])
{
    vf weight = vf_set(r->weight), middle[2], slope[2];
    for (int j = 0; j < 2; j++) {
        row_voxels v[4];
        for (int x = 0; x < 4; x++)
            v[x] = row_load(job, r, u, x - 1, j, 0);
        middle[j] = row_lerp(r, v[1], v[2]);
        slope[j] = row_slope(r, v);
    }
    to[0] = vf_lerp(slope[0], slope[1], weight);
    to[1] = vf_lerp(middle[1] - row_value(job, r, u, -1, 0), row_value(job, r, u, 2, 0) - middle[0], weight);
    to[2] =
        vf_lerp(row_value(job, r, u, 0, 1) - row_value(job, r, u, 0, -1), row_value(job, r, u, 1, 1) - row_value(job, r, u, 1, -1), weight);
}

PEL_INLINE void turned_gradient(const struct pel_job *job, const struct slice_row *r, int u, vf to[3])
{
    vf weight = vf_set(r->weight), part = vf_set(r->i), along[2], across[2], through[2], v[2][2];
    for (int j = 0; j < 2; j++) {
        for (int x = 0; x < 2; x++)
            v[j][x] = turned(job, r, u, x, j, 0);
        along[j] = vf_lerp(v[j][1] - turned(job, r, u, -1, j, 0), turned(job, r, u, 2, j, 0) - v[j][0], part);
        through[j] = vf_lerp(turned(job, r, u, 0, j, 1) - turned(job, r, u, 0, j, -1),
                             turned(job, r, u, 1, j, 1) - turned(job, r, u, 1, j, -1), part);
    }
    for (int x = 0; x < 2; x++)
        across[x] = vf_lerp(v[1][x] - turned(job, r, u, x, -1, 0), turned(job, r, u, x, 2, 0) - v[0][x], weight);
    to[0] = vf_lerp(along[0], along[1], weight);
    to[1] = vf_lerp(across[0], across[1], part);
    to[2] = vf_lerp(through[0], through[1], weight);
}

/* As fetch_gradient. */
PEL_INLINE void near_gradient(const struct pel_job *job, const struct pel_shear *s, const struct slice_row *r, int u, vf g[3])
{
    vf to[3];
    if (r->turned)
        turned_gradient(job, r, u, to);
    else
        straight_gradient(job, r, u, to);
    for (int a = 0; a < 3; a++)
        g[s->axis[a]] = to[a] * (0.5f * job->gradient_scale);
}

/* ---- turning: the principal axis is x, scanlines run along y, from z to z ---- */

/* Cells along y, from `word` * 64 on, around which samples may read voxel row z of the voxels x0 to x1. */
PEL_INLINE uint64_t turn_wanted(const struct pel_job *job, const struct pel_shear *s, int x0, int x1, int z, int word, bool shaded)
{
    const int reach = shaded ? 1 : 0, layers = job->cell_dims[0], rows = job->cell_dims[2];
    int c0 = (x0 - reach) >> PEL_CELL_SHIFT, c1 = (x1 + reach) >> PEL_CELL_SHIFT, r0 = (z - 1 - reach) >> PEL_CELL_SHIFT,
        r1 = (z + reach) >> PEL_CELL_SHIFT;
    c0 = c0 > 0 ? c0 : 0, c1 = c1 < layers ? c1 : layers - 1, r0 = r0 > 0 ? r0 : 0, r1 = r1 < rows ? r1 : rows - 1;
    uint64_t bits = 0;
    for (int c = c0; c <= c1; c++)
        for (int r = r0; r <= r1; r++) {
            const uint64_t *run = s->runs + ((size_t)c * (size_t)rows + (size_t)r) * (size_t)s->run_words + word;
            bits |= run[0] | run[0] << 1 | run[0] >> 1; /* samples read voxels beside their cell */
            bits |= word > 0 ? run[-1] >> 63 : 0;
            bits |= word + 1 < s->run_words ? run[1] << 63 : 0;
        }
    return bits;
}

/* Turns W voxels from (x, y, z) on along y, of as many x as a gather brings, into rows at `to`, `next` apart. */
PEL_INLINE void turn_voxels(const struct pel_job *job, int x, int y, int z, narrow_type *to, ptrdiff_t next)
{
    vi at = vi_min(vi_lane() + y, vi_set(job->dims[1] - 1)) * job->row + (x + z * job->slice);
#if PEL_KIND == PEL_KIND_U8
    vi word = vi_gather(job->data, at);
    for (int i = 0; i < 4; i++) {
        narrow n = __builtin_convertvector((word >> (8 * i)) & 0xff, narrow);
        memcpy(to + i * next, &n, sizeof n);
    }
#elif PEL_KIND == PEL_KIND_U16
    vi word = vi_gather2(job->data, at);
    for (int i = 0; i < 2; i++) {
        narrow n = __builtin_convertvector((word >> (16 * i)) & 0xffff, narrow);
        memcpy(to + i * next, &n, sizeof n);
    }
#else
    vf voxel = vf_gather(job->data, at);
    memcpy(to, &voxel, sizeof voxel);
    (void)next;
#endif
}

#define TURN_STEP (PEL_KIND == PEL_KIND_U8 ? 4 : PEL_KIND == PEL_KIND_U16 ? 2 : 1)

#define TURN_WORDS ((PEL_TURN_SLICES + 8) / TURN_STEP + 1)

/* Turns what slices of voxels x0 to x1 and rows z0 to z1 may be asked for, into turn->rows: W rows of y at a time along x, so that a line
 * that was fetched is used up. */
PEL_INLINE void turn_block(const struct pel_job *job, const struct pel_shear *s, const struct pel_turn *turn, bool shaded)
{
    const int words = (turn->x1 - turn->x0) / TURN_STEP + 1;
    for (int z = turn->z0; z <= turn->z1; z++)
        for (int word = 0; word < s->run_words; word++) {
            uint64_t wanted[TURN_WORDS], any = 0;
            int x[TURN_WORDS];
            for (int i = 0; i < words; i++) {
                x[i] = turn->x0 + i * TURN_STEP;
                x[i] = x[i] < job->row - TURN_STEP ? x[i] : job->row - TURN_STEP; /* a row's last word begins before its end */
                wanted[i] = turn_wanted(job, s, x[i], x[i] + TURN_STEP - 1, z, word, shaded);
                any |= wanted[i];
            }
            narrow_type *to = (narrow_type *)turn->rows + (z - turn->z0) * turn->next_row;
            while (any) {
                const int first = __builtin_ctzll(any) & ~(W / PEL_CELL_SIZE - 1), y = (word * 64 + first) * PEL_CELL_SIZE;
                const uint64_t mask = (((uint64_t)1 << (W / PEL_CELL_SIZE)) - 1) << first;
                for (int l = 0; l < W && y + l < job->dims[1] && z < turn->z1; l++) /* what is next, a row of z on */
                    __builtin_prefetch((const narrow_type *)job->data + turn->x0 + (ptrdiff_t)(y + l) * job->row +
                                       (ptrdiff_t)(z + 1) * job->slice);
                for (int i = 0; i < words && y < job->dims[1]; i++)
                    if (wanted[i] & mask)
                        turn_voxels(job, x[i], y, z, to + (x[i] - turn->x0) * turn->next_slice + y, turn->next_slice);
                any &= ~mask;
            }
        }
}

#else

PEL_INLINE void turn_block(const struct pel_job *job, const struct pel_shear *s, const struct pel_turn *turn, bool shaded)
{
    (void)job, (void)s, (void)turn, (void)shaded; /* never asked for */
}

#endif

#endif

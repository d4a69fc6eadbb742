/* SPDX-License-Identifier: MIT */
#include "cubes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alloc.h"
#include "parallel.h"

enum {
    ABOVE = 2,
    LONGEST_RUN = 64,         /* cubes of a run; a word's */
    CUBES_A_THREAD = 1 << 19, /* fewer are not worth waking another for, and waiting for it where the machine is busy */
};

void pel_cube_table_build(struct pel_cube_table *table, const struct pel_octree *octree, const struct pel_transfer_table *transfer)
{
    memset(table, 0, sizeof *table);
    for (int hi = 0; hi < PEL_OCTREE_BINS; hi++)
        for (int lo = 0; lo <= hi; lo++) {
            double a, b;
            float least, most;
            if (!pel_octree_interval(octree, lo, hi, &a, &b))
                continue;
            bool voids = octree->voids && lo == 0;
            pel_transfer_table_opacity_range(transfer, a, b, &least, &most);
            int at = lo + PEL_OCTREE_BINS * hi;
            table->classes[at] = most <= 0 ? PEL_CUBE_EMPTY : least > 0 && !voids ? PEL_CUBE_FULL : PEL_CUBE_MIXED;
            table->opacity[at] = voids ? 0 : (uint8_t)floorf(least * 255);
        }
}

/* ---- which cubes ---- */

struct work {
    struct pel_cube_set *set;
    const struct pel_octree_level *nodes, *above; /* of the cubes; of nodes 2^ABOVE times as large */
    const struct pel_cube_table *table;
    int shift;     /* ABOVE, or 0 where there are no larger nodes */
    bool reduced;  /* phi_p */
    int threshold; /* phi_p: 255ths; 0: phi_t */
    struct slab {
        size_t counts[7]; /* faces of each direction, and cubes of the set */
        int lo[3], hi[3];
    } * slabs;
    bool fill;
};

static size_t row_of(const struct pel_cube_bits *bits, size_t y, size_t z)
{
    return (z * (size_t)bits->dims[1] + y) * bits->words;
}

/* Figure 5, lines 2 to 8: the cubes that contain the surface, and those inside it on the boundary. Those inside and not on the boundary are
 * solid, too, but have no outer face. */
static void classify_row_t(struct work *w, struct slab *slab, size_t y, size_t z)
{
    const struct pel_octree_level *n = w->nodes;
    size_t nx = (size_t)n->dims[0], at = (z * (size_t)n->dims[1] + y) * nx;
    uint64_t *row = w->set->solid.rows + row_of(&w->set->solid, y, z);
    bool edge = y == 0 || z == 0 || y == (size_t)n->dims[1] - 1 || z == (size_t)n->dims[2] - 1;
    for (size_t x = 0; x < nx; x++) {
        int class = w->table->classes[n->lo[at + x] + PEL_OCTREE_BINS * n->hi[at + x]];
        row[x / 64] |= (uint64_t)(class != PEL_CUBE_EMPTY) << x % 64;
        slab->counts[6] += class == PEL_CUBE_MIXED || (class == PEL_CUBE_FULL && (edge || x == 0 || x == nx - 1));
    }
}

/* Cubes below a node of the octree that is empty need not be looked at. */
static void classify_row_p(struct work *w, size_t y, size_t z)
{
    const struct pel_octree_level *n = w->nodes, *above = w->above;
    size_t nx = (size_t)n->dims[0], at = (z * (size_t)n->dims[1] + y) * nx;
    size_t row_above = ((z >> w->shift) * (size_t)above->dims[1] + (y >> w->shift)) * (size_t)above->dims[0];
    uint64_t *row = w->set->solid.rows + row_of(&w->set->solid, y, z);
    uint8_t *opacity = w->set->opacity + at;
    memset(opacity, 0, nx);
    for (size_t parent = 0; parent < (size_t)above->dims[0]; parent++) {
        size_t end = (parent + 1) << w->shift < nx ? (parent + 1) << w->shift : nx;
        if (w->table->classes[above->lo[row_above + parent] + PEL_OCTREE_BINS * above->hi[row_above + parent]] == PEL_CUBE_EMPTY)
            continue;
        for (size_t x = parent << w->shift; x < end; x++) {
            int lo = n->lo[at + x], hi = n->hi[at + x], middle = (lo + hi) / 2;
            uint8_t least = w->table->opacity[w->reduced ? lo + PEL_OCTREE_BINS * hi : middle + PEL_OCTREE_BINS * middle];
            bool opaque = least >= w->threshold;
            opacity[x] = opaque ? least : 0;
            row[x / 64] |= (uint64_t)opaque << x % 64;
        }
    }
}

static void classify_slab(void *context, size_t z, int thread)
{
    (void)thread;
    struct work *w = context;
    struct pel_cube_bits *bits = &w->set->solid;
    memset(bits->rows + row_of(bits, 0, z), 0, bits->words * (size_t)bits->dims[1] * sizeof *bits->rows);
    for (size_t y = 0; y < (size_t)bits->dims[1]; y++) {
        if (w->threshold)
            classify_row_p(w, y, z);
        else
            classify_row_t(w, &w->slabs[z], y, z);
    }
}

/* ---- their outer faces ---- */

/* The word of a row that may lie outside; outside nothing is solid. */
static uint64_t word_at(const struct pel_cube_bits *bits, size_t word, int y, int z)
{
    if (y < 0 || z < 0 || y >= bits->dims[1] || z >= bits->dims[2] || word >= bits->words)
        return 0;
    return bits->rows[row_of(bits, (size_t)y, (size_t)z) + word];
}

/* The cubes of a word whose neighbour in a direction is not solid. */
static uint64_t outer(const struct pel_cube_bits *b, size_t word, int y, int z, int direction)
{
    uint64_t own = word_at(b, word, y, z), there;
    switch (direction) {
    case 0:
        there = own << 1 | (word ? word_at(b, word - 1, y, z) >> 63 : 0);
        break;
    case 1:
        there = own >> 1 | word_at(b, word + 1, y, z) << 63;
        break;
    case 2:
    case 3:
        there = word_at(b, word, y + (direction == 2 ? -1 : 1), z);
        break;
    default:
        there = word_at(b, word, y, z + (direction == 4 ? -1 : 1));
    }
    return own & ~there;
}

/* Counts or writes the faces of some cubes of a word: runs where the faces lie side by side. */
static void take_faces(const struct work *w, uint64_t cubes, size_t x, int y, int z, int direction, size_t *at)
{
    while (cubes) {
        int start = __builtin_ctzll(cubes), length = 1;
        uint64_t rest = cubes >> start;
        if (direction >= 2)
            length = ~rest ? __builtin_ctzll(~rest) : LONGEST_RUN;
        if (w->fill)
            w->set->faces[*at] = (struct pel_cube_face) { (uint32_t)(x + (size_t)start) | (uint32_t)y << 16,
                                                          (uint32_t)z | (uint32_t)direction << 16 | (uint32_t)length << 19 };
        (*at)++;
        cubes = length == LONGEST_RUN ? 0 : cubes & ~((((uint64_t)1 << length) - 1) << start);
    }
}

static void extend(struct slab *slab, uint64_t cubes, int x, int y, int z)
{
    const int least[3] = { x + __builtin_ctzll(cubes), y, z }, end[3] = { x + 64 - __builtin_clzll(cubes), y + 1, z + 1 };
    for (int a = 0; a < 3; a++) {
        slab->lo[a] = least[a] < slab->lo[a] ? least[a] : slab->lo[a];
        slab->hi[a] = end[a] > slab->hi[a] ? end[a] : slab->hi[a];
    }
}

static void faces_of_slab(void *context, size_t z, int thread)
{
    (void)thread;
    struct work *w = context;
    const struct pel_cube_bits *bits = &w->set->solid;
    struct slab *slab = &w->slabs[z];
    for (int y = 0; y < bits->dims[1]; y++)
        for (size_t word = 0; word < bits->words; word++) {
            uint64_t own = word_at(bits, word, y, (int)z), any = 0;
            if (!own)
                continue;
            for (int d = 0; d < 6; d++) {
                uint64_t cubes = outer(bits, word, y, (int)z, d);
                any |= cubes;
                take_faces(w, cubes, word * 64, y, (int)z, d, &slab->counts[d]);
            }
            if (!w->fill)
                extend(slab, own, (int)word * 64, y, (int)z);
            if (!w->fill && w->threshold)
                slab->counts[6] += (size_t)__builtin_popcountll(any);
        }
}

/* From how many faces each slab has to where they begin; the box of all. */
static void sum_up(struct work *w)
{
    struct pel_cube_set *set = w->set;
    size_t slabs = (size_t)set->solid.dims[2], at = 0;
    set->cubes = 0;
    for (int a = 0; a < 3; a++)
        set->lo[a] = set->hi[a] = 0;
    bool any = false;
    for (size_t z = 0; z < slabs; z++) {
        const struct slab *s = &w->slabs[z];
        set->cubes += s->counts[6];
        if (s->hi[0] <= s->lo[0])
            continue;
        for (int a = 0; a < 3; a++) {
            set->lo[a] = !any || s->lo[a] < set->lo[a] ? s->lo[a] : set->lo[a];
            set->hi[a] = !any || s->hi[a] > set->hi[a] ? s->hi[a] : set->hi[a];
        }
        any = true;
    }
    for (int d = 0; d < 6; d++) {
        set->first[d] = at;
        for (size_t z = 0; z < slabs; z++) {
            size_t count = w->slabs[z].counts[d];
            w->slabs[z].counts[d] = at;
            at += count;
        }
    }
    set->first[6] = at;
}

static bool reserve(struct pel_cube_set *set, const struct pel_octree_level *nodes, bool opacity, struct pel_error *error)
{
    struct pel_cube_bits *bits = &set->solid;
    if (bits->rows && !memcmp(bits->dims, nodes->dims, sizeof bits->dims))
        return true;
    size_t slabs = (size_t)nodes->dims[2], rows = (size_t)nodes->dims[1] * slabs;
    pel_cubes_finish(set);
    bits->words = ((size_t)nodes->dims[0] + 63) / 64;
    bits->rows = pel_alloc_aligned(bits->words * rows, sizeof *bits->rows, "cubes", error);
    set->scratch = pel_alloc_aligned(slabs, sizeof(struct slab), "cubes", error);
    if (opacity)
        set->opacity = pel_alloc_aligned((size_t)nodes->dims[0] * rows, 1, "cubes", error);
    if (!bits->rows || !set->scratch || (opacity && !set->opacity)) {
        pel_cubes_finish(set);
        return false;
    }
    memcpy(bits->dims, nodes->dims, sizeof bits->dims);
    return true;
}

static bool extract(struct work *w, const struct pel_octree *octree, int level, int threads, struct pel_error *error)
{
    struct pel_cube_set *set = w->set;
    w->nodes = &octree->levels[level];
    w->above = &octree->levels[level + ABOVE < PEL_OCTREE_LEVELS ? level + ABOVE : level];
    w->shift = level + ABOVE < PEL_OCTREE_LEVELS ? ABOVE : 0;
    if (!reserve(set, w->nodes, w->threshold > 0, error))
        return false;
    size_t slabs = (size_t)set->solid.dims[2], cubes = slabs * (size_t)set->solid.dims[1] * (size_t)set->solid.dims[0];
    set->level = level;
    if (cubes < CUBES_A_THREAD)
        threads = 1;
    w->slabs = (struct slab *)(void *)set->scratch;
    for (size_t z = 0; z < slabs; z++)
        w->slabs[z] = (struct slab) { .lo = { 1 << 30, 1 << 30, 1 << 30 } };
    pel_parallel_for(threads, slabs, classify_slab, w);
    pel_parallel_for(threads, slabs, faces_of_slab, w);
    sum_up(w);
    if (set->first[6] > set->room) {
        free(set->faces);
        set->room = 0;
        set->faces = pel_alloc_aligned(set->first[6] + set->first[6] / 4, sizeof *set->faces, "faces of cubes", error);
        if (!set->faces)
            return false;
        set->room = set->first[6] + set->first[6] / 4;
    }
    w->fill = true;
    pel_parallel_for(threads, slabs, faces_of_slab, w);
    return true;
}

bool pel_cubes_extract_t(struct pel_cube_set *set, const struct pel_octree *octree, const struct pel_cube_table *table, int level,
                         int threads, struct pel_error *error)
{
    struct work w = { .set = set, .table = table };
    return extract(&w, octree, level, threads, error);
}

bool pel_cubes_extract_p(struct pel_cube_set *set, const struct pel_octree *octree, const struct pel_cube_table *table, int level,
                         double threshold, bool reduced, int threads, struct pel_error *error)
{
    int least = (int)ceil(threshold * 255);
    struct work w = { .set = set, .table = table, .reduced = reduced, .threshold = least > 1 ? least : 1 };
    return extract(&w, octree, level, threads, error);
}

void pel_cubes_finish(struct pel_cube_set *set)
{
    free(set->solid.rows);
    free(set->faces);
    free(set->opacity);
    free(set->scratch);
    memset(set, 0, sizeof *set);
}

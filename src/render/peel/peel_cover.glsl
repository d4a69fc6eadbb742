// SPDX-License-Identifier: MIT
// Section 4.2: an active cell's place in the masks, and the pixels on to which it can project.
#include "job.glsl"
#include "peel_block.glsl"
#include "histopyramid.glsl"

// By how much a cell is enlarged, in voxels: more than rounding moves rays and eye, and texture units samples (1/256). How near to the eye, in voxels, a cell counts as around it.
const float GROWN = 6e-3, AROUND = 2e-2;
const float MARGIN = 0.02; // pixels; rasterisers round to 1/256

struct Cover {
    vec4 bound; // least and greatest pixel of the tile, inclusive, as numbers that are not whole
    vec3 disc;  // middle and radius, pixels of the tile
    int layer;
    uint bit;
};

ivec3 cell_of(uint item)
{
    uint row = item / uint(peel.grid.x);
    return ivec3(item - row * uint(peel.grid.x), row % uint(peel.grid.y), row / uint(peel.grid.y));
}

// seq_cell, flipped where the camera looks down the axis, its slab and its bit there.
void place_of(ivec3 cell, inout Cover cover)
{
    int sequence = cell[peel.major.x];
    if (peel.major.y < 0)
        sequence = peel.major.z - 1 - sequence;
    cover.layer = sequence / peel.major.w;
    cover.bit = 1u << (sequence % peel.major.w);
}

// Pixel times w, and w.
vec3 project(vec3 index)
{
    vec3 q = index - peel.from.xyz;
    return vec3(dot(peel.to_pixel[0].xyz, q) + peel.to_pixel[0].w, dot(peel.to_pixel[1].xyz, q) + peel.to_pixel[1].w,
                dot(peel.to_pixel[2].xyz, q) + peel.to_pixel[2].w);
}

void enclose(inout vec4 bound, vec2 pixel)
{
    bound = vec4(min(bound.xy, pixel), max(bound.zw, pixel));
}

// What of the box lies before the eye: its corners there, and its edges' ends at the least w. Gives whether all of the box does.
bool bound_of(vec3 corners[8], out vec4 bound)
{
    bool whole = true;
    bound = vec4(1e30, 1e30, -1e30, -1e30);
    for (int i = 0; i < 8; i++) {
        if (corners[i].z < peel.from.w) {
            whole = false;
            continue;
        }
        enclose(bound, corners[i].xy / corners[i].z);
        for (int a = 0; a < 3; a++) {
            vec3 other = corners[i ^ (1 << a)];
            if (other.z < peel.from.w)
                enclose(bound, mix(other.xy, corners[i].xy, (peel.from.w - other.z) / (corners[i].z - other.z)) / peel.from.w);
        }
    }
    return whole;
}

// False where no pixel of the tile shows the cell.
bool cover_of(uint item, out Cover cover)
{
    ivec3 cell = cell_of(item);
    place_of(cell, cover);
    vec2 size = vec2(peel.tile.zw);
    vec3 lo = max(vec3(cell * peel.grid.w), job.box_lo.xyz), hi = min(vec3((cell + 1) * peel.grid.w), job.box_hi.xyz);
    lo = mix(lo, job.box_lo.xyz, equal(cell, ivec3(0))) - GROWN; // half a voxel more where there is one alone
    hi += GROWN;
    bool parallel = peel.to_pixel[2].w != 0.0;
    cover.bound = vec4(0.0, 0.0, size - 1.0);
    cover.disc = vec3(0.5 * size, length(size));
    if (!parallel && all(lessThan(lo - AROUND, peel.from.xyz)) && all(greaterThan(hi + AROUND, peel.from.xyz)))
        return true; // the eye is in it
    vec3 corners[8];
    for (int i = 0; i < 8; i++)
        corners[i] = project(mix(lo, hi, bvec3((i & 1) != 0, (i & 2) != 0, (i & 4) != 0)));
    vec4 bound;
    bool whole = bound_of(corners, bound);
    vec2 first = vec2(peel.tile.xy), middle = 0.5 * (bound.xy + bound.zw);
    if (bound.x > bound.z)
        return false;
#ifdef DISC
    float radius = 0.5 * length(bound.zw - bound.xy);
    if (whole) {
        radius = 0.0;
        for (int i = 0; i < 8; i++)
            radius = max(radius, distance(middle, corners[i].xy / corners[i].z));
    }
    radius += MARGIN;
    cover.disc = vec3(middle - first, radius);
    bound = vec4(middle - radius, middle + radius);
#endif
    bound = vec4(bound.xy - MARGIN - first, bound.zw + MARGIN - first);
    cover.bound = vec4(max(bound.xy, vec2(-0.25)), min(bound.zw, size - 0.75));
    return all(lessThanEqual(ceil(cover.bound.xy), floor(cover.bound.zw))); // there is a pixel's middle in it
}

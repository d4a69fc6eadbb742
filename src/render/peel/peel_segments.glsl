// SPDX-License-Identifier: MIT
// Section 4.3.1: from masks to the stretches of a ray in which a surface may be, near to far, with depths in 32-bit float.
layout(binding = 5) uniform usampler2DArray masks;
layout(binding = 6) uniform usampler2D mask_table; // of each mask of 16 bits: runs of set bits, where they start and where they end, four bits each (peel.c)

// How far a stretch reaches beyond the voxel-slices that border it, in voxels: more than rounding moves them, and texture units samples (1/256).
const float BEYOND = 8e-3;

float depth0, delta_depth;  // of voxel-slice 0, and between two, in steps along the ray
float beyond;               // BEYOND in steps
int slab, last_slab, onward; // the next one; the last one; 1, or -1 where this ray goes down the major axis though the optical axis goes up it, or the other way round
uvec3 runs;                 // of the present slab's mask, as the table tells
int left, before;           // runs of it that are still to come; cell-slices of the slabs before it
uint segments;              // stretches given so far

uint mask_of(ivec2 pixel, int slab)
{
    int first = 16 * slab, layer = first / peel.major.w;
    return texelFetch(masks, ivec3(pixel - peel.tile.xy, layer), 0).r >> (first - layer * peel.major.w) & 0xffffu;
}

// The slab of a place along the ray.
int slab_at(const Ray r, float at)
{
    int slice = int(clamp(floor((at - depth0) / delta_depth), 0.0, float(peel.major.z - 1)));
    return (peel.major.y < 0 ? peel.major.z - 1 - slice : slice) >> 4;
}

void segments_begin(const Ray r)
{
    int axis = peel.major.x;
    float inverse = r.inverse[axis], most = float(r.n);
    depth0 = (job.box_lo[axis] - r.o[axis]) * inverse;
    delta_depth = float(peel.grid.w) * inverse;
    beyond = BEYOND * abs(inverse);
    onward = (inverse < 0.0) == (peel.major.y < 0) ? 1 : -1; // the paper's rays all go one way; in a wide view some do not
    slab = slab_at(r, -beyond);
    last_slab = slab_at(r, most + beyond);
    left = 0;
    segments = 0u;
}

// A run of cell-slices, from the nearest to the farthest, flipped and offset to the voxel-slices that border it (figure 5), and their depths (equation 1).
vec2 depths_of(int start, int end)
{
    ivec2 voxel_slices = peel.major.y < 0 ? ivec2(peel.major.z - start, peel.major.z - 1 - end) : ivec2(start, end + 1);
    vec2 depths = depth0 + vec2(voxel_slices) * delta_depth;
    return vec2(min(depths.x, depths.y) - beyond, max(depths.x, depths.y) + beyond);
}

#ifdef EXTERIOR
// Interior skipping off (section 6.2): one stretch, from the first layer to the last.
bool next_segment(ivec2 pixel, const Ray r, out vec2 stretch)
{
    int first = 1 << 30, last = -1;
    for (; onward * slab <= onward * last_slab; slab += onward) {
        uint mask = mask_of(pixel, slab);
        if (mask != 0u) {
            first = min(first, 16 * slab + findLSB(mask));
            last = max(last, 16 * slab + findMSB(mask));
        }
    }
    stretch = depths_of(first, last);
    if (last >= 0)
        segments = 1u;
    slab = last_slab + onward;
    return last >= 0;
}
#else
bool next_segment(ivec2 pixel, const Ray r, out vec2 stretch)
{
    while (left == 0) {
        if (onward * slab > onward * last_slab)
            return false;
        uint mask = mask_of(pixel, slab);
        runs = texelFetch(mask_table, ivec2(mask & 255u, mask >> 8), 0).rgb;
        left = int(runs.r);
        before = 16 * slab;
        slab += onward;
    }
    int run = 4 * (onward > 0 ? int(runs.r) - left : left - 1);
    left--;
    stretch = depths_of(before + int(runs.g >> run & 15u), before + int(runs.b >> run & 15u));
    segments++;
    return true;
}
#endif

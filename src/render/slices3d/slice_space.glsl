// SPDX-License-Identifier: MIT
// Where slices lie. A slice is a plane of constant depth along the view axis, so it is parallel to the picture. Depth is counted in slices: s = 0 where the box begins, and slice i lies in
// the middle of its slab, at s = i + 1/2. The z-buffer holds s over the number of slices: linear, in perspective too, and slices are compared with the cubes' faces exactly.
layout(std140, binding = 1) uniform SliceBlock {
    vec4 clip_x, clip_y, clip_w; // clip coordinates of an index position p: dot(xyz, p) + w
    vec4 depth;                  // its view depth, likewise
    vec4 range;                  // view depth where slices begin, their distance, how many there are, and 1 over that
    vec4 lo, hi;                 // the box that slices are cut from, index space
    vec4 eye;                    // w: 1 for an eye at xyz, 0 for parallel rays along xyz; index space
    vec4 inflate;                // by which cubes of phi_t grow to each side, index space; w: more slices to each side of them
    ivec4 cubes;                 // of phi_p along each axis; w: voxels along an edge
    vec4 walk;                   // transparency that counts as none; slices to look for it
} slices;

float slices_at(float view_depth)
{
    return (view_depth - slices.range.x) / slices.range.y;
}

float on_plane(vec4 plane, vec3 p)
{
    return dot(plane.xyz, p) + plane.w;
}

// A pixel's ray by view depth: index position, index direction of a unit of depth, and that unit's world length, 1 / cos of the angle to the view axis.
struct SliceRay {
    vec3 o, d;
    float world;
};

SliceRay slice_ray(ivec2 pixel)
{
    vec2 at = vec2(pixel);
    SliceRay r;
    r.d = job.d0.xyz + at.x * job.dx.xyz + at.y * job.dy.xyz;
    r.o = job.p0.xyz + at.x * job.px.xyz + at.y * job.py.xyz + (slices.range.x - job.ray.x) * r.d;
    r.world = length(job.w0.xyz + at.x * job.wx.xyz + at.y * job.wy.xyz);
    return r;
}

vec3 place_on(const SliceRay r, float s)
{
    return clamp(r.o + s * slices.range.y * r.d, job.box_lo.xyz, job.box_hi.xyz);
}

// The slab that a slice stands for, cut at the ray's stretch in the box and the clip planes: the ends of the stretch belong to its first and its last slice, so that a homogeneous medium
// is exact at any distance of slices.
vec2 slab_ends(float s, vec2 stretch)
{
    return vec2(s - 1.0 < stretch.x ? stretch.x : s - 0.5, s + 1.0 > stretch.y ? stretch.y : s + 0.5);
}

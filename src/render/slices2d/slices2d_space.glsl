// SPDX-License-Identifier: MIT
// Object-aligned slices (paper 003: Rezk-Salama, Engel, Bauer, Greiner and Ertl 2000): the space of a stack, and rays in it.
//
// Section 4: the volume is a stack of slices along the axis that the view goes along most, so that "trilinear by bilinear interpolation" can be
// replaced. Stack space has that axis last: (u, v, k), in voxels. Slice m, counted front to back, lies at k = first + m step; step is 1 between slices
// of voxels, or 1/supersampling with intermediate slices (section 5), and negative where the view goes against the axis.
// A ray meets slice m at (u, v) = at + m by: the shear that OpenGL's matrices hide in the paper ("this factorization is not coded explicitly").
#if AXIS == 0
#define TO_STACK yzx
#define FROM_STACK zxy
#elif AXIS == 1
#define TO_STACK xzy
#define FROM_STACK xzy
#else
#define TO_STACK xyz
#define FROM_STACK xyz
#endif

layout(std140, binding = 1) uniform SliceBlock {
    vec4 stack;         // first, step; the slice that the eye is in (parallel: far before the first); how many slices there are
    ivec4 polygons;     // slices a polygon; number of the first slice; 1 where several stacks share the picture; 1 where the view goes down the axis
    vec4 eye;           // perspective: where the eye is, stack space; parallel: how far rays move from slice to slice
    vec4 to_picture[3]; // rows of the matrix from stack space to pixels: x w, y w, w
    vec4 rules;         // by how many voxels polygons are enlarged for rounding; 1: perspective; slab: slices before and behind a slice's own place
    vec4 ambient;       // section 8 (a): the global ambient colour
} slices;

struct SliceRay {
    vec2 at, by;      // (u, v) at slice 0, and from slice to slice
    float from, to;   // the slices between which it runs inside the box, the clip planes and before the eye; not whole
    float steps;      // from slice to slice, in the job's steps
    float base, each; // along the ray, in units of D (job.glsl): slice 0, and from slice to slice
    float world;      // length of D
};

// Narrows the stretch to where value + m slope >= 0.
void slice_cut(inout SliceRay r, float value, float slope)
{
    if (abs(slope) < 1e-7) { // alongside: in or out as a whole
        if (value < -1e-4)
            r.to = -1e9;
    } else if (slope > 0.0) {
        r.from = max(r.from, -value / slope);
    } else {
        r.to = min(r.to, -value / slope);
    }
}

// The ray of the fragment's pixel; false where it misses, or where it belongs to another stack. r.d is set for shading.
bool slice_ray(vec2 pixel, out SliceRay s, out Ray r)
{
    vec3 p = job.p0.xyz + pixel.x * job.px.xyz + pixel.y * job.py.xyz, d = job.d0.xyz + pixel.x * job.dx.xyz + pixel.y * job.dy.xyz;
    vec3 w = job.w0.xyz + pixel.x * job.wx.xyz + pixel.y * job.wy.xyz;
    if (slices.polygons.z != 0) { // a picture so wide that rays are nearest to different axes: each goes through its own stack
        int nearest = 0;
        for (int a = 1; a < 3; a++)
            if (abs(d[a]) > abs(d[nearest]))
                nearest = a;
        if (nearest != AXIS)
            return false;
    }
    p = p.TO_STACK;
    s.world = length(w);
    r.d = d * (job.ray.z / s.world);
    d = d.TO_STACK;
    s.each = slices.stack.y / d.z;
    if (!(s.each > 0.0) || isinf(s.each))
        return false;
    s.base = (slices.stack.x - p.z) / d.z;
    s.by = s.each * d.xy;
    s.at = p.xy + s.base * d.xy;
    s.steps = s.each * s.world / job.ray.z;
    vec3 lo = job.box_lo.xyz.TO_STACK, hi = job.box_hi.xyz.TO_STACK;
    float a = (lo.z - slices.stack.x) / slices.stack.y, b = (hi.z - slices.stack.x) / slices.stack.y;
    s.from = max(min(a, b), slices.stack.z);
    s.to = max(a, b);
    for (int i = 0; i < 2; i++) {
        slice_cut(s, s.at[i] - lo[i], s.by[i]);
        slice_cut(s, hi[i] - s.at[i], -s.by[i]);
    }
    for (int i = 0; i < job.picture.z; i++) {
        vec4 plane = vec4(job.planes[i].xyz.TO_STACK, job.planes[i].w) / job.ray.z;
        slice_cut(s, dot(plane.xyz, vec3(s.at, slices.stack.x)) + plane.w, dot(plane.xyz, vec3(s.by, slices.stack.y)));
    }
    return s.from < s.to;
}

// Where the ray meets slice m. Equation 2 moves texture coordinates by d v_x / v_y for a slice d behind the polygon: m by, exactly and for each fragment.
vec3 slice_place(const SliceRay s, float m)
{
    return vec3(s.at + max(m, slices.stack.z + 1e-6) * s.by, slices.stack.x + m * slices.stack.y);
}

// World distance along the ray.
float slice_distance(const SliceRay s, float m)
{
    return (s.base + m * s.each + job.ray.x) * s.world;
}

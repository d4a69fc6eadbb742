// SPDX-License-Identifier: MIT
// A slice's polygon: where a plane of constant view depth cuts the box, 3 to 6 vertices, made here (figure 1; after Rezk-Salama and Kolb, A Vertex Program for Efficient Box-Plane
// Intersection, 2005). An instance is a slice, and its six vertices are a fan; those that the plane has no use for fall together.
//
// From the corner nearest to the eye three paths of three edges lead to the farthest one; the plane cuts each once: vertices 0, 2 and 4. Between them lie three more edges, which it may cut.
#include "job.glsl"
#include "slice_space.glsl"
layout(location = 0) uniform ivec4 run; // the first slice; 1 or -1: front to back or back to front
flat out int slice;
// On a slice a pixel's place is linear in the pixel: place + x place_x + y place_y. So is the way to the next slice. (A software GPU takes such constants four times as fast as uniforms.)
flat out vec3 place, place_x, place_y, way, way_x, way_y;

// The box' corner: bits of `which` are the axes along which it lies on the far side.
vec3 corner(int which)
{
    bvec3 far = bvec3((which & 1) != 0, (which & 2) != 0, (which & 4) != 0), rising = greaterThanEqual(slices.depth.xyz, vec3(0.0));
    return mix(slices.lo.xyz, slices.hi.xyz, equal(far, rising));
}

vec3 cut(vec3 a, vec3 b, float z)
{
    float from = on_plane(slices.depth, a), to = on_plane(slices.depth, b);
    return mix(a, b, clamp((z - from) / max(to - from, 1e-30), 0.0, 1.0));
}

vec3 cut_path(int a, int b, float z)
{
    vec3 near = corner(0), second = corner(a), third = corner(b);
    if (z <= on_plane(slices.depth, second))
        return cut(near, second, z);
    return z <= on_plane(slices.depth, third) ? cut(second, third, z) : cut(third, corner(7), z);
}

vec3 polygon(int vertex, float z)
{
    const int firsts[3] = int[](1, 2, 4), seconds[3] = int[](5, 3, 6), between[3] = int[](3, 6, 5);
    int path = vertex >> 1;
    if ((vertex & 1) != 0) { // the edge from the path's second corner towards the next path
        vec3 a = corner(firsts[path]), b = corner(between[path]);
        if (z > on_plane(slices.depth, a) && z < on_plane(slices.depth, b))
            return cut(a, b, z);
    }
    return cut_path(firsts[path], seconds[path], z);
}

void main()
{
    slice = run.x + run.y * gl_InstanceID;
    float s = float(slice) + 0.5;
    vec3 p = polygon(gl_VertexID, slices.range.x + s * slices.range.y);
    float beyond = slices.range.x + s * slices.range.y - job.ray.x; // depth behind the rays' starting points
    place = job.p0.xyz + beyond * job.d0.xyz;
    place_x = job.px.xyz + beyond * job.dx.xyz;
    place_y = job.py.xyz + beyond * job.dy.xyz;
    way = slices.range.y * job.d0.xyz;
    way_x = slices.range.y * job.dx.xyz;
    way_y = slices.range.y * job.dy.xyz;
    float w = on_plane(slices.clip_w, p);
    gl_Position = vec4(on_plane(slices.clip_x, p), on_plane(slices.clip_y, p), (2.0 * s * slices.range.w - 1.0) * w, w);
}

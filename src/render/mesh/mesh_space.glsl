// SPDX-License-Identifier: MIT
// How a surface is projected, and the lists in which each pixel gathers what is translucent.
layout(std140, binding = 1) uniform MeshBlock {
    vec4 clip_x, clip_y, clip_z, clip_w; // clip coordinates of an index position p: dot(xyz, p) + w
    vec4 depth;                          // its view depth, likewise; the world distance along a pixel's ray is as many times the length of its Dw
    vec4 from_z;                         // view depth = x + y z in parallel, x / z in perspective, z being what the z-buffer holds
    uvec4 room;                          // fragments that the lists hold; 1 in perspective
} mesh;

float on_plane(vec4 plane, vec3 p)
{
    return dot(plane.xyz, p) + plane.w;
}

// World length of a unit of view depth along a pixel's ray.
float world_length(vec2 pixel)
{
    return length(job.w0.xyz + pixel.x * job.wx.xyz + pixel.y * job.wy.xyz);
}

#ifdef LISTS
const uint END_OF_LIST = 0xffffffffu;
layout(std430, binding = 0) LISTS buffer ListHeads { uint list_count, list_padding[3], list_head[]; }; // fragments so far, also of those beyond the room; the last of each pixel
layout(std430, binding = 1) LISTS buffer ListLinks { uvec2 list_link[]; };                            // the pixel's fragment before, or the end; number of the surface
layout(std430, binding = 7) LISTS buffer ListNodes { vec4 list_node[]; };                             // premultiplied colour; view depth
#endif

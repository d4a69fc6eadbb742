// SPDX-License-Identifier: MIT
// A fragment of a surface, lit as everywhere. An opaque one goes through the z-buffer into the picture; with LIST a translucent one that the opaque ones do not hide joins its pixel's list.
#ifdef LIST
#define LISTS
#endif
#include "job.glsl"
#include "space.glsl"
#include "shading.glsl"
#include "mesh_space.glsl"
in vec3 place, slope;
layout(location = 0) uniform int surface; // by rising isovalue
#ifdef LIST
layout(early_fragment_tests) in;
#else
layout(location = 0) out vec4 color;
#endif

void main()
{
    for (int i = 0; i < job.picture.z; i++)
        if (on_plane(job.planes[i], place) < 0.0)
            discard;
    vec2 pixel = gl_FragCoord.xy - 0.5;
    float alpha = job.iso[surface].y;
    Ray r;
    r.d = (job.d0.xyz + pixel.x * job.dx.xyz + pixel.y * job.dy.xyz) * (job.ray.z / world_length(pixel)); // a step
    vec3 lit = shade(r, slope, alpha, alpha * job.iso_color[surface].rgb);
#ifdef LIST
    uint node = atomicAdd(list_count, 1u);
    if (node < mesh.room.x) {
        uint before = atomicExchange(list_head[uint(gl_FragCoord.y) * uint(job.picture.x) + uint(gl_FragCoord.x)], node);
        list_link[node] = uvec2(before, surface);
        list_node[node] = vec4(lit, on_plane(mesh.depth, place));
    }
#else
    color = vec4(lit, alpha);
#endif
}

// SPDX-License-Identifier: MIT
// World distance of a pixel's first surface: from the z-buffer, and with LIST from what its list holds.
#ifdef LIST
#define LISTS readonly
#endif
#include "job.glsl"
#include "mesh_space.glsl"
layout(binding = 9) uniform sampler2D z_buffer;
layout(location = 0) out float distance_along;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float z = texelFetch(z_buffer, pixel, 0).r, depth = uintBitsToFloat(0x7f800000u);
    if (z > 0.0)
        depth = mesh.room.y != 0u ? mesh.from_z.x / z : mesh.from_z.x + mesh.from_z.y * z;
#ifdef LIST
    for (uint node = list_head[uint(pixel.y) * uint(job.picture.x) + uint(pixel.x)]; node != END_OF_LIST; node = list_link[node].x)
        depth = min(depth, list_node[node].w);
#endif
    distance_along = depth * world_length(vec2(pixel));
}

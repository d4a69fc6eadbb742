// SPDX-License-Identifier: MIT
// World distance of a pixel's first surface: from the z-buffer, and with LIST from what its list holds.
#ifdef LIST
#define LISTS readonly
#endif
#include "job.glsl"
#include "mesh_space.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 9) uniform sampler2D z_buffer;
layout(r32f, binding = 0) writeonly uniform image2D distances;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= job.picture.x || pixel.y >= job.picture.y)
        return;
    float z = texelFetch(z_buffer, pixel, 0).r, depth = uintBitsToFloat(0x7f800000u);
    if (z > 0.0)
        depth = mesh.room.y != 0u ? mesh.from_z.x / z : mesh.from_z.x + mesh.from_z.y * z;
#ifdef LIST
    for (uint node = list_head[uint(pixel.y * job.picture.x + pixel.x)]; node != END_OF_LIST; node = list_link[node].x)
        depth = min(depth, list_node[node].w);
#endif
    imageStore(distances, pixel, vec4(depth * world_length(vec2(pixel))));
}

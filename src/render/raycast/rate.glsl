// SPDX-License-Identifier: MIT
// No picture but a measure: every sample of the frame's rays from the volume's texture, trilinear, and nothing else. What a ray caster takes a second is held to it.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"

layout(local_size_x = 64) in; // 8x8 pixels, as march.glsl's
layout(rgba32f, binding = 0) writeonly uniform image2D picture;
layout(std430, binding = 2) buffer Counters { uvec2 taken, in_box; };

void main()
{
    int lane = int(gl_LocalInvocationIndex);
    ivec2 pixel = ivec2(gl_WorkGroupID.xy) * 8 + ivec2((lane & 3) | (lane >> 1 & 4), (lane >> 2 & 1) | (lane >> 3 & 6));
    Ray r;
    if (any(greaterThanEqual(pixel, job.picture.xy)) || !ray_of(pixel, r))
        return;
    vec3 scale = 1.0 / vec3(TEXTURE_SIZE), at = (r.o + r.offset * r.d + 0.5 - vec3(FIRST_VOXEL)) * scale, step = r.d * scale;
    float sum = 0.0;
    for (int k = 0; k < r.n; k++)
        sum += textureLod(volume, at + float(k) * step, 0.0).r;
    imageStore(picture, pixel, vec4(sum)); // so that nothing may be left out
    if (atomicAdd(taken.x, uint(r.n)) > 0xffffffffu - uint(r.n))
        atomicAdd(taken.y, 1u);
}

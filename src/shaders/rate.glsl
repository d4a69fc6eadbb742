// SPDX-License-Identifier: MIT
// No picture but a measure: every sample of the frame's rays from the volume's texture, trilinear, and nothing else. What a ray caster takes a second is held to it.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"

#include "tile.glsl"
layout(rgba32f, binding = 0) writeonly uniform image2D picture;

void main()
{
    ivec2 pixel = pixel_of();
    Ray r;
    if (any(greaterThanEqual(pixel, job.picture.xy)) || !ray_of(pixel, r))
        return;
    vec3 scale = 1.0 / vec3(TEXTURE_SIZE), at = (r.o + r.offset * r.d + 0.5 - vec3(FIRST_VOXEL)) * scale, step = r.d * scale;
    float sum = 0.0;
    for (int k = 0; k < r.n; k++)
        sum += textureLod(volume, at + float(k) * step, 0.0).r;
    imageStore(picture, pixel, vec4(sum)); // so that nothing may be left out
    COUNT_TAKEN(uint(r.n))
}

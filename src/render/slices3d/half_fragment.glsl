// SPDX-License-Identifier: MIT
// Depth: where the ray has gathered half its opacity. Blending does not tell, so a pixel follows its own slabs, unshaded, up to there; only where the picture says that there is such a place.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "classified.glsl"
#include "integrals.glsl"
#include "slice_space.glsl"
#include "slab.glsl"
layout(binding = 9) uniform sampler2D picture;
layout(location = 0) out vec4 depth;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 stretch = texelFetch(stretches, pixel, 0);
    SliceRay ray = slice_ray(pixel);
    float found = uintBitsToFloat(0x7f800000u), gathered = 0.0;
    int k = int(clamp(ceil(stretch.x - 0.5), 0.0, slices.range.z)), end = texelFetch(picture, pixel, 0).a >= 0.4999 ? int(min(floor(stretch.y + 0.5), slices.range.z)) : 0;
    for (; k < end && gathered < 0.5; k++) {
        float s = float(k) + 0.5;
        gathered += (1.0 - gathered) * slab_color(place_on(ray, s), slices.range.y * ray.d, slab_ends(s, stretch.xy) - s, ray.world).a;
        if (gathered >= 0.5)
            found = (slices.range.x + s * slices.range.y) * ray.world;
    }
    depth = vec4(found);
}

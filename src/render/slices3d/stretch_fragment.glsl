// SPDX-License-Identifier: MIT
// Once a view, for each pixel: its stretch of ray in the box, the clip box and the clip planes (docs/optics.md), in slices; where there is none, it ends before it begins. The world length of
// a unit of depth; and for a band where phi_t begins.
#include "job.glsl"
#include "space.glsl"
#include "slice_space.glsl"
#ifdef BAND
layout(binding = 8) uniform sampler2D near; // section 5's second z-buffer
#endif
layout(location = 0) out vec4 stretch;

void main()
{
    Ray r;
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    bool met = ray_of(pixel, r);
    float world = slice_ray(pixel).world, from = slices_at(r.entry / world), to = from + (float(r.n - 1) + r.fraction) / world;
    stretch = met ? vec4(from, to, world, 0.0) : vec4(1e9, -1e9, 1.0, 0.0);
#ifdef BAND
    stretch.w = texelFetch(near, pixel, 0).r * slices.range.z;
#endif
}

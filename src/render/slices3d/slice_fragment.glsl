// SPDX-License-Identifier: MIT
// The volume shader (section 3.5, step 3): a fragment of a slice, blended into the picture by the GPU. What the z-buffer hides never gets here.
#include "job.glsl"
#include "space.glsl"
#include "sampling.glsl"
#include "transfer.glsl"
#include "shading.glsl"
#include "classified.glsl"
#include "integrals.glsl"
#include "slice_space.glsl"
#include "slab.glsl"
flat in int slice;
flat in vec3 place, place_x, place_y, way, way_x, way_y;
layout(location = 0) out vec4 color;

void main()
{
    float s = float(slice) + 0.5;
    vec4 stretch = texelFetch(stretches, ivec2(gl_FragCoord.xy), 0);
#ifdef BAND
    if (s < stretch.w) // before phi_t
        discard;
#endif
    if (s < stretch.x || s > stretch.y) // polygons are a little too large, and the ray itself tells where its volume ends
        discard;
    vec2 at = gl_FragCoord.xy - 0.5;
    vec3 p = place + at.x * place_x + at.y * place_y, along = way + at.x * way_x + at.y * way_y;
    color = slab_color(p, along, slab_ends(s, stretch.xy) - s, stretch.z);
#ifdef EARLY_OUT
    if (color.a <= 0.0)
        discard;
#endif
#ifdef SHADE
    Ray r;
    r.d = along / stretch.z; // a step
#ifdef NEAREST
    vec3 slope = opacity_gradient(nearest_voxel(p));
#else
    vec3 slope = gradient(p);
#endif
    color.rgb = shade(r, slope, color.a, color.rgb);
#endif
}

// SPDX-License-Identifier: MIT
// Front faces of phi_p's cubes into the z-buffer (section 3.1). The paper stops the ray at the face; but a ray that only cuts a cube's edge may leave it before it meets a slice, and a threshold
// below 1 hides nothing at once. So the ray is followed through opaque cubes, slice by slice, with the least opacity that each is known to have, until no more of what lies behind can be seen;
// the z-value is that of the slice where this happens. Where it does not, the face hides nothing.
#include "job.glsl"
#include "slice_space.glsl"
layout(binding = 6) uniform sampler3D opacities; // a cube's least opacity; 0 for one that is not opaque
layout(binding = 7) uniform sampler2D stretches;
in float view_depth;
flat in int direction;

float least_opacity(vec3 p)
{
    return texelFetch(opacities, clamp(ivec3(p) / slices.cubes.w, ivec3(0), slices.cubes.xyz - 1), 0).r;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    SliceRay ray = slice_ray(pixel);
    vec2 stretch = texelFetch(stretches, pixel, 0).rg;
    int first = int(max(ceil(max(slices_at(view_depth), stretch.x) - 0.5), 0.0));
#ifdef PREINTEGRATED
    first++; // whose slab begins in the cube
#endif
    float clear = 1.0;
    for (int k = first; k < first + int(slices.walk.y) && clear > slices.walk.x; k++) {
        float s = float(k) + 0.5;
        float opacity = s > stretch.y ? 0.0 : least_opacity(place_on(ray, s));
        vec2 ends = slab_ends(s, stretch);
#ifdef PREINTEGRATED
        opacity = min(opacity, min(least_opacity(place_on(ray, ends.x)), least_opacity(place_on(ray, ends.y))));
        opacity = min(opacity, 1.0 - 1.0 / 16777216.0); // pre-integration's most
#endif
        if (opacity <= 0.0)
            break;
        clear *= pow(1.0 - opacity, max(ends.y - ends.x, 0.0) * ray.world * job.table.w);
        gl_FragDepth = min(float(k + 1) * slices.range.w, 1.0); // between this slice and the next
    }
    if (clear > slices.walk.x)
        discard;
}

// SPDX-License-Identifier: MIT
// Section 9: "the image information is obtained by interpolating the two adjacent texture images", equation 1 with an alpha that is 0 on the strip's
// side at the first slice and 1 at the second. The paper gives it to the corners and lets Gouraud shading interpolate; here it is where the fragment's ray
// meets the plane, which in perspective is exact, too.
#include "job.glsl"
#include "space.glsl"
#include "slices2d_space.glsl"
#include "slices2d_stack.glsl"
#include "transfer.glsl"
#include "plane_place.glsl"
layout(location = 0) flat in ivec2 strip; // the slice of voxels before it, its plane
layout(location = 0) out vec4 color;
#ifdef DEPTH
layout(binding = 5) uniform sampler2D so_far; // the picture that the planes before this one left
layout(r32f, binding = 1) writeonly uniform image2D depth;
#endif

void main()
{
    Ray r; // any direction: strips do not ask which way the view goes through the stack
    result = vec4(0.0);
    if (!ray_of(ivec2(gl_FragCoord.xy), r))
        discard;
    float at = plane_place(r, strip.y);
    if (at < 0.0)
        discard;
    vec3 place = clamp((r.o + at * r.d).TO_STACK, vec3(0.0), vec3(job.dims.xyz.TO_STACK - 1));
#ifdef NEAREST
    float raw = voxel(nearest_voxel(place));
#else
    float raw = intermediate(place.xy, strip.x, clamp(place.z - float(strip.x), 0.0, 1.0));
#endif
    if (isnan(raw))
        discard;
    show_value(raw, 0.0);
    color = result;
#ifdef DEPTH
    if (color.a > 0.0 && !(texelFetch(so_far, ivec2(gl_FragCoord.xy), 0).a > 0.0))
        imageStore(depth, ivec2(gl_FragCoord.xy), vec4(r.entry + at * job.ray.z));
#endif
}

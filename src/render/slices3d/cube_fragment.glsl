// SPDX-License-Identifier: MIT
// Faces of phi_t's cubes, or of the volume's box, into the z-buffer (sections 3.2 to 3.4); SHOW: coloured by where they face, for figure 9.
#include "job.glsl"
#include "slice_space.glsl"
in float view_depth;
flat in int direction;
layout(location = 1) uniform vec4 how; // slices by which the face moves; SHOW: its colour
#ifdef SHOW
layout(location = 0) out vec4 color;
#endif

void main()
{
    float s = slices_at(view_depth) + how.x;
    gl_FragDepth = clamp(s * slices.range.w, 0.0, 1.0);
#ifdef SHOW
    const vec3 light[3] = vec3[](vec3(0.75), vec3(0.9), vec3(0.6));
    color = vec4(how.yzw * light[direction >> 1] * (1.0 - 0.5 * gl_FragDepth), 1.0);
#endif
}

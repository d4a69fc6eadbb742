// SPDX-License-Identifier: MIT
// Early ray termination between slabs (Krueger and Westermann 2003; with slabs of one slice the two passes of section 2): where the opacity buffer is full, the z-value goes to where
// every later fragment fails (GREATER: with that depth test, to the back).
#include "job.glsl"
layout(binding = 9) uniform sampler2D picture;

void main()
{
    if (texelFetch(picture, ivec2(gl_FragCoord.xy), 0).a < job.gradient.z)
        discard;
#ifdef GREATER
    gl_FragDepth = 1.0;
#else
    gl_FragDepth = 0.0;
#endif
}

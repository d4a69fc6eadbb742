// SPDX-License-Identifier: MIT
// The simple shader of section 2: nothing but the tests. It counts fragments, and its time is T_s.
#include "job.glsl"
#include "slice_space.glsl"
#ifdef BAND
layout(binding = 7) uniform sampler2D stretches;
#endif
flat in int slice;
layout(location = 0) out vec4 color;

void main()
{
#ifdef BAND
    if (float(slice) + 0.5 < texelFetch(stretches, ivec2(gl_FragCoord.xy), 0).w)
        discard;
#endif
    color = vec4(0.0);
}

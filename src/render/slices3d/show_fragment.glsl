// SPDX-License-Identifier: MIT
// The z-buffer as a picture (figure 9, right): darker is nearer.
#include "job.glsl"
layout(binding = 9) uniform sampler2D shown;
layout(location = 0) out vec4 color;

void main()
{
    color = vec4(vec3(texelFetch(shown, ivec2(gl_FragCoord.xy), 0).r), 1.0);
}

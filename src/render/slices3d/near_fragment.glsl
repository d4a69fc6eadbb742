// SPDX-License-Identifier: MIT
// The second z-buffer of a band as stencil values, where the driver lets a shader write them: the number of the group of slices in which phi_t begins. A stencil test then culls early what
// lies before, as the z-buffer culls what lies behind.
#extension GL_ARB_shader_stencil_export : require
#include "job.glsl"
layout(binding = 7) uniform sampler2D stretches;
layout(location = 1) uniform vec4 how; // slices a group

void main()
{
    gl_FragStencilRefARB = int(clamp(floor((texelFetch(stretches, ivec2(gl_FragCoord.xy), 0).w - 0.5) / how.x), 0.0, 255.0));
}

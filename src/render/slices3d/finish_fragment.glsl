// SPDX-License-Identifier: MIT
// The picture in display values, where colours were gathered in linear light.
#include "job.glsl"
#include "display.glsl"
layout(binding = 9) uniform sampler2D picture;
layout(location = 0) out vec4 color;

void main()
{
    color = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
    if (color.a > 0.0)
        color.rgb = to_display(color.rgb / color.a) * color.a;
}

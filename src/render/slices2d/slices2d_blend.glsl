// SPDX-License-Identifier: MIT
// Across the switch from one stack to another (section 4: "if the viewing direction changes by more than 90 degrees, the orientation of the slice normal
// must be changed") the pictures of both are added up by weights that follow the direction.
#include "job.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) uniform image2D picture;
layout(binding = 5) uniform sampler2D layer;
layout(location = 0) uniform float weight;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, job.picture.xy)))
        imageStore(picture, pixel, imageLoad(picture, pixel) + weight * texelFetch(layer, pixel, 0));
}

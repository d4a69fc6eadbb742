// SPDX-License-Identifier: MIT
// A pixel's list, from front to back, and what is opaque behind it. The nearest fragment is looked for again and again: lists are short, and there is no end to how long one may be. What
// lies equally deep goes by isovalue, so that the order in which the GPU came to it does not show.
#define LISTS readonly
#include "job.glsl"
#include "mesh_space.glsl"
layout(binding = 9) uniform sampler2D picture;
layout(location = 0) out vec4 color;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint head = list_head[uint(pixel.y) * uint(job.picture.x) + uint(pixel.x)], last_surface = 0u;
    float last = -1e38;
    vec4 sum = vec4(0.0);
    while (sum.a < job.gradient.z) {
        uint nearest = END_OF_LIST;
        float depth = 3e38;
        uint surface = END_OF_LIST;
        for (uint node = head; node != END_OF_LIST; node = list_link[node].x) {
            float d = list_node[node].w;
            uint s = list_link[node].y;
            bool behind = d > last || (d == last && s > last_surface);
            if (behind && (d < depth || (d == depth && s < surface))) {
                nearest = node;
                depth = d;
                surface = s;
            }
        }
        if (nearest == END_OF_LIST)
            break;
        sum += (1.0 - sum.a) * vec4(list_node[nearest].rgb, job.iso[surface].y);
        last = depth;
        last_surface = surface;
    }
    if (sum.a < job.gradient.z)
        sum += (1.0 - sum.a) * texelFetch(picture, pixel, 0);
    color = sum;
}

// SPDX-License-Identifier: MIT
// A pixel's list, from front to back, and what is opaque behind it. The nearest fragment is looked for again and again: lists are short, and there is no end to how long one may be. What
// lies equally deep goes by isovalue, then by colour, so that the order in which the GPU came to it does not show; sheets that lie in one another are each a fragment.
//
// It computes and does not draw: where llvmpipe cuts a triangle over the whole picture in two, it ends the loops of pixels along the cut too early.
#define LISTS readonly
#include "job.glsl"
#include "mesh_space.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) uniform image2D picture;

bool is_before(uint a, uint b)
{
    vec4 p = list_node[a], q = list_node[b];
    uint s = list_link[a].y, t = list_link[b].y;
    if (p.w != q.w)
        return p.w < q.w;
    if (s != t)
        return s < t;
    for (int c = 0; c < 3; c++)
        if (p[c] != q[c])
            return p[c] < q[c];
    return a < b;
}

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= job.picture.x || pixel.y >= job.picture.y)
        return;
    uint head = list_head[uint(pixel.y * job.picture.x + pixel.x)], last = END_OF_LIST;
    float last_depth = -1e38;
    vec4 sum = vec4(0.0);
    while (sum.a < job.gradient.z) {
        uint nearest = END_OF_LIST;
        float depth = 3e38;
        for (uint node = head; node != END_OF_LIST; node = list_link[node].x) {
            float d = list_node[node].w;
            bool behind = d > last_depth || (d == last_depth && is_before(last, node));
            if (behind && (d < depth || (d == depth && is_before(node, nearest)))) {
                nearest = node;
                depth = d;
            }
        }
        if (nearest == END_OF_LIST) {
            sum += (1.0 - sum.a) * imageLoad(picture, pixel);
            break;
        }
        sum += (1.0 - sum.a) * vec4(list_node[nearest].rgb, job.iso[list_link[nearest].y].y);
        last = nearest;
        last_depth = depth;
    }
    imageStore(picture, pixel, sum);
}

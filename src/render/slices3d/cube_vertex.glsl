// SPDX-License-Identifier: MIT
// Faces of cubes (section 4, figure 3 right), six vertices each. Those that turn the wrong side to the eye are drawn nowhere; which side a face turns is decided from its plane, not from how
// it is rasterised, so that no edge is seen from both sides.
#include "job.glsl"
#include "slice_space.glsl"
layout(binding = 5) uniform usamplerBuffer faces; // x, y; z, direction, cubes in the run (cubes.h)
layout(location = 0) uniform ivec4 run;           // the first face; voxels along an edge; 1: front faces, 0: back faces; 1: inflated
out float view_depth;
flat out int direction;

void main()
{
    uvec2 f = texelFetch(faces, run.x + gl_VertexID / 6).xy;
    const int corners[6] = int[](0, 1, 2, 2, 1, 3);
    int at = corners[gl_VertexID % 6];
    direction = int(f.y >> 16 & 7u);
    vec3 first = vec3(f.x & 0xffffu, f.x >> 16, f.y & 0xffffu), last = first + vec3(f.y >> 19, 1.0, 1.0);
    vec3 lo = clamp(first * float(run.y), job.box_lo.xyz, job.box_hi.xyz), hi = clamp(last * float(run.y), job.box_lo.xyz, job.box_hi.xyz);
    int axis = direction >> 1;
    bool upper = (direction & 1) != 0;
    float plane = upper ? hi[axis] : lo[axis], outside = slices.eye.w != 0.0 ? slices.eye[axis] - plane : -slices.eye[axis];
    bool front = upper ? outside > 0.0 : outside < 0.0;
    if (run.w != 0) { // to the sides by twice as much: where runs of different lengths meet at an edge, rounded vertices would leave pixels between them
        vec3 grow = slices.inflate.xyz * vec3(axis == 0 ? 1.0 : 2.0, axis == 1 ? 1.0 : 2.0, axis == 2 ? 1.0 : 2.0);
        lo -= grow;
        hi += grow;
    }
    vec3 p = lo;
    p[axis] = upper ? hi[axis] : lo[axis];
    if ((at & 1) != 0)
        p[(axis + 1) % 3] = hi[(axis + 1) % 3];
    if ((at & 2) != 0)
        p[(axis + 2) % 3] = hi[(axis + 2) % 3];
    view_depth = on_plane(slices.depth, p);
    gl_Position = front == (run.z != 0) ? vec4(on_plane(slices.clip_x, p), on_plane(slices.clip_y, p), 0.0, on_plane(slices.clip_w, p)) : vec4(0.0, 0.0, 0.0, -1.0);
}

// SPDX-License-Identifier: MIT
// Section 4.2: routes a cell's projection to its slab's layer. The paper sends another point on; GL drops points whose middle is off the screen and has a greatest size of them, so here it is
// a square of two triangles.
#include "job.glsl"
#include "peel_block.glsl"
layout(points) in;
layout(triangle_strip, max_vertices = 4) out;

in Cell {
    flat vec4 bound;
    flat vec3 disc;
    flat int layer;
    flat uint bit;
} cell[1];

flat out vec3 disc;
flat out uint bit;

void main()
{
    vec4 bound = cell[0].bound;
    if (bound.x > bound.z || bound.y > bound.w)
        return;
    for (int i = 0; i < 4; i++) {
        vec2 pixel = mix(bound.xy, bound.zw, bvec2((i & 1) != 0, (i & 2) != 0));
        gl_Layer = cell[0].layer;
        gl_Position = vec4((pixel + 0.5) * 2.0 / vec2(peel.tile.zw) - 1.0, 0.0, 1.0);
        disc = cell[0].disc;
        bit = cell[0].bit;
        EmitVertex();
    }
    EndPrimitive();
}

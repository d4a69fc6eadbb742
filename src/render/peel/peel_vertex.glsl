// SPDX-License-Identifier: MIT
// Section 4.2: a vertex is an active cell, found in the HistoPyramid by its number.
#include "peel_cover.glsl"

out Cell {
    flat vec4 bound;
    flat vec3 disc;
    flat int layer;
    flat uint bit;
} cell;

void main()
{
    Cover cover;
    bool seen = cover_of(histo_find(uint(gl_VertexID)).x, cover);
    cell.bound = seen ? cover.bound : vec4(1.0, 1.0, 0.0, 0.0);
    cell.disc = cover.disc;
    cell.layer = cover.layer;
    cell.bit = cover.bit;
    gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}

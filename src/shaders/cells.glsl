// SPDX-License-Identifier: MIT
// Rays from voxel cell to voxel cell, inside the stretches that NEXT_SEGMENT gives: bool (ivec2 pixel, Ray r, out vec2 stretch), near to far, in steps from the entry.
#include "cubic.glsl"

// The next place in a segment, from `at` on; a new place is in a new cell.
bool next_place(ivec2 pixel, const Ray r, vec2 part, inout float at, inout float end)
{
    vec2 stretch;
    while (NEXT_SEGMENT(pixel, r, stretch)) {
        float first = clamp(stretch.x, part.x, part.y);
        end = min(stretch.y, part.y);
        if (first > at) {
            at = first;
            cell = clamp(ivec3(floor(r.o + at * r.d)), ivec3(0), max(job.dims.xyz - 2, ivec3(0)));
            carried = false;
            faced = false;
        }
        if (at < end)
            return true;
    }
    return false;
}

// The next cell that may hold a surface, and between which places the ray is in it.
bool next_cell(ivec2 pixel, const Ray r, vec2 part, vec3 side, ivec3 rim, inout float at, inout float end, inout uint cells, inout vec2 within)
{
    bool found = false;
    while (!found) {
        if (at >= end && !next_place(pixel, r, part, at, end))
            break;
        take_face();
        if (!faced) { // the face behind the ray, of a new cell: the one before it comes next
            faced = true;
            continue;
        }
        vec3 exits = mix((vec3(cell) + side - r.o) * r.inverse, vec3(1e30), equal(cell, rim));
        float leave = min(min(exits.x, exits.y), exits.z);
        within = vec2(at, min(leave, part.y));
        if (within.y > within.x) {
            cells++;
            found = may_hold();
        }
        at = max(within.x, within.y);
        corner = vec3(cell);
        across = bvec3(exits.x <= leave, exits.x > leave && exits.y <= leave, min(exits.x, exits.y) > leave); // through an edge: one face after the other
        if (leave < 1e30)
            cell += mix(ivec3(0), heading, across);
    }
    return found;
}

// Finds the surfaces in a part of the ray (steps from its entry); gives how many cells were looked into. Neighbouring rays look for the next cell, then for a root, then shade together.
uint cast_cells(ivec2 pixel, const Ray r, vec2 part)
{
    uint cells = 0u;
    float at = -1.0, end = -1.0, u;
    vec2 within = vec2(0.0);
    vec3 side = mix(vec3(1.0), vec3(0.0), lessThan(r.inverse, vec3(0.0)));
    ivec3 rim = ivec3(side) * max(job.dims.xyz - 2, ivec3(0)); // behind these there is no face: a ray may run in the volume's own
    bool going = true, entered = false;
    int i;
    heading = ivec3(2.0 * side - 1.0);
    across = bvec3(true, false, false);
    carried = false;
    while (going) {
        bool hit = false;
        while (!hit) {
            if (!entered) {
                if (!next_cell(pixel, r, part, side, rim, at, end, cells, within))
                    break;
                enter_cell(r, within.x, within.y);
            }
            hit = entered = next_root(i, u);
        }
        going = hit && add_surface(r, i, within.x + (within.y - within.x) * u);
    }
    return cells;
}

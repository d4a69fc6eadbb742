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

// Finds the surfaces in a part of the ray (steps from its entry); gives how many cells were looked into.
uint cast_cells(ivec2 pixel, const Ray r, vec2 part)
{
    uint cells = 0u;
    float at = -1.0, end = -1.0, from, to;
    vec3 side = mix(vec3(1.0), vec3(0.0), lessThan(r.inverse, vec3(0.0)));
    ivec3 rim = ivec3(side) * max(job.dims.xyz - 2, ivec3(0)); // behind these there is no face: a ray may run in the volume's own
    bool going = true;
    heading = ivec3(2.0 * side - 1.0);
    across = bvec3(true, false, false);
    carried = false;
    while (going) {
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
            from = at;
            to = min(leave, part.y);
            if (to > from) {
                cells++;
                found = may_hold();
            }
            at = max(from, to);
            corner = vec3(cell);
            across = bvec3(exits.x <= leave, exits.x > leave && exits.y <= leave, min(exits.x, exits.y) > leave); // through an edge: one face after the other
            if (leave < 1e30)
                cell += mix(ivec3(0), heading, across);
        }
        going = found && add_surfaces(r, from, to);
    }
    return cells;
}

// SPDX-License-Identifier: MIT
// Isosurfaces by uniform steps: crossings between the ends of segments, in the order of the ray; the root by regula falsi on the reconstructed signal, or by FIND_ROOT.
#include "root.glsl"
#include "segments.glsl"
#include "surface.glsl"

vec2 ends; // of the segment

#ifndef FIND_ROOT
#define FIND_ROOT find_root
// Root of value = iso in [a, b] (steps), between f and g on different sides. NaN: the search met a void.
float find_root(const Ray r, float iso, float a, float f, float b, float g)
{
    Bracket k = Bracket(a, b, f - iso, g - iso);
    for (int i = 0; i < 6; i++) {
        float root = bracket_guess(k), h = linear(r.o + root * r.d) - iso;
        if (isnan(h))
            return h;
        bracket_narrow(k, root, h);
    }
    return bracket_guess(k);
}
#endif

int march_probe(const Ray r, int k, float at, vec3 p)
{
    ends = segment_ends(r, k, p);
    if (isnan(ends.x) || isnan(ends.y))
        return GO_ON;
    bool crossed = false;
    for (int i = 0; i < ISOVALUES; i++)
        crossed = crossed || (ends.x < job.iso[i].x) != (ends.y < job.iso[i].x);
    return crossed ? TAKE : GO_ON;
}

bool march_take(const Ray r, int k, float at, vec3 p)
{
    for (int j = 0; j < ISOVALUES; j++) {
        int i = ends.y > ends.x ? j : ISOVALUES - 1 - j;
        float iso = job.iso[i].x;
        if ((ends.x < iso) == (ends.y < iso))
            continue;
        float root = FIND_ROOT(r, iso, at, ends.x, at + segment_length(r, k), ends.y);
        if (!isnan(root) && !add_surface(r, i, root))
            return false;
    }
    return true;
}

// SPDX-License-Identifier: MIT
// Isosurfaces in one pass, section 7, with what its hardware had to give up one of: coloured ambient and diffuse light, several lights, trilinear interpolation.
//
// By default a surface is where the value crosses the isovalue between a slice and the next, found on the reconstructed signal and lit by the gradient there.
// With ALPHA_TEST it is the paper's: what passes the alpha test value >= isovalue on a slice, the foremost such slice; it shows the slices as steps.
#include "root.glsl"
#include "job.glsl"
#include "space.glsl"
#include "slices2d_space.glsl"
#include "slices2d_stack.glsl"
#define SURFACES
#include "slices2d_gather.glsl"
#include "slices2d_lighting.glsl"
layout(location = 0) flat in int first_slice;

vec3 inside(vec3 place)
{
    return clamp(place, vec3(0.0), vec3(job.dims.xyz.TO_STACK - 1));
}

void surface(const Ray r, int i, vec3 place, float m, float alpha)
{
    put_behind(vec4(light_sample(r, gradient(place), alpha, alpha * job.iso_color[i].rgb), alpha), m);
}

#ifdef ALPHA_TEST
void main()
{
    SliceRay s;
    Ray r;
    if (!slice_ray(gl_FragCoord.xy - 0.5, s, r))
        discard;
    gather_begin();
    for (int m = first_slice; m < first_slice + slices.polygons.x; m++) {
        if (float(m) < s.from || float(m) > s.to)
            continue;
        vec3 place = inside(slice_place(s, float(m)));
        float value = on_slice(place);
        int found = -1;
        for (int i = 0; i < ISOVALUES; i++) // false for a void
            found = value >= job.iso[i].x ? i : found;
        if (found >= 0) {
            surface(r, found, place, float(m), 1.0);
            break;
        }
    }
    gather_end(s);
}
#else

// Root of value = iso between slices a and b, whose values f and g lie on different sides; NaN: the search met a void.
float find_root(const SliceRay s, float iso, float a, float f, float b, float g)
{
    Bracket k = Bracket(a, b, f - iso, g - iso);
    for (int i = 0; i < 4; i++) {
        float root = bracket_guess(k), h = linear(inside(slice_place(s, root))) - iso;
        if (isnan(h))
            return h;
        bracket_narrow(k, root, h);
    }
    return bracket_guess(k);
}

bool crossed(vec2 ends)
{
    for (int i = 0; i < ISOVALUES; i++)
        if ((ends.x < job.iso[i].x) != (ends.y < job.iso[i].x))
            return true;
    return false;
}

void main()
{
    SliceRay s;
    Ray r;
    if (!slice_ray(gl_FragCoord.xy - 0.5, s, r))
        discard;
    gather_begin();
    int m = first_slice, end = first_slice + slices.polygons.x;
    vec2 ends = vec2(nan());
    while (m < end) {
        float a = 0.0, b = 0.0;
        bool found = false;
        for (; m < end && !found; m++) { // to the next stretch from slice to slice that has a crossing
            a = max(float(m), s.from);
            b = min(float(m + 1), s.to);
            if (a >= b)
                continue;
            if (isnan(ends.y))
                ends.y = linear(inside(slice_place(s, a)));
            ends = vec2(ends.y, linear(inside(slice_place(s, b))));
            found = !isnan(ends.x) && !isnan(ends.y) && crossed(ends);
        }
        for (int j = 0; found && j < ISOVALUES; j++) { // in the order of the ray
            int i = ends.y > ends.x ? j : ISOVALUES - 1 - j;
            float iso = job.iso[i].x;
            if ((ends.x < iso) == (ends.y < iso))
                continue;
            float root = find_root(s, iso, a, ends.x, b, ends.y);
            if (!isnan(root)) // the search met a void
                surface(r, i, inside(slice_place(s, root)), root, job.iso[i].y);
        }
    }
    gather_end(s);
}
#endif

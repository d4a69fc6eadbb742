// SPDX-License-Identifier: MIT
// What a polygon's fragment gathers over its slices, and how it meets what lies before it.
//
// Section 6 combines n slices in the texture stages, C_s = C_t0 A_t0 (1 - A_t1) + C_t1 A_t1 and A_s = (1 - A_t0)(1 - A_t1) (equations 4 and 5, back to
// front), so that blending once gives what blending n times would (equation 3). Here slices come front to back: the same sum in the other order, for any n,
// in float; A is opacity, the paper's A_s is 1 - A. The blending function then puts the polygon's sum behind the picture: dst += (1 - dst.a) src.
layout(location = 0) out vec4 polygon;
vec4 sum = vec4(0.0);
float before = 0.0;  // opacity of the polygons before this one, where depth is asked for
float seen_at = -1e9; // the slice at which half the light was gathered; SURFACES: of the first surface, however faint

#ifdef DEPTH
layout(binding = 5) uniform sampler2D so_far;
layout(r32f, binding = 1) writeonly uniform image2D depth;
#endif

void gather_begin()
{
#ifdef DEPTH
    before = texelFetch(so_far, ivec2(gl_FragCoord.xy), 0).a;
#endif
}

void put_behind(vec4 more, float m)
{
    float was = before + (1.0 - before) * sum.a;
    sum += (1.0 - sum.a) * more;
#ifdef DEPTH
    float now = before + (1.0 - before) * sum.a;
#ifdef SURFACES
    bool reached = was == 0.0 && now > 0.0;
#else
    bool reached = was < 0.5 && now >= 0.5;
#endif
    if (reached)
        seen_at = m;
#endif
}

void gather_end(const SliceRay s)
{
    polygon = sum;
#ifdef DEPTH
    if (seen_at > -1e8) // at most one polygon of a pixel finds it
        imageStore(depth, ivec2(gl_FragCoord.xy), vec4(slice_distance(s, seen_at)));
#endif
}

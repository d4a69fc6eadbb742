// SPDX-License-Identifier: MIT
// Fillings that look at segments: samples lie at their ends, and the value at one's back is that at the next one's front, unless segments between were left out.
#define ENDS
float front;
bool have_front;

void march_gap()
{
    have_front = false;
}

float segment_length(const Ray r, int k)
{
    return k == r.n - 1 ? r.fraction : 1.0;
}

// The values at the front and the back of segment k, whose front is at p.
vec2 segment_ends(const Ray r, int k, vec3 p)
{
    vec2 ends = vec2(have_front ? front : linear(p), linear(r.o + (float(k) + segment_length(r, k)) * r.d));
    front = ends.y;
    have_front = true;
    return ends;
}

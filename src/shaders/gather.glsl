// SPDX-License-Identifier: MIT
// Colour gathered along a ray, front to back (equation 1.8), and where the ray had gathered half its opacity.
vec4 sum;
float seen_at; // steps from the entry; negative: nowhere yet

void gather_begin()
{
    sum = vec4(0.0);
    seen_at = -1.0;
}

// Puts (premultiplied) colour behind what is there.
void put_behind(vec4 more, float at)
{
    sum += (1.0 - sum.a) * more;
    if (seen_at < 0.0 && sum.a >= 0.5)
        seen_at = at;
}

void march_end(const Ray r)
{
    result = sum;
    result_depth = seen_at;
}

// at: 0 where half the opacity is not gathered yet, else seen_at + 1.
bool march_load(const Ray r, vec4 kept, float at)
{
    sum = kept;
    seen_at = at - 1.0;
    return sum.a < job.gradient.z;
}

vec4 march_save(out float at)
{
    at = max(seen_at + 1.0, 0.0);
    return sum;
}

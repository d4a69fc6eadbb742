// SPDX-License-Identifier: MIT
// Surfaces of equal value that a ray meets: the light of one, put behind what is there.

// False where nothing behind it is seen.
bool add_surface(const Ray r, int i, float at)
{
    float alpha = job.iso[i].y;
    vec3 color = shade(r, gradient(r.o + at * r.d), alpha, alpha * job.iso_color[i].rgb);
    if (seen_at < 0.0) // the depth is the first surface's, however faint
        seen_at = at;
    put_behind(vec4(color, alpha), at);
    return sum.a < job.gradient.z && alpha < 1.0;
}

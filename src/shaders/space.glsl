// SPDX-License-Identifier: MIT
// Rays: where one enters and leaves the box and the clip planes, in steps (docs/optics.md; the same words as src/cpu/packet.h).
struct Ray {
    vec3 o, d;        // index space: entry, and one step
    vec3 inverse;     // 1 / d, finite
    int n;            // segments
    float fraction;   // length of the last, in steps
    float offset, last; // sample k lies at min(k + offset, last) steps from the entry
    float entry;      // world distance of the entry
    int octant;       // of directions: bit a is set where the ray goes down along axis a
};

// The pseudo-random part of a step by which a pixel's samples are moved in a frame: src/cpu/jitter.h.
float jitter_of(uvec2 pixel, uint frame)
{
    uint h = pixel.x * 0x9e3779b1u + pixel.y * 0x85ebca77u + 0x27d4eb2fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    h ^= h >> 15;
    h += frame * 0x9e3779b9u;
    return float(h >> 8) * (1.0 / 16777216.0);
}

// False where the ray misses.
bool ray_of(ivec2 pixel, out Ray r)
{
    vec2 at = vec2(pixel);
    vec3 p = job.p0.xyz + at.x * job.px.xyz + at.y * job.py.xyz;
    vec3 d = job.d0.xyz + at.x * job.dx.xyz + at.y * job.dy.xyz;
    vec3 w = job.w0.xyz + at.x * job.wx.xyz + at.y * job.wy.xyz;
    float lo = job.ray.y, hi = 1e30;
    for (int a = 0; a < 3; a++) {
        if (abs(d[a]) < job.ray.w) { // in parallel with two faces: between them or not
            if (p[a] < job.box_lo[a] - 1e-5 || p[a] > job.box_hi[a] + 1e-5)
                return false;
            continue;
        }
        float t0 = (job.box_lo[a] - p[a]) / d[a], t1 = (job.box_hi[a] - p[a]) / d[a];
        lo = max(lo, min(t0, t1));
        hi = min(hi, max(t0, t1));
    }
    for (int i = 0; i < job.picture.z; i++) {
        float value = dot(job.planes[i].xyz, p) + job.planes[i].w, slope = dot(job.planes[i].xyz, d);
        if (abs(slope) < 1e-7) {
            if (value < -1e-5 * job.ray.z) // world lengths
                return false;
        } else if (slope > 0) {
            lo = max(lo, -value / slope);
        } else {
            hi = min(hi, -value / slope);
        }
    }
    float world = length(w), stretch = min((hi - lo) * world / job.ray.z, 1e6);
    if (!(stretch > 0))
        return false;
    r.n = max(int(stretch + 0.999), 1); // a last thousandth belongs to the segment before
    r.fraction = stretch - float(r.n - 1);
    r.o = clamp(p + lo * d, job.box_lo.xyz, job.box_hi.xyz);
    r.d = d * (job.ray.z / world);
    r.inverse = 1.0 / mix(r.d, vec3(1e-12), lessThan(abs(r.d), vec3(1e-12)));
    r.offset = job.picture.w != 0 ? jitter_of(uvec2(pixel), uint(job.picture.w - 1)) : 0.5;
    r.last = max(float(r.n - 1) + r.offset * r.fraction, 0.0);
    r.entry = (lo + job.ray.x) * world;
    r.octant = (r.d.x < 0.0 ? 1 : 0) + (r.d.y < 0.0 ? 2 : 0) + (r.d.z < 0.0 ? 4 : 0);
    return true;
}

// What a ray gives: premultiplied colour, and depth in steps from the entry (negative: none).
vec4 result;
float result_depth;

// What a filling's probe says of a sample (march.glsl).
const int GO_ON = 0, TAKE = 1, END = 2;

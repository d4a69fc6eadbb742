// SPDX-License-Identifier: MIT
// Reconstruction: trilinear (by the texture unit, or voxel by voxel where some are void), nearest, and the gradient. NaN stands for a void.
layout(binding = 0) uniform sampler3D volume;

float nan()
{
    return uintBitsToFloat(0x7fc00000u);
}

#ifdef BRICKS
#define FIRST_VOXEL job.brick.xyz
#define TEXTURE_SIZE job.brick_size.xyz
#else
#define FIRST_VOXEL ivec3(0)
#define TEXTURE_SIZE job.dims.xyz
#endif

float texel_to_raw(float texel)
{
    return texel * job.raw.x + job.raw.y;
}

// One voxel of the volume.
float voxel_within(ivec3 at)
{
    float raw = texel_to_raw(texelFetch(volume, at - FIRST_VOXEL, 0).r);
#ifdef VOIDS
    if (!(abs(raw) <= 3.4e38) || abs(raw - job.raw.z) <= job.raw.w)
        return nan();
#endif
    return raw;
}

// The last one again beyond the ends.
float voxel(ivec3 at)
{
    return voxel_within(clamp(at, ivec3(0), job.dims.xyz - 1));
}

float linear(vec3 p)
{
#ifdef VOIDS
    ivec3 c = clamp(ivec3(floor(p)), ivec3(0), max(job.dims.xyz - 2, ivec3(0)));
    vec3 f = p - vec3(c);
    vec4 low = vec4(voxel(c), voxel(c + ivec3(1, 0, 0)), voxel(c + ivec3(0, 1, 0)), voxel(c + ivec3(1, 1, 0)));
    vec4 high = vec4(voxel(c + ivec3(0, 0, 1)), voxel(c + ivec3(1, 0, 1)), voxel(c + ivec3(0, 1, 1)), voxel(c + ivec3(1, 1, 1)));
    vec4 v = low + f.z * (high - low);
    vec2 row = v.xy + f.y * (v.zw - v.xy);
    return row.x + f.x * (row.y - row.x);
#else
    return texel_to_raw(textureLod(volume, (p - vec3(FIRST_VOXEL) + 0.5) / vec3(TEXTURE_SIZE), 0.0).r);
#endif
}

ivec3 nearest_voxel(vec3 p)
{
    return min(ivec3(floor(p + 0.5)), job.dims.xyz - 1);
}

// The value that a mode shows at a place.
float reconstruct(vec3 p)
{
#ifdef NEAREST
    return voxel(nearest_voxel(p));
#else
    return linear(p);
#endif
}

// Central differences at the cell's corners, interpolated, which is the difference of two values one voxel to either side; in parts of the volume's range a voxel.
vec3 gradient(vec3 p)
{
    vec3 g;
#ifdef VOIDS
    ivec3 c = clamp(ivec3(floor(p)), ivec3(0), max(job.dims.xyz - 2, ivec3(0)));
    vec3 f = p - vec3(c);
    for (int a = 0; a < 3; a++) {
        ivec3 e = ivec3(a == 0, a == 1, a == 2);
        vec4 v[2];
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < 4; i++) {
                ivec3 at = c + ivec3(i & 1, i >> 1, k);
                v[k][i] = voxel(at + e) - voxel(at - e);
            }
        vec4 u = mix(v[0], v[1], f.z);
        vec2 row = mix(u.xy, u.zw, f.y);
        g[a] = mix(row.x, row.y, f.x);
    }
#else
    g.x = linear(p + vec3(1, 0, 0)) - linear(p - vec3(1, 0, 0));
    g.y = linear(p + vec3(0, 1, 0)) - linear(p - vec3(0, 1, 0));
    g.z = linear(p + vec3(0, 0, 1)) - linear(p - vec3(0, 0, 1));
#endif
    return g * (0.5 * job.gradient.x);
}

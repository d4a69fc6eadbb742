// SPDX-License-Identifier: MIT
// Reconstruction from a stack of 2D textures: what sampling.glsl does from a 3D texture, by the same names. NaN stands for a void.
layout(binding = 0) uniform sampler2DArray stack;

float nan()
{
    return uintBitsToFloat(0x7fc00000u);
}

float texel_to_raw(float texel)
{
    return texel * job.raw.x + job.raw.y;
}

// One voxel, the last one again beyond the ends; index space.
float voxel(ivec3 at)
{
    float raw = texel_to_raw(texelFetch(stack, clamp(at, ivec3(0), job.dims.xyz - 1).TO_STACK, 0).r);
#ifdef VOIDS
    if (!(abs(raw) <= 3.4e38) || abs(raw - job.raw.z) <= job.raw.w)
        return nan();
#endif
    return raw;
}

// A place in slice i of voxels: bilinear, by the texture unit where no voxel is void (section 4).
float in_slice(vec2 at, int i)
{
#ifdef VOIDS
    ivec2 last = job.dims.xyz.TO_STACK.xy - 1, c = clamp(ivec2(floor(at)), ivec2(0), max(last - 1, ivec2(0)));
    vec2 f = clamp(at, vec2(0.0), vec2(last)) - vec2(c);
    vec4 v;
    for (int corner = 0; corner < 4; corner++)
        v[corner] = voxel(ivec3(c + ivec2(corner & 1, corner >> 1), i).FROM_STACK);
    vec2 row = v.xy + f.y * (v.zw - v.xy);
    return row.x + f.x * (row.y - row.x);
#else
    return texel_to_raw(textureLod(stack, vec3((at + 0.5) / vec2(job.dims.xyz.TO_STACK.xy), float(i)), 0.0).r);
#endif
}

// The slice of voxels before a place, and how far it is towards the next.
int slice_before(float k, out float alpha)
{
    int last = job.dims[AXIS] - 1, i = clamp(int(floor(k)), 0, max(last - 1, 0));
    alpha = clamp(k, 0.0, float(last)) - float(i);
    return i;
}

// Equation 1: S(i + alpha) = (1 - alpha) S(i) + alpha S(i + 1), which makes bilinear interpolation trilinear, with no memory for what is between.
float intermediate(vec2 at, int i, float alpha)
{
    float a = in_slice(at, clamp(i, 0, job.dims[AXIS] - 1)), b = in_slice(at, clamp(i + 1, 0, job.dims[AXIS] - 1));
    return a + alpha * (b - a);
}

// Trilinear, anywhere between slices; stack space.
float linear(vec3 s)
{
    float alpha;
    int i = slice_before(s.z, alpha);
    return intermediate(s.xy, i, alpha);
}

// On a slice that is composited: one of voxels (PLAIN), or one between.
float on_slice(vec3 s)
{
#ifdef PLAIN
    return in_slice(s.xy, int(s.z + 0.5));
#else
    return linear(s);
#endif
}

ivec3 nearest_voxel(vec3 s)
{
    return min(ivec3(floor(s.FROM_STACK + 0.5)), job.dims.xyz - 1);
}

// Differences over two voxels, along u, v and k; index space, in parts of the volume's range. Not stored beside the voxels as the paper must (sections 7
// and 8): three stacks of RGBA bytes would take twelve bytes a voxel, six fetches on a slice of voxels cost less than that memory's bandwidth.
vec3 gradient(vec3 s)
{
    float alpha;
    int i = slice_before(s.z, alpha);
    vec2 u = vec2(1.0, 0.0), v = vec2(0.0, 1.0);
    vec3 g;
#ifdef PLAIN
    i += int(alpha + 0.5);
    g = vec3(in_slice(s.xy + u, i) - in_slice(s.xy - u, i), in_slice(s.xy + v, i) - in_slice(s.xy - v, i),
             in_slice(s.xy, min(i + 1, job.dims[AXIS] - 1)) - in_slice(s.xy, max(i - 1, 0)));
#else
    g.xy = vec2(intermediate(s.xy + u, i, alpha) - intermediate(s.xy - u, i, alpha), intermediate(s.xy + v, i, alpha) - intermediate(s.xy - v, i, alpha));
    g.z = intermediate(s.xy, i + 1, alpha) - intermediate(s.xy, i - 1, alpha);
#endif
    return g.FROM_STACK * (0.5 * job.gradient.x);
}

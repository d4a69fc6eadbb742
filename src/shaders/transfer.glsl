// SPDX-License-Identifier: MIT
// The transfer function's tables (src/cpu/classify.c fills them): nearest entry.
// A texture with five rows for each 4096 entries:
//   STEP        colour times the opacity of one step, and that opacity
//   POINT       colour, and the opacity per unit distance
//   SUMS        integrals over the entries of extinction times colour, and of extinction
//   EXTINCTION  x: over one step
//   SLAB        colour, and -log2 of a step's transparency, so that a length in steps is a factor
layout(binding = 4) uniform sampler2D entries;
const int STEP = 0, POINT = 1, SUMS = 2, EXTINCTION = 3, SLAB = 4;

vec4 entry(int i, int what)
{
    return texelFetch(entries, ivec2(i & 4095, (i >> 12) * 5 + what), 0);
}

int entry_of(float raw)
{
    return int(clamp(raw * job.table.x + job.table.y, 0.0, job.table.z)); // NaN: 0, or any entry; the caller has looked
}

// For the modes that show one value a pixel.
void show_value(float raw, float at)
{
    vec4 point = entry(entry_of(raw), POINT);
    result = vec4(point.rgb * point.a, point.a);
    result_depth = at;
}

// Opacity of `length` steps from that of one.
float alpha_of_length(float alpha, float length)
{
    return alpha >= 1.0 ? alpha : 1.0 - exp(length * log(max(1.0 - alpha, 1e-30)));
}

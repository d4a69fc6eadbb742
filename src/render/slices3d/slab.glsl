// SPDX-License-Identifier: MIT
// What a slice adds to a pixel: the slab of its ray around it, with the ray caster's reconstruction and classification.
layout(binding = 7) uniform sampler2D stretches; // a ray's stretch in the box and the clip planes, in slices; the world length of a unit of depth; where phi_t begins, in slices

// Colour and opacity (premultiplied, not shaded) of the slab from ends.x to ends.y slices from the place, on a ray that goes `way` a slice. Slices are as far apart along the view axis as the
// ray caster's samples along a ray; along this ray they are `world` = 1 / cos farther, which the length in steps accounts for exactly.
vec4 slab_color(vec3 place, vec3 way, vec2 ends, float world)
{
    float steps = max(ends.y - ends.x, 0.0) * world;
#ifdef PREINTEGRATED
    float front = linear(place + ends.x * way), back = linear(place + ends.y * way);
    return isnan(front) || isnan(back) ? vec4(0.0) : pre_integrate(front, back, steps);
#elif defined(PRE)
    vec4 color = pre_classify(place);
    float alpha = alpha_of_length(max(color.a, 0.0), steps); // of a step -> of the slab
    return color * (color.a > 0.0 ? alpha / color.a : 0.0);
#else
    float raw = reconstruct(place);
    vec4 slab = entry(entry_of(raw), SLAB);
    float alpha = 1.0 - exp2(-slab.a * steps);
#ifdef VOIDS
    if (isnan(raw))
        alpha = 0.0;
#endif
    return vec4(slab.rgb * alpha, alpha);
#endif
}

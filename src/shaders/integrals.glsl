// SPDX-License-Identifier: MIT
// Pre-integration (Engel, Kraus and Ertl 2001): a segment from the values at its two ends.
struct Integral {
    float entry, tau;
    vec4 sums;
    vec3 color;
};

// The integrals up to a value: the sum at the nearest entry, and on from there with its extinction, also beyond the table's ends.
Integral integral_to(float raw)
{
    Integral t;
    int i = entry_of(raw);
    t.entry = raw * job.table.x + job.table.y - 0.5;
    t.tau = entry(i, EXTINCTION).x;
    float beyond = (t.entry - float(i)) * t.tau;
    t.color = entry(i, POINT).rgb;
    t.sums = entry(i, SUMS) + beyond * vec4(t.color, 1.0);
    return t;
}

vec4 pre_integrate(float a, float b, float length)
{
    Integral f = integral_to(a), g = integral_to(b);
    float span = g.entry - f.entry;
    if (abs(span) < 0.25) {
        float alpha = 1.0 - exp(-max(f.tau, 0.0) * length);
        return vec4(alpha * f.color, alpha);
    }
    float tau = max((g.sums.a - f.sums.a) / span, 0.0), alpha = 1.0 - exp(-tau * length);
    vec3 color = (g.sums.rgb - f.sums.rgb) * (alpha / (tau > 0.0 ? tau * span : 1.0));
    return vec4(clamp(color, vec3(0.0), vec3(alpha)), alpha);
}

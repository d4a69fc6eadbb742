// SPDX-License-Identifier: MIT
// Regula falsi, Illinois variant: the root between a and b, where a signal less the isovalue is f and g, on different sides. The bracket always holds it.
struct Bracket {
    float a, b, f, g;
};

float bracket_guess(const Bracket k)
{
    return clamp(k.a + (k.b - k.a) * (k.f / (k.f == k.g ? 1.0 : k.f - k.g)), k.a, k.b);
}

// With the value h at the guess.
void bracket_narrow(inout Bracket k, float guess, float h)
{
    if ((h < 0.0) == (k.f < 0.0)) { // the root lies behind
        k.a = guess;
        k.f = h;
        k.g *= 0.5;
    } else {
        k.b = guess;
        k.g = h;
        k.f *= 0.5;
    }
}

// SPDX-License-Identifier: MIT
// For the compute shader that says how many outputs each item gives: invocation g = histo_invocation() writes histo_base[g], whose byte i (word i / 4, from the least) is the count of
// item 16 g + i, and 0 beyond the last item. Invocations beyond histo_base.length() write nothing.
#include "histopyramid_invocation.glsl"
layout(std430, binding = 5) writeonly buffer HistoBase { uvec4 histo_base[]; };

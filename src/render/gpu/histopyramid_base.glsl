// SPDX-License-Identifier: MIT
// For the compute shader that says how many outputs each item gives: invocation g = histo_invocation() writes histo_base[g], whose byte i (word i / 4, from the least) is the count of
// item 16 g + i, and 0 beyond the last item. Invocations beyond histo_base.length() write nothing.
layout(local_size_x = 64) in;
layout(std430, binding = 5) writeonly buffer HistoBase { uvec4 histo_base[]; };

uint histo_invocation()
{
    return gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
}

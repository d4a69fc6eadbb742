// SPDX-License-Identifier: MIT
// The number of an invocation among those of pel_histopyramid_dispatch, whose groups lie in rows where they are many.
layout(local_size_x = 64) in;

uint histo_invocation()
{
    return gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * 64u;
}

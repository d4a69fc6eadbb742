// SPDX-License-Identifier: MIT
// The sums above a HistoPyramid's counts (histopyramid.h), four to a uvec4, level after level from the lowest.
#ifndef HISTO_ACCESS
#define HISTO_ACCESS readonly
#endif
layout(std430, binding = 6) HISTO_ACCESS buffer HistoLevels {
    uint histo_total, histo_top; // outputs; number of the highest level
    uint histo_padding[2];
    uint histo_offsets[16]; // of levels
    uvec4 histo_levels[];
};

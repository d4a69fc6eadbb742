/* SPDX-License-Identifier: MIT */
/* HistoPyramid (Ziegler, Tevs, Theobalt and Seidel 2006): stream compaction and expansion on the device. Each of many items gives out some
 * number of outputs, 0 to 255; the pyramid of sums over them tells for every output number, from 0 up to the total, which item it comes
 * from and which of that item's outputs it is. Nothing is sorted and no list is written: whoever wants output number i walks down from the
 * top. Nothing but the total is read back.
 *
 * To use one: reserve it for so many items; run a compute shader of your own that writes the counts (histopyramid_base.glsl, dispatched by
 * pel_histopyramid_dispatch over groups of 16 items); build; bind; then any shader that includes histopyramid.glsl may ask
 * histo_find(number), in GL_DRAW of `total` vertices or in a dispatch of `total` invocations.
 *
 * Counts are bytes, 16 of them a uvec4; the first level has a sum for each 16 items, every further one for each four sums: 4/3 bytes an
 * item in all, where the paper's texture of RGBA words takes 16/3. */
#ifndef PEL_RENDER_GPU_HISTOPYRAMID_H
#define PEL_RENDER_GPU_HISTOPYRAMID_H

#include "objects.h"

enum { PEL_BUFFER_HISTO_BASE = 5, PEL_BUFFER_HISTO_LEVELS }; /* as the shaders name them */
enum { PEL_HISTO_GROUP = 16, PEL_HISTO_LEVELS = 16 }; /* enough for 2^36 items */

struct pel_histopyramid {
    struct pel_buffer base, levels;
    size_t items;
    int level_count;
    uint32_t sizes[PEL_HISTO_LEVELS], offsets[PEL_HISTO_LEVELS]; /* of levels, from the lowest: sums, and the first one's uvec4 */
    uint32_t total;                                              /* outputs of all items, after pel_histopyramid_build */
};

/* Room for so many items. Counts are undefined then. The sum of all counts must stay below 2^32. PEL_ERROR_UNSUPPORTED where the device's
 * buffers do not hold them. */
bool pel_histopyramid_reserve(struct pel_device *device, struct pel_histopyramid *pyramid, size_t items, struct pel_error *error);

/* Bytes that it takes for so many items. */
uint64_t pel_histopyramid_bytes(size_t items);

/* Binds the buffers, for the shader that writes counts and for those that look outputs up. */
void pel_histopyramid_bind(const struct pel_histopyramid *pyramid);

/* Dispatches the current program, whose groups have 64 invocations in x, over so many invocations at least; the shader's own number is
 * histo_invocation(), which may be beyond `count`. Ends with the barrier that later passes over the same buffers need. */
void pel_histopyramid_dispatch(size_t count);

/* Sums the counts up, level by level, and waits for the total. Leaves the pyramid bound. */
bool pel_histopyramid_build(struct pel_device *device, struct pel_programs *programs, struct pel_histopyramid *pyramid,
                            struct pel_error *error);

void pel_histopyramid_finish(struct pel_device *device, struct pel_histopyramid *pyramid); /* accepts a zeroed one */

#endif

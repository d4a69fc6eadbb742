/* SPDX-License-Identifier: MIT */
/* libFuzzer target for ParaView's colour maps, JSON and XML: what is read must be a valid transfer function. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <pellucid/io.h>


int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

static void check(const struct pel_transfer *t)
{
    for (size_t i = 0; i < t->color_count; i++)
        if (!isfinite(t->colors[i].value) || (i && t->colors[i].value < t->colors[i - 1].value))
            abort();
    for (size_t i = 0; i < t->opacity_count; i++)
        if (!(t->opacities[i].opacity >= 0 && t->opacities[i].opacity <= 1))
            abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    struct pel_transfer transfer;
    struct pel_error error = PEL_ERROR_INIT;
    char *text = malloc(size + 1);
    if (!text || !pel_transfer_init(&transfer, &error))
        abort();
    memcpy(text, bytes, size);
    text[size] = 0;
    for (int named = 0; named < 2; named++)
        if (pel_transfer_from_text(text, size, named ? "b" : NULL, -3, 1000, &transfer, &error))
            check(&transfer);
        else if (error.code == PEL_ERROR_NONE || !error.message[0] || strchr(error.message, '\n'))
            abort();
    pel_transfer_finish(&transfer);
    free(text);
    return 0;
}

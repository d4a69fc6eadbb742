/* SPDX-License-Identifier: MIT */
/* pellucid compare: how alike two pictures are. */
#include <math.h>

#include "arguments.h"
#include "commands.h"

struct values {
    bool json;
    double psnr_min, max_error, ssim_min;
};

#define FIELD(name) offsetof(struct values, name)
static const struct pel_option rows[] = {
    { "psnr-min", "Least PSNR", "Alike only from this peak signal-to-noise ratio on", PEL_OPTION_DOUBLE, FIELD(psnr_min), 0, 999, NULL,
      NULL, "dB" },
    { "ssim-min", "Least SSIM", "Alike only from this structural similarity on", PEL_OPTION_DOUBLE, FIELD(ssim_min), -1, 1, NULL, NULL,
      NULL },
    { "max-error", "Greatest error", "Alike only where no channel differs by more", PEL_OPTION_DOUBLE, FIELD(max_error), 0, 1, NULL, NULL,
      NULL },
    { "json", "JSON", "Print one JSON object", PEL_OPTION_BOOL, FIELD(json), 0, 0, "false", NULL, NULL },
    { NULL },
};
static const struct option_extra extras[] = { { "psnr-min", 0, "DB", NULL, false }, { "max-error", 0, "E", NULL, false }, { NULL } };
static const struct option_group groups[] = { { "Options", rows, extras }, { NULL } };

/* JSON knows no infinity, and a script wants a number: beyond what any two different pictures of this size can reach. */
static const double PSNR_OF_EQUALS = 999;

static bool print_metrics(const struct pel_metrics *metrics, const struct pel_image *image, bool alike, bool json)
{
    bool identical = metrics->max_error == 0;
    if (json) {
        json_t *object = json_object();
        json_object_set_new(object, "psnr", json_number(isinf(metrics->psnr) ? PSNR_OF_EQUALS : metrics->psnr));
        json_object_set_new(object, "ssim", json_number(metrics->ssim));
        json_object_set_new(object, "max_error", json_number(metrics->max_error));
        json_object_set_new(object, "differing_pixels", json_integer(metrics->differing_pixels));
        json_object_set_new(object, "identical", json_boolean(identical));
        json_object_set_new(object, "alike", json_boolean(alike));
        json_object_set_new(object, "same_size", json_true());
        json_object_set_new(object, "size", json_pack("[i, i]", image->width, image->height));
        return json_print(object, stdout);
    }
    printf("size              %dx%d\n", image->width, image->height);
    printf(isinf(metrics->psnr) ? "psnr              infinite\n" : "psnr              %.3f dB\n", metrics->psnr);
    printf("ssim              %.6f\n", metrics->ssim);
    printf("greatest error    %.6f\n", metrics->max_error);
    printf("differing pixels  %ld (a channel differs by more than 0.1)\n", metrics->differing_pixels);
    printf("%s\n", identical ? "identical" : alike ? "alike" : "not alike");
    return true;
}

/* What a script reads of pictures that differ in size: the worst that there is. */
static bool print_unlike_sizes(const struct pel_image images[2])
{
    json_int_t first = (json_int_t)images[0].width * images[0].height, second = (json_int_t)images[1].width * images[1].height;
    return json_print(json_pack("{s:f, s:f, s:f, s:I, s:b, s:b, s:b}", "psnr", 0.0, "ssim", 0.0, "max_error", 1.0, "differing_pixels",
                                first > second ? first : second, "identical", 0, "alike", 0, "same_size", 0),
                      stdout);
}

static bool compare(const struct arguments *arguments, const struct values *values, bool *alike, struct pel_error *error)
{
    struct pel_image images[2];
    struct pel_metrics metrics;
    bool fine = false;
    pel_image_init(&images[0]);
    pel_image_init(&images[1]);
    for (int i = 0; i < 2; i++)
        if (!pel_read_image(arguments->operands[i], &images[i], error)) {
            tool_fail_in(error, arguments->operands[i]);
            goto cleanup;
        }
    if (images[0].width != images[1].width || images[0].height != images[1].height) {
        if (values->json && (!print_unlike_sizes(images) || tool_finish_stdout(EXIT_FINE) != EXIT_FINE)) {
            tool_fail(error, PEL_ERROR_IO, "the JSON text cannot be printed");
            goto cleanup;
        }
        /* Unlike, not a wrong use: the files decide it. */
        tool_fail(error, PEL_ERROR_FORMAT, "the pictures differ in size: %dx%d and %dx%d", images[0].width, images[0].height,
                  images[1].width, images[1].height);
        goto cleanup;
    }
    if (!pel_image_compare(&images[0], &images[1], &metrics, error))
        goto cleanup;
    /* Written so that NaN is unlike. */
    *alike = (!arguments_given(arguments, "psnr-min") || metrics.psnr >= values->psnr_min) &&
             (!arguments_given(arguments, "ssim-min") || metrics.ssim >= values->ssim_min) &&
             (!arguments_given(arguments, "max-error") || metrics.max_error <= values->max_error);
    fine = print_metrics(&metrics, &images[0], *alike, values->json) || tool_fail(error, PEL_ERROR_MEMORY, "no memory for the JSON text");
cleanup:
    pel_image_finish(&images[0]);
    pel_image_finish(&images[1]);
    return fine;
}

static int run(const struct command *command, int argc, char **argv)
{
    struct values values;
    struct arguments arguments = { .command = command, .objects = { &values } };
    int status = arguments_parse_operands(&arguments, argc, argv, 2, 2);
    if (status >= 0)
        return status;
    bool alike = false;
    struct pel_error error = PEL_ERROR_INIT;
    if (!compare(&arguments, &values, &alike, &error))
        return tool_report(&error);
    return tool_finish_stdout(alike ? EXIT_FINE : EXIT_FAILED);
}

const struct command command_compare = {
    .name = "compare",
    .summary = "Tell how alike two pictures are",
    .usage = "A B [options]",
    .description = "Reads PNG and float NRRD pictures. Channels are compared as premultiplied values from 0 to 1.\n\n"
                   "The exit status is 0 where the pictures are within the given limits (always, where none is given), and 1 where they "
                   "are not, or differ in size.\n\n"
                   "--json prints psnr (dB; 999 for equal pictures), ssim, max_error, differing_pixels (pixels with a channel that "
                   "differs by more than 0.1), identical, alike, same_size and size (not of pictures that differ in it).",
    .examples = "  pellucid compare a.png b.png\n"
                "  pellucid compare a.png b.png --psnr-min 40 --max-error 0.1 && echo alike",
    .groups = groups,
    .run = run,
};

/* SPDX-License-Identifier: MIT */
/* pellucid formats: what can be read and written, and the names that options take. */
#include "arguments.h"
#include "commands.h"

static int run(const struct command *command, int argc, char **argv)
{
    struct arguments arguments = { .command = command };
    int status = arguments_parse_operands(&arguments, argc, argv, 0, 0);
    if (status >= 0)
        return status;
    const struct pel_format_info *format;
    printf("Volumes and fields\n");
    for (size_t i = 0; (format = pel_format_at(i)); i++)
        printf("  %-10s %-5s %-6s %-24s %s\n", format->name, format->reads ? "read" : "", format->writes ? "write" : "", format->endings,
               format->summary);
    printf("\nPictures\n  %-10s %-5s %-6s %-24s %s\n  %-10s %-5s %-6s %-24s %s\n", "png", "read", "write", ".png", "8 bits a channel, sRGB",
           "nrrd", "read", "write", ".nrrd", "float RGBA, premultiplied; depth");
    printf("\nColour maps\n ");
    const char *name;
    int column = 1;
    for (size_t i = 0; (name = pel_colormap_name(i)); i++) {
        if (column > 80)
            column = printf("\n ") - 1;
        column += printf(" %s", name);
    }
    printf("\n  and ParaView's .json and .xml files\n");
    return tool_finish_stdout(EXIT_FINE);
}

const struct command command_formats = {
    .name = "formats",
    .summary = "List the file formats and the colour maps",
    .usage = "",
    .run = run,
};

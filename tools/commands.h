/* SPDX-License-Identifier: MIT */
/* The commands; each is a file of its name. A new one is that file, a line here and a line in the list in main.c. */
#ifndef TOOL_COMMANDS_H
#define TOOL_COMMANDS_H

#include "tool.h"

extern const struct command command_info, command_render, command_convert, command_compare, command_make, command_mesh, command_bench,
    command_techniques, command_devices, command_formats, command_options, command_completion, command_man;
#ifdef HAVE_VIEWER
extern const struct command command_view, command_replay;
#endif

#endif

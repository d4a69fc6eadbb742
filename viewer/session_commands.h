/* SPDX-License-Identifier: MIT */
#ifndef VIEWER_SESSION_COMMANDS_H
#define VIEWER_SESSION_COMMANDS_H

#include "session_inside.h"

/* Finds the command of that name, checks its keys and runs it. With the lock held. */
bool session_command_run(struct call *call);

#endif

// Runs the program's main function in child processes of a server. The server is forked before the first test: after a
// fork, the child of a process with threads may only call async-signal-safe functions. Cost: a run begins after some
// 10 ms, and after 90 ms where a child executes the program, whose loader binds the 60,000 symbols of OpenVDB.
#pragma once

#include "tool_call.h"

namespace kiln::test {

/// Descriptor of the server's socket, which executed programs do not inherit. Returns -1 in tests that do not link the
/// program's main function.
int toolServer();

/// Loads what each child would load at its first use. requires: called before a server is forked.
void loadForChildren();

}  // namespace kiln::test

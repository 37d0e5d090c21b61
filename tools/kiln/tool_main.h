// The program as a function, which the program and tests call.
#pragma once

/// Reads the command line, runs one command and returns the exit code: 0 done, 1 data or system, 2 command line. Prints
/// each failure as one line.
int kilnToolMain(int argc, char** argv);

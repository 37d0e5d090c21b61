// The program. Tests link all of it but this file.
#include "tool_main.h"

int main(int argc, char** argv) { return kilnToolMain(argc, argv); }

// Opens an address in the user's browser.
#pragma once

#include <string>

namespace kiln::tool {

/// Opens the address by xdg-open, where a desktop is there and standard output is a terminal; else does nothing. The
/// address is an argument of another program of the user's for a moment.
void openBrowser(const std::string& address);

/// Makes SIGHUP, which the end of a terminal sends, request a stop, unless the process was started to survive (nohup).
void endWithTerminal();

/// True once the terminal of standard output is gone. False if standard output is no terminal.
bool terminalIsGone();

}  // namespace kiln::tool

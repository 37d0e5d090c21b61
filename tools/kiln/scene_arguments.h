// Values of options that say what a picture shows, as the command line writes them.
#pragma once

#include <string>

#include "scene/transfer_function_choice.h"

namespace kiln::tool {

/// A preset or a file that exists. throws: Error kUsage naming `option` and the presets.
TransferFunctionChoice transferFunctionNamed(const std::string& text, const char* option);
/// "CENTRE,WIDTH". throws: Error kUsage naming `option`.
Window parseWindow(const std::string& text, const char* option);

}  // namespace kiln::tool

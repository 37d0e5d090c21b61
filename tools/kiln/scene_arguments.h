// Values on the command lines of commands without a job.
#pragma once

#include <string>

#include "job/transfer_function_choice.h"

namespace kiln::tool {

/// A preset, points, or a file that exists. throws: Error kUsage naming `option` and the presets.
TransferFunctionChoice transferFunctionNamed(const std::string& text, const char* option);
/// "CENTRE,WIDTH". throws: Error kUsage naming `option`.
Window parseWindow(const std::string& text, const char* option);

}  // namespace kiln::tool

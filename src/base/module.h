// Libraries that few runs need are in modules beside the program, loaded by whoever needs them: the program starts
// without them, and who links Kiln's library does not link them.
#pragma once

#include <string_view>

namespace kiln {

/// A function of a module, which is found as the program's own libraries are and stays until the process ends. throws:
/// Error kUnsupported where it is not there, saying `so_that` what is not possible. thread: safe.
void* functionOfModule(const char* module, const char* function, std::string_view so_that);

}  // namespace kiln

// Loads optional libraries (modules) at first use. The program starts without modules, and a program that
// links Kiln does not link modules.
#pragma once

#include <filesystem>
#include <string_view>

namespace kiln {

/// Returns a function of a module, found by the search path of the program's libraries. The module stays loaded until
/// the process ends. throws: Error kUnsupported if the module or function is missing; `so_that` names the consequence.
/// std::bad_alloc if the system refuses memory. thread: safe.
void* functionOfModule(const char* module, const char* function, std::string_view so_that);

/// Returns the program `name` that lies beside Kiln's modules. throws: Error kUnsupported if the program is missing.
std::filesystem::path programBesideModules(const char* name, std::string_view so_that);

}  // namespace kiln

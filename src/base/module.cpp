#include "base/module.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include "base/error.h"

namespace kiln {

void* functionOfModule(const char* module, const char* function, std::string_view so_that) {
  // Never closed: the module registers exit handlers.
  void* const opened = ::dlopen(module, RTLD_NOW | RTLD_LOCAL);
  if (opened == nullptr)
    throw Error(ErrorCode::kUnsupported, module, "",
                fmt::format("cannot be loaded, so that {} ({}); install Kiln with its modules", so_that, ::dlerror()));
  void* const found = ::dlsym(opened, function);
  if (found == nullptr)
    throw Error(ErrorCode::kUnsupported, module, "", "belongs to another version of Kiln; reinstall Kiln");
  return found;
}

}  // namespace kiln

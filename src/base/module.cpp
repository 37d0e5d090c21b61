#include "base/module.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include "base/error.h"

namespace kiln {

void* functionOfModule(const char* module, const char* function, std::string_view so_that) {
  // Never closed: exit handlers are in it.
  void* const opened = ::dlopen(module, RTLD_NOW | RTLD_LOCAL);
  if (opened == nullptr)
    throw Error(ErrorCode::kUnsupported, module, "",
                fmt::format("cannot be loaded, so that {} ({}); install Kiln with its modules", so_that, ::dlerror()));
  void* const found = ::dlsym(opened, function);
  if (found == nullptr)
    throw Error(ErrorCode::kUnsupported, module, "", "is not of this version of Kiln; install it anew");
  return found;
}

}  // namespace kiln

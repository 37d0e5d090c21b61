#include "base/module.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>

#include <cstddef>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "base/error.h"

namespace kiln {
namespace {

// The loader has no code for a system that refuses memory, only texts: glibc's "failed to map segment from shared
// object", and "Cannot allocate memory" behind others.
bool saysNoMemory(std::string_view text) {
  return text.find("map segment") != std::string_view::npos || text.find("allocate") != std::string_view::npos;
}

}  // namespace

void* functionOfModule(const char* module, const char* function, std::string_view so_that) {
  // Never closed: the module registers exit handlers.
  void* const opened = ::dlopen(module, RTLD_NOW | RTLD_LOCAL);
  if (opened == nullptr) {
    const std::string said = ::dlerror();
    if (saysNoMemory(said)) throw std::bad_alloc();
    throw Error(ErrorCode::kUnsupported, module, "",
                fmt::format("cannot be loaded, so that {} ({}); install Kiln with its modules", so_that, said));
  }
  void* const found = ::dlsym(opened, function);
  if (found == nullptr)
    throw Error(ErrorCode::kUnsupported, module, "", "belongs to another version of Kiln; reinstall Kiln");
  return found;
}

// Modules and programs lie in the folders in which the loader looks for libraries of this code.
std::filesystem::path programBesideModules(const char* name, std::string_view so_that) {
  Dl_info info;
  link_map* map = nullptr;
  Dl_serinfo size;
  const bool known = ::dladdr1(reinterpret_cast<void*>(&programBesideModules), &info, reinterpret_cast<void**>(&map),
                               RTLD_DL_LINKMAP) != 0 &&
                     ::dlinfo(map, RTLD_DI_SERINFOSIZE, &size) == 0;
  std::vector<std::byte> room(known ? size.dls_size : 0);
  auto* const folders = reinterpret_cast<Dl_serinfo*>(room.data());
  if (known) *folders = size;
  if (known && ::dlinfo(map, RTLD_DI_SERINFO, folders) == 0) {
    for (unsigned i = 0; i < folders->dls_cnt; ++i) {
      const std::filesystem::path program = std::filesystem::path(folders->dls_serpath[i].dls_name) / name;
      std::error_code ignored;
      if (program.is_absolute() && std::filesystem::is_regular_file(program, ignored)) return program;
    }
  }
  throw Error(ErrorCode::kUnsupported, name, "",
              fmt::format("is not beside Kiln's modules, so that {}; install Kiln with its modules", so_that));
}

}  // namespace kiln

// The files of the page, compiled into the module by cmake/embed_page.cmake.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace kiln {

struct PageFile {
  std::string_view name;
  std::span<const std::byte> bytes;
};

std::span<const PageFile> pageFiles();

}  // namespace kiln

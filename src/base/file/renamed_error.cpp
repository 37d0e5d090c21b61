#include "base/file/renamed_error.h"

#include "base/text.h"

namespace kiln {

Error renamed(const Error& error, const std::filesystem::path& from, const std::filesystem::path& to) {
  const std::string text = error.what(), prefix = shown(from.string()) + ": ";
  if (!text.starts_with(prefix)) return error;
  return Error(error.code(), to, "", text.substr(prefix.size()));
}

}  // namespace kiln

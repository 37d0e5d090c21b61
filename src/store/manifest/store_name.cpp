#include "store/manifest/store_name.h"

#include "base/file/path_name.h"

namespace kiln {

std::string volumeNameOf(const std::filesystem::path& store) {
  std::string out = withoutTrailingSlash(store).stem().string();
  const std::size_t dash = out.rfind('-');
  if (dash == std::string::npos || dash == 0) return out;
  const std::string_view hash = std::string_view(out).substr(dash + 1);
  const bool hashed = hash.size() == kStoreHashDigits && hash.find_first_not_of("0123456789abcdef") == hash.npos;
  if (hashed) out.resize(dash);
  return out;
}

}  // namespace kiln

#include "ingest/source/listed_volume.h"

namespace kiln {

std::uint64_t ListedVolume::bytes() const {
  if (!dims || !type) return 0;
  std::uint64_t out = sizeOf(*type);
  for (int axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::uint64_t>((*dims)[axis]);
    if (n != 0 && out > UINT64_MAX / n) return UINT64_MAX;
    out *= n;
  }
  return out;
}

std::string nameOfStack(const std::vector<std::filesystem::path>& stack) {
  const std::string first = stack.front().filename().string();
  return stack.size() == 1 ? first : first + " to " + stack.back().filename().string();
}

}  // namespace kiln

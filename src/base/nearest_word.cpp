#include "base/nearest_word.h"

#include <algorithm>
#include <vector>

namespace kiln {
namespace {

std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string_view nearestWord(std::string_view word, std::span<const std::string_view> known) {
  return *std::min_element(known.begin(), known.end(), [&](std::string_view a, std::string_view b) {
    return editDistance(word, a) < editDistance(word, b);
  });
}

std::optional<std::string_view> meantWord(std::string_view word, std::span<const std::string_view> known) {
  if (word.empty() || known.empty()) return std::nullopt;
  for (const std::string_view name : known) {
    if (name.starts_with(word)) return name;
  }
  const std::string_view nearest = nearestWord(word, known);
  // A third admits two exchanged letters in words as short as "mip".
  const bool near = editDistance(word, nearest) <= 1 + word.size() / 3;
  if (near) return nearest;
  const auto begun =
      std::ranges::find_if(known, [&](std::string_view name) { return !name.empty() && word.starts_with(name); });
  return begun == known.end() ? std::nullopt : std::optional(*begun);
}

std::string meantWordHint(std::string_view word, std::span<const std::string_view> known) {
  const auto meant = meantWord(word, known);
  return meant ? "; did you mean '" + std::string(*meant) + "'?" : "";
}

}  // namespace kiln

#include "export/source/numbered_name.h"

#include <fmt/format.h>

#include <limits>

#include "base/text.h"

namespace kiln {

bool NumberedName::isPattern(const std::filesystem::path& path) {
  return path.filename().string().find('#') != std::string::npos;
}

NumberedName::NumberedName(const std::filesystem::path& pattern) : folder_(pattern.parent_path()) {
  const std::string name = pattern.filename().string();
  const std::size_t last = name.find_last_of('#'), before = name.find_last_not_of('#', last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  before_ = name.substr(0, first);
  width_ = last + 1 - first;
  behind_ = name.substr(last + 1);
}

std::string NumberedName::name(std::int64_t number) const {
  return fmt::format("{}{:0{}}{}", before_, number, width_, behind_);
}

bool NumberedName::isOther(const std::string& other, std::int64_t first, std::int64_t end) const {
  const std::optional<std::int64_t> number = numberIn(other);
  return number && (*number < first || *number >= end || name(*number) != other);
}

std::optional<std::int64_t> NumberedName::numberIn(const std::string& name) const {
  if (name.size() <= before_.size() + behind_.size() || !name.starts_with(before_) || !name.ends_with(behind_))
    return std::nullopt;
  const std::string number = name.substr(before_.size(), name.size() - before_.size() - behind_.size());
  if (number.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  return numberOf<std::int64_t>(number).value_or(std::numeric_limits<std::int64_t>::max());
}

}  // namespace kiln

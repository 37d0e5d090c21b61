// The description of a foreign volume in the words of a command line or a call: SourceOptions as texts.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "ingest/source/volume_source.h"

namespace kiln {

/// Empty members are not given.
struct SourceWords {
  std::string dims, type, endian, spacing, grid, series, flip, orient, up, unit;
  std::optional<std::string> channel;
  std::optional<std::int64_t> time, scale;
  std::uint64_t skip = 0;
  bool allow_irregular = false, luminance = false;
  /// Returns true if a word is given.
  bool any() const { return !(*this == SourceWords()); }
  bool operator==(const SourceWords&) const = default;
  /// throws: Error kUsage naming the option.
  SourceOptions resolve() const;
};

/// Returns the three numbers of "a,b,c". throws: Error kUsage naming `option`.
glm::dvec3 tripleOfText(const std::string& text, const char* option);

}  // namespace kiln

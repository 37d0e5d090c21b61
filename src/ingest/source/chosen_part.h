// The one volume that a user chose of a file of several channels, times or resolutions.
#pragma once

#include <span>
#include <string>

#include "base/error.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// The refusal of a file of several parts, none of which the user chose. A list of volumes names the parts instead.
class UnchosenPart : public Error {
 public:
  /// `part`: "time" or "channel". `names`: the text behind the count, ": 0 ('T1'), 1"; empty for times.
  UnchosenPart(const char* part, const std::filesystem::path& file, std::int64_t count, const std::string& names);
  const std::string& part() const { return part_; }
  /// Returns the count and the names: "4 times", "2 channels: 0 ('w'), 1 ('v')".
  const std::string& parts() const { return parts_; }

 private:
  std::string part_, parts_;
};

/// Returns the number of the chosen time; 0 if the file has one time and the user chose none.
/// throws: UnchosenPart, with the legal numbers, if there are several and none is chosen; Error kUsage if the number is
/// too large.
std::int64_t chosenTime(const SourceOptions& options, std::int64_t count, const std::filesystem::path& file);

/// Returns the number of the chosen channel, by its number or its name; an empty name is no name. A name that is a
/// number counts as a number. throws: as chosenTime, with the names.
std::int64_t chosenChannel(const SourceOptions& options, std::span<const std::string> names,
                           const std::filesystem::path& file);

/// Returns the number of the chosen resolution; 0, the finest, without a choice. throws: Error kUsage if the number is
/// too large.
std::int64_t chosenScale(const SourceOptions& options, std::int64_t count, const std::filesystem::path& file);

/// Returns ", time 2" for SourceInfo::format; empty if there is one part only.
std::string partOf(const char* kind, std::int64_t part, std::int64_t count);

}  // namespace kiln

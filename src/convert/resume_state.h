// Decides where a conversion begins: with no bricks, or with the bricks of an earlier conversion of the volume. The
// first rank looks and shares the result.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/file/file.h"
#include "cluster/ranks.h"
#include "convert/convert.h"
#include "convert/resume/journal.h"
#include "convert/resume/output_directory.h"

namespace kiln {

struct ResumeState {
  bool finished = false;  // by an earlier conversion
  std::filesystem::path directory;
  ConversionIdentity identity;  // of the resumed conversion, else of this conversion
  std::uint64_t noted = 0;      // bricks in the journal of an earlier conversion
};

/// Collective. Verifies that all ranks read equal volumes: local disks of ranks may have different files. throws: Error
/// kFormat.
void requireSameSource(const SourceInfo& info, const Manifest& draft, Ranks& ranks);

/// Examines the destination, on the first rank; the other ranks get the result by `share`. throws: Error kExists if
/// an earlier conversion was of another volume.
ResumeState beginAt(OutputDirectory& destination, const Manifest& draft, const ConvertOptions& options,
                    const Ranks& ranks, FileSystem& disk);

/// Collective. Copies the first rank's state to all ranks.
void share(ResumeState& state, Ranks& ranks);

}  // namespace kiln

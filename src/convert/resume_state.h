// Where a conversion begins: with nothing, or with what an earlier one of the same volume left. One rank looks, all
// know.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "base/file.h"
#include "cluster/ranks.h"
#include "convert/convert.h"
#include "convert/resume/journal.h"
#include "convert/resume/output_directory.h"

namespace kiln {

struct ResumeState {
  bool finished = false;  // by an earlier conversion
  std::filesystem::path directory;
  ConversionIdentity identity;  // of an earlier conversion that goes on, else of this one
  std::uint64_t noted = 0;      // bricks in the journal of an earlier conversion
};

/// Collective. Whether all ranks are about to read the same volume: a file that each finds on a disk of its own may
/// differ. throws: Error kFormat.
void requireSameSource(const SourceInfo& info, const Manifest& draft, Ranks& ranks);

/// What is at the destination. On the first rank; the others get it by `share`. throws: Error kExists where an earlier
/// conversion was of another volume.
ResumeState beginAt(OutputDirectory& destination, const Manifest& draft, const ConvertOptions& options,
                    const Ranks& ranks, FileSystem& disk);

/// Collective. Gives all ranks what the first has.
void share(ResumeState& beginning, Ranks& ranks);

}  // namespace kiln

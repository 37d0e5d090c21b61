// What of an earlier conversion is still true.
#pragma once

#include <filesystem>
#include <functional>

#include "base/progress.h"
#include "cluster/ranks.h"
#include "convert/resume/journal.h"

namespace kiln {

/// Collective. Calls keep(brick), on all ranks in the same order, for the bricks of the first rank's journal whose
/// files in `directory` are whole; a brick may come twice, and its counts are left out. The ranks share the reading.
/// memory: some thousand bricks, however many the journal has. throws: Error kCancelled, kIo.
void forEachWholeBrick(const std::filesystem::path& directory, Ranks& ranks, Progress& progress,
                       const std::function<void(const FinishedBrick&)>& keep);

}  // namespace kiln

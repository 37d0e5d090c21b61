// Finds the bricks of an earlier conversion that are still valid.
#pragma once

#include <filesystem>
#include <functional>

#include "base/progress.h"
#include "cluster/ranks.h"
#include "convert/resume/journal.h"

namespace kiln {

/// Collective. Calls keep(brick), on all ranks in equal order, for the bricks of the first rank's journal whose files
/// in `directory` are whole. A brick may come twice, and its counts are empty. The ranks share the reading.
/// memory: some thousand bricks, whatever the length of the journal. throws: Error kCancelled, kIo.
void forEachWholeBrick(const std::filesystem::path& directory, Ranks& ranks, Progress& progress,
                       const std::function<void(const FinishedBrick&)>& keep);

}  // namespace kiln

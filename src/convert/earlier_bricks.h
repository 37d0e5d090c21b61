// What of an earlier conversion is still true.
#pragma once

#include <filesystem>
#include <vector>

#include "base/progress.h"
#include "cluster/ranks.h"
#include "convert/journal.h"

namespace kiln {

/// Collective, with the same bricks on all ranks. Of bricks that a journal notes, those whose files in
/// `directory` are whole, each once; the ranks share the reading. throws: Error kCancelled.
std::vector<FinishedBrick> wholeBricksOf(const std::vector<FinishedBrick>& noted,
                                         const std::filesystem::path& directory, Ranks& ranks, Progress& progress);

/// Collective. What the first rank's journal says, on all.
void shareBricks(std::vector<FinishedBrick>& noted, Ranks& ranks);

}  // namespace kiln

// Lists the properties that ranks must have in common to draw one job (cluster/agreement.h).
#pragma once

#include <vector>

#include "cluster/agreement.h"
#include "sequence/sequence.h"

namespace kiln {

/// The facts that decide which messages ranks send one another: frames, volumes, distribution, outputs. No store is
/// opened.
std::vector<RankFact> jobFacts(const RenderJob& job, const SequenceOptions& options);

/// For each frame: the manifest of every volume, and everything that decides the bytes of the frame's files.
/// cost: reads the manifest of each volume of a time series. throws: Error kNotFound, kFormat, kDamaged, kUsage for a
/// job of one frame; an error of one of several frames is that frame's fact.
std::vector<RankFact> frameFacts(const RenderJob& job, const StoreFor& stores);

}  // namespace kiln

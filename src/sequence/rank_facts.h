// Lists the properties that ranks must share to draw one job (cluster/agreement.h).
#pragma once

#include <vector>

#include "cluster/agreement.h"
#include "sequence/sequence.h"

namespace kiln {

/// Returns the facts that decide the messages between ranks: frames, volumes, distribution, outputs. Opens no store.
std::vector<RankFact> jobFacts(const RenderJob& job, const SequenceOptions& options);

/// Returns, for each frame, the manifest of every volume and all that decides the bytes of the frame's files. An error
/// of one of several frames is a fact of the frame. cost: reads the manifest of each volume of a time series. throws:
/// Error kNotFound, kFormat, kDamaged, kUsage for a job of one frame.
std::vector<RankFact> frameFacts(const RenderJob& job, const StoreFor& stores);

}  // namespace kiln

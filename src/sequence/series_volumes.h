// Finds the volumes by which all frames of a time series are framed and coloured. The files on the disk decide, not the
// frames of a command: ranks, resumed runs and parts of the frames choose alike.
#pragma once

#include <memory>
#include <optional>
#include <set>

#include "cluster/ranks.h"
#include "job/frame/series_look.h"
#include "sequence/sequence_frames.h"

namespace kiln {

/// The numbers of existing files or directories of the pattern, ascending. Empty if the pattern has no place for a
/// number.
std::vector<int> framesOnDisk(const std::filesystem::path& pattern);

/// Returns the names of a volume in all frames; also of the first frame on the disk, which decides how a series looks.
std::set<std::filesystem::path> namesInFrames(const RenderJob& job, const std::filesystem::path& pattern);
/// Returns the names, in all frames, of volumes that hold labels, masks included.
std::set<std::filesystem::path> labelVolumesOf(const RenderJob& job);

/// Joins the manifests of all frames on the disk if all are stores. Else the first frame decides: boxes and values of
/// foreign files are known after conversion only (by `store_for`). With `resume`, the frames named in headers of the
/// job's earlier pictures decide: later frames change no look. Null for a job without a series. Collective if `ranks`
/// are several: the first rank looks at the disk for all. throws: Error kNotFound if no frame exists; as readManifest
/// and `store_for`.
std::shared_ptr<const SeriesLook> seriesLook(const RenderJob& job, const StoreFor& store_for, bool resume = false,
                                             Ranks* ranks = nullptr);

}  // namespace kiln

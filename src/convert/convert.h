// A foreign volume becomes a brick store: read box by box, cut into bricks, encoded on all cores, written once.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "base/file.h"
#include "base/progress.h"
#include "ingest/source/volume_source.h"
#include "store/manifest/manifest.h"

namespace kiln {

class FileLock;
class Ranks;

struct ConvertOptions {
  /// A power of two from 8.
  std::int64_t brick_size = kDefaultBrickSize;
  /// The most memory the conversion may hold in its buffers. unit: bytes.
  std::uint64_t memory_bytes = 2ull << 30;
  /// Replace a store that is there; it stays whole until the new one is.
  bool overwrite = false;
  /// Go on with what an interrupted conversion of the same source with the same options left; the result has the bytes
  /// of an uninterrupted one. Where there is nothing to go on with, begin; a finished store is left as it is. With
  /// `overwrite`, what cannot be gone on with is replaced.
  bool resume = false;
  /// The means of the coarser levels are rounded to half. It is for a source that is (HalfSource): their bricks are
  /// smaller then, too.
  bool half = false;
  /// Values are names and not amounts: a coarser voxel is the most frequent below it. requires: whole numbers.
  bool labels = false;
  /// The most levels of the pyramid, the finest included.
  int most_levels = std::numeric_limits<int>::max();
  /// The lock on the output (lockOf), where the caller holds it. Null: `convert` takes it, and refuses an output that
  /// another process is making.
  const FileLock* lock = nullptr;
  /// What the manifest says of its making.
  std::string command, time;
  /// The processes that share the work, each of which calls `convert` alike, with a source of its own of the same
  /// volume and the same directory to write to; this one alone where null. The store has the same bytes for any number.
  Ranks* ranks = nullptr;
};

/// What one process has done.
struct RankConversion {
  std::uint64_t lanes = 0;
  std::uint64_t bricks = 0;         // of all levels
  std::uint64_t read_bytes = 0;     // of voxels, as the source gave them
  std::uint64_t written_bytes = 0;  // of brick files
  std::uint64_t sent_bytes = 0;     // to other ranks
  double busy_s = 0, idle_s = 0;    // of all its lanes together
};

struct ConvertReport {
  std::uint64_t voxels = 0;  // of the volume, but for the share of bricks that an earlier run finished
  std::uint64_t bricks = 0, stored_bricks = 0;
  std::uint64_t stored_bytes = 0;
  std::uint64_t nan_count = 0;
  std::uint64_t buffer_bytes = 0;  // the most the conversion planned to hold
  double half_error = 0;           // the largest change of a mean by `half`. unit: the volume's values
  double seconds = 0;
  std::vector<RankConversion> ranks;  // by rank
};

/// Converts `source` to a store at `out`. On any error nothing that could be taken for a store is left at `out`, and a
/// store that was there before is untouched. After an interrupt, a full disk or a failing one the finished bricks are
/// kept for `resume`, and a note says where; after any other error nothing is left. Of several processes one that fails
/// is to end all (cluster/ranks.h), and what they left is kept for `resume` whatever the error was. The report is the
/// first rank's; on the others it is empty.
/// throws: Error kExists (also where another process writes to `out`), kBudget (naming the smallest memory that works),
/// kUsage (brick size, labels that are no whole numbers), and what the source and the disk throw.
ConvertReport convert(VolumeSource& source, const std::filesystem::path& out, const ConvertOptions& options,
                      Progress& progress, FileSystem& disk = FileSystem::real());

}  // namespace kiln

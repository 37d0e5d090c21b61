// Converts a foreign volume to a brick store: reads boxes, cuts bricks, encodes on all cores, writes each file once.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "base/progress.h"
#include "ingest/source/volume_source.h"
#include "store/manifest/manifest.h"

namespace kiln {

class FileLock;
class FileSystem;
class Ranks;

struct ConvertOptions {
  /// A power of two from 8 to 4096.
  std::int64_t brick_size = kDefaultBrickSize;
  /// Upper bound for the buffers of the conversion. unit: bytes.
  std::uint64_t memory_bytes = 2ull << 30;
  /// Replaces an existing store, which stays whole until the new store is complete.
  bool overwrite = false;
  /// Resumes an interrupted conversion of the same source with equal options; the result is byte-equal to an
  /// uninterrupted conversion. Begins anew if there is nothing to resume; leaves a finished store as it is. With
  /// `overwrite`, replaces anything that cannot be resumed.
  bool resume = false;
  /// Rounds the means of the coarser levels to half floats, for smaller bricks. Meant for rounded sources (HalfSource).
  bool half = false;
  /// Values are labels, not amounts: a coarser voxel is the most frequent label below it. requires: whole numbers.
  bool labels = false;
  /// Upper bound for the levels of the pyramid, the finest included.
  int most_levels = std::numeric_limits<int>::max();
  /// The lock on the output (lockOf), if the caller holds it. Null: `convert` takes the lock, and refuses an output
  /// that another process is making.
  const FileLock* lock = nullptr;
  /// Command and time of the conversion, recorded in the manifest.
  std::string command, time;
  /// The processes of a parallel conversion; null for a single process. Each process calls `convert` with equal
  /// arguments, and with a source object for the shared volume. The store has equal bytes for any number of processes.
  Ranks* ranks = nullptr;
  FileSystem* disk = nullptr;  // null: the operating system's
};

/// The work done by a process.
struct RankConversion {
  std::uint64_t lanes = 0;
  std::uint64_t bricks = 0;         // bricks of all levels
  std::uint64_t read_bytes = 0;     // voxels delivered by the source
  std::uint64_t written_bytes = 0;  // bytes of brick files
  std::uint64_t sent_bytes = 0;     // bytes sent to other ranks
  double busy_s = 0, idle_s = 0;    // summed over all lanes
};

struct ConvertReport {
  std::uint64_t voxels = 0;  // voxels of the volume, less the share of bricks finished by an earlier run
  std::uint64_t bricks = 0, stored_bricks = 0;
  std::uint64_t stored_bytes = 0;
  std::uint64_t nan_count = 0;
  std::uint64_t buffer_bytes = 0;  // planned memory of the buffers
  double decodings = 0;            // of a block of the source, on average; 0 if it decodes no blocks
  double half_error = 0;           // largest rounding of a mean of rounded values. unit: the volume's values
  double seconds = 0;
  std::vector<RankConversion> ranks;  // by rank
};

/// Returns whether the store will hold labels, by the options or by the header of the source.
bool makesLabels(const SourceInfo& info, const ConvertOptions& options);

/// Converts `source` to a store at `out`. On any error nothing at `out` can be mistaken for a store, and an existing
/// store is untouched. After an interrupt or a disk failure (also a full disk) the finished bricks are kept for
/// `resume`, and a note names their place. After any other error nothing is left.
/// With several processes, a failed process must end all (cluster/ranks.h); finished bricks are kept after any error.
/// The report is complete on the first rank and empty on the others.
/// throws: Error kExists (also if another process writes to `out`), kBudget (naming the smallest memory that works),
/// kUsage (brick size, labels that are no whole numbers or to be rounded), and the exceptions of source and disk.
ConvertReport convert(VolumeSource& source, const std::filesystem::path& out, const ConvertOptions& options,
                      Progress& progress);

}  // namespace kiln

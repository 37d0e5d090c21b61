// Values of a volume file, from a part of its voxels: a histogram without a conversion.
//
// Method. Sources that are read at any place are sampled in boxes of the shape that costs least (cheapBox). The boxes
// follow the multiples of the golden ratio: evenly spread for any number of boxes, and aligned with no lattice. Small
// volumes are read whole. Compressed streams are read from their begin.
#pragma once

#include "base/progress.h"
#include "ingest/source/volume_source.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Bounds of a sample: voxels of sources read at any place, and of streams, which are inflated first. unit: bytes.
inline constexpr std::uint64_t kSampleBytes = 64ull << 20, kStreamSampleBytes = 256ull << 20;

struct VolumeSample {
  /// Describes the volume as a store of one level; range and histogram are those of the sample.
  Manifest manifest;
  /// Voxels counted, NaN included.
  std::uint64_t voxels = 0;
  /// True if the voxels are the first of a stream, which is longer.
  bool from_begin = false;
};

/// Samples a source from which nothing was read. throws: Error kBudget if a box and its decoding take more than
/// `memory_bytes`; the exceptions of the source. cost: about a second.
VolumeSample sampleOf(VolumeSource& source, std::uint64_t memory_bytes, Progress& progress);

}  // namespace kiln

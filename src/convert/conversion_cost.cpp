#include "convert/conversion_cost.h"

#include <algorithm>
#include <chrono>

#include "base/elapsed.h"
#include "cluster/ranks.h"
#include "grid/pyramid.h"
#include "store/brick_index.h"
#include "store/codec/brick_codec.h"
#include "store/codec/brick_ranges.h"

namespace kiln {
namespace {

constexpr std::int64_t kSamples = 8;
// Time limit for the sample of a stream. unit: seconds.
constexpr double kStreamSeconds = 2;

using Clock = std::chrono::steady_clock;

// Returns the voxels of all bricks of a level with their aprons: each inner border has an apron on both sides.
std::uint64_t storedVoxels(const Extent3& dims, const Extent3& bricks) {
  std::uint64_t out = 1;
  for (int axis = 0; axis < 3; ++axis) out *= static_cast<std::uint64_t>(dims[axis] + 2 * kApron * (bricks[axis] - 1));
  return out;
}

struct Samples {
  std::uint64_t bricks = 0, stored_bricks = 0, stored_voxels = 0, file_bytes = 0;
  double seconds = 0;       // reading and encoding; for a stream, encoding alone
  std::int64_t slices = 0;  // slices read from a stream,
  double slices_s = 0;      // and the reading time

  void encode(const BrickDesc& frame, std::span<const std::byte> voxels) {
    const BrickRanges ranges = rangesOf(frame, voxels);
    const bool constant =
        std::equal(voxels.begin() + static_cast<std::ptrdiff_t>(sizeOf(frame.type)), voxels.end(), voxels.begin());
    if (!constant) file_bytes += encodeBrick(frame, voxels, ranges.cells).size();
    stored_bricks += constant ? 0 : 1;
    stored_voxels += static_cast<std::uint64_t>(frame.stored().count());
    ++bricks;
  }
};

// Samples bricks in sequence on a single thread, like a lane of a conversion.
Samples sampleBricks(VolumeSource& source, const ConvertOptions& options, Progress& progress) {
  const SourceInfo& info = source.info();
  const Extent3 lattice = brickLattice(info.geometry.dims, options.brick_size);
  const std::int64_t count = std::min(lattice.count(), kSamples);
  Samples out;
  const auto begin = Clock::now();
  for (std::int64_t i = 0; i < count; ++i) {
    progress.throwIfCancelled("sampling");
    const BrickKey key{0, brickAt(lattice, (2 * i + 1) * lattice.count() / (2 * count))};
    const BrickDesc frame{key, info.type, options.brick_size, kApron, info.geometry};
    const VoxelBox box = frame.stored();
    std::vector<std::byte> voxels(static_cast<std::size_t>(box.count()) * sizeOf(info.type));
    source.read(box, voxels);
    out.encode(frame, voxels);
  }
  out.seconds = secondsSince(begin);
  return out;
}

// Samples bricks of the first layer, as deep as the stream is read. Reads row by row, because a slice may exceed the
// memory.
Samples sampleStream(VolumeSource& source, const ConvertOptions& options, Progress& progress) {
  const SourceInfo& info = source.info();
  const auto size = static_cast<std::ptrdiff_t>(sizeOf(info.type));
  VolumeGeometry geometry = info.geometry;
  const Extent3 dims = geometry.dims, lattice = brickLattice({dims.x, dims.y, 1}, options.brick_size);
  const std::int64_t edge = options.brick_size + 2 * kApron, brick_bytes = edge * edge * edge * size;
  const std::int64_t affordable = static_cast<std::int64_t>(options.memory_bytes / 2) / brick_bytes;
  const std::int64_t count = std::clamp<std::int64_t>(affordable, 1, std::min(lattice.count(), kSamples));
  const auto frameOf = [&](std::int64_t i) {
    const BrickKey key{0, brickAt(lattice, (2 * i + 1) * lattice.count() / (2 * count))};
    return BrickDesc{key, info.type, options.brick_size, kApron, geometry};
  };
  std::vector<VoxelBox> boxes;
  for (std::int64_t i = 0; i < count; ++i) boxes.push_back(frameOf(i).stored());
  std::vector<std::vector<std::byte>> bricks(boxes.size());
  std::vector<std::byte> row(static_cast<std::size_t>(dims.x * size));
  Samples out;
  const auto begin = Clock::now();
  for (; out.slices < std::min(dims.z, options.brick_size + kApron) && out.slices_s < kStreamSeconds; ++out.slices) {
    progress.throwIfCancelled("sampling");
    for (std::int64_t y = 0; y < dims.y; ++y) {
      source.read({{0, y, out.slices}, {dims.x, y + 1, out.slices + 1}}, row);
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        const VoxelBox& box = boxes[i];
        if (y < box.lo.y || y >= box.hi.y) continue;
        bricks[i].insert(bricks[i].end(), row.begin() + box.lo.x * size, row.begin() + box.hi.x * size);
      }
    }
    out.slices_s = secondsSince(begin);
  }
  // Encodes the bricks as if the volume ended here.
  geometry.dims.z = out.slices;
  const auto encoding = Clock::now();
  for (std::int64_t i = 0; i < count; ++i) {
    const BrickDesc frame = frameOf(i);
    std::vector<std::byte>& voxels = bricks[static_cast<std::size_t>(i)];
    voxels.resize(static_cast<std::size_t>(frame.stored().count() * size));
    out.encode(frame, voxels);
  }
  out.seconds = secondsSince(encoding);
  return out;
}

}  // namespace

ConversionCost conversionCost(VolumeSource& source, const ConvertOptions& options, Progress& progress) {
  const SourceInfo& info = source.info();
  ConversionCost out;
  requireRoomForIndex(info, options);
  out.plan = planConversion(source, options);
  out.order = source.order();
  const std::vector<VolumeGeometry> levels = pyramidOf(info.geometry, options.brick_size, options.most_levels);
  out.levels = static_cast<int>(levels.size());
  std::uint64_t stored_voxels = 0;
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const Extent3 lattice = brickLattice(levels[level].dims, options.brick_size);
    out.bricks += static_cast<std::uint64_t>(lattice.count());
    stored_voxels += storedVoxels(levels[level].dims, lattice);
  }
  const bool stream = out.order == ReadOrder::kForward;
  const Samples samples = stream ? sampleStream(source, options, progress) : sampleBricks(source, options, progress);
  out.sampled_bricks = samples.bricks;
  out.sampled_slices = samples.slices;
  const double all_to_samples = static_cast<double>(stored_voxels) / static_cast<double>(samples.stored_voxels);
  const double stored_share = static_cast<double>(samples.stored_bricks) / static_cast<double>(samples.bricks);
  const auto stored = static_cast<std::uint64_t>(stored_share * static_cast<double>(out.bricks));
  out.store_bytes = static_cast<std::uint64_t>(static_cast<double>(samples.file_bytes) * all_to_samples) +
                    BrickIndex::fileBytes(stored, out.bricks - stored, options.brick_size);
  // Coarser levels cost mostly encoding, proportional to the number of voxels.
  const double lanes_s = samples.seconds * all_to_samples;
  const double stream_s =
      stream ? samples.slices_s * static_cast<double>(info.geometry.dims.z) / static_cast<double>(samples.slices) : 0;
  // A stream is read by a single thread at a time, and by every rank from begin to end.
  const double ranks = options.ranks != nullptr ? options.ranks->count() : 1;
  out.seconds = std::max(stream_s, (stream_s + lanes_s / ranks) / static_cast<double>(out.plan.lanes));
  return out;
}

}  // namespace kiln

#include "convert/conversion_cost.h"

#include <algorithm>
#include <chrono>
#include <random>

#include "grid/pyramid.h"
#include "store/brick_codec.h"
#include "store/brick_index.h"
#include "store/brick_ranges.h"

namespace kiln {
namespace {

constexpr std::int64_t kSamples = 8;

Extent3 latticeOf(const Extent3& dims, std::int64_t brick_size) {
  return {(dims.x + brick_size - 1) / brick_size, (dims.y + brick_size - 1) / brick_size,
          (dims.z + brick_size - 1) / brick_size};
}

// The voxels of all bricks of a level with their aprons: along an axis, an apron on both sides of each inner border.
std::uint64_t storedVoxels(const Extent3& dims, const Extent3& bricks) {
  std::uint64_t out = 1;
  for (int axis = 0; axis < 3; ++axis) out *= static_cast<std::uint64_t>(dims[axis] + 2 * kApron * (bricks[axis] - 1));
  return out;
}

struct Samples {
  std::uint64_t bricks = 0, stored_voxels = 0, file_bytes = 0;
  double seconds = 0;
};

// One after the other on one thread, as a lane of a conversion goes.
Samples sampleBricks(VolumeSource& source, const ConvertOptions& options, Progress& progress) {
  const SourceInfo& info = source.info();
  const Extent3 lattice = latticeOf(info.geometry.dims, options.brick_size);
  const std::int64_t count = std::min(lattice.count(), kSamples);
  Samples out;
  const auto begin = std::chrono::steady_clock::now();
  for (std::int64_t i = 0; i < count; ++i) {
    progress.throwIfCancelled("sampling");
    const BrickKey key{0, brickAt(lattice, (2 * i + 1) * lattice.count() / (2 * count))};
    const BrickFrame frame{key, info.type, options.brick_size, kApron, info.geometry};
    const VoxelBox box = frame.stored();
    std::vector<std::byte> voxels(static_cast<std::size_t>(box.count()) * sizeOf(info.type));
    source.read(box, voxels);
    const BrickRanges ranges = rangesOf(frame, voxels);
    const bool constant =
        std::equal(voxels.begin() + static_cast<std::ptrdiff_t>(sizeOf(info.type)), voxels.end(), voxels.begin());
    if (!constant) out.file_bytes += encodeBrick(frame, voxels, ranges.cells).size();
    out.stored_voxels += static_cast<std::uint64_t>(box.count());
    ++out.bricks;
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

// No brick's file is larger than that of one of noise, whose core and apron are whole and lie on both sides of the
// borders of OpenVDB's nodes of 128³ and 4096³ voxels.
std::uint64_t largestFileBytes(const SourceInfo& info, std::int64_t brick_size) {
  constexpr std::int64_t kLargestNode = 4096;
  const auto at = static_cast<std::int32_t>(kLargestNode / brick_size);
  const std::int64_t edge = kLargestNode + 2 * brick_size;
  VolumeGeometry geometry = info.geometry;
  geometry.dims = {edge, edge, edge};
  const BrickFrame frame{{0, {at, at, at}}, info.type, brick_size, kApron, geometry};
  std::vector<std::byte> voxels(static_cast<std::size_t>(frame.stored().count()) * sizeOf(info.type));
  std::mt19937 noise(1);
  std::generate(voxels.begin(), voxels.end(), [&] { return static_cast<std::byte>(noise() >> 24); });
  return encodeBrick(frame, voxels, rangesOf(frame, voxels).cells).size();
}

// The parts of two layers of bricks a level wait at most, as the order of bricks has it.
std::uint64_t partBytes(const SourceInfo& info, const VolumeGeometry& level, std::int64_t brick_size) {
  const Extent3 lattice = latticeOf(level.dims, brick_size), by = halvingOf(level);
  const std::int64_t layers = std::min<std::int64_t>(2, lattice.z);
  const std::int64_t voxels = level.dims.x * level.dims.y * std::min(layers * brick_size, level.dims.z);
  return static_cast<std::uint64_t>(voxels / by.count()) * (sizeOf(info.type) + 1);
}

}  // namespace

ConversionCost conversionCost(VolumeSource& source, const ConvertOptions& options, Progress& progress) {
  const SourceInfo& info = source.info();
  ConversionCost out;
  out.plan = planConversion(source, options);
  out.order = source.order();
  out.scratch_bytes = out.plan.scratch_bytes;
  const std::vector<VolumeGeometry> levels = pyramidOf(info.geometry, options.brick_size, options.most_levels);
  out.levels = static_cast<int>(levels.size());
  std::uint64_t stored_voxels = 0;
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const Extent3 lattice = latticeOf(levels[level].dims, options.brick_size);
    out.bricks += static_cast<std::uint64_t>(lattice.count());
    stored_voxels += storedVoxels(levels[level].dims, lattice);
    if (level + 1 < levels.size()) out.scratch_bytes += partBytes(info, levels[level], options.brick_size);
  }
  const std::uint64_t index_bytes = out.bricks * sizeof(BrickEntry);
  if (out.order == ReadOrder::kForward) {
    out.store_bytes = out.bricks * largestFileBytes(info, options.brick_size) + index_bytes;
    return out;
  }
  const Samples samples = sampleBricks(source, options, progress);
  out.sampled_bricks = samples.bricks;
  const double all_to_samples = static_cast<double>(stored_voxels) / static_cast<double>(samples.stored_voxels);
  out.store_bytes = static_cast<std::uint64_t>(static_cast<double>(samples.file_bytes) * all_to_samples) + index_bytes;
  // What the coarser levels take is encoding, mostly, and in proportion.
  out.seconds = samples.seconds * all_to_samples / static_cast<double>(out.plan.lanes);
  return out;
}

}  // namespace kiln

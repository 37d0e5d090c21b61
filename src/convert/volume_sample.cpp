#include "convert/volume_sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "base/error.h"
#include "base/memory/memory.h"
#include "convert/stream/value_counter.h"
#include "store/ranges/minmax_octree.h"

namespace kiln {
namespace {

// Returns the shape of the boxes: cheap, and so small that a sample has at least 256.
Extent3 boxOfSample(const VolumeSource& source) {
  const Extent3 dims = source.info().geometry.dims, cheap = source.cheapBox();
  Extent3 out = {std::min(cheap.x, dims.x), std::min(cheap.y, dims.y), std::min(cheap.z, dims.z)};
  const auto most = static_cast<std::int64_t>(kSampleBytes / 256 / sizeOf(source.info().type));
  for (std::int64_t* const edge : {&out.y, &out.z, &out.x})
    *edge = std::clamp<std::int64_t>(most / (out.count() / *edge), 1, *edge);
  return out;
}

// Returns up to `wanted` different numbers below `count`, in ascending order.
std::set<std::int64_t> spread(std::int64_t count, std::int64_t wanted) {
  std::set<std::int64_t> out;
  constexpr double kGolden = 0.6180339887498949;
  for (std::int64_t i = 0; i < std::min(count, wanted); ++i) {
    const double part = std::fmod((static_cast<double>(i) + 0.5) * kGolden, 1.0);
    out.insert(wanted >= count ? i : static_cast<std::int64_t>(part * static_cast<double>(count)));
  }
  return out;
}

class Sampler {
 public:
  Sampler(VolumeSource& source, std::uint64_t memory_bytes, Progress& progress)
      : source_(source),
        info_(source.info()),
        box_(boxOfSample(source)),
        progress_(progress),
        counter_(info_.type, info_.volume_class == VolumeClass::kLabels) {
    const std::uint64_t bytes = bytesOf(box_) + source.decodeBytes();
    if (bytes > memory_bytes)
      throw Error(ErrorCode::kBudget, info_.files.empty() ? std::filesystem::path() : info_.files.front(), "--memory",
                  fmt::format("{} is too little to read a sample of the values, which takes {}",
                              formatBytes(memory_bytes), roundedUpBytes(bytes)));
  }

  VolumeSample run() {
    if (source_.order() == ReadOrder::kForward)
      readFromBegin();
    else
      readBoxes();
    return finished();
  }

 private:
  std::uint64_t bytesOf(const Extent3& extent) const {
    return static_cast<std::uint64_t>(extent.count()) * sizeOf(info_.type);
  }

  // The number of boxes that may be read. Compressed blocks are decoded whole, for a few boxes at least.
  std::int64_t boxes() const {
    constexpr std::uint64_t kFewest = 8, kDecodedBytes = 8 * kSampleBytes;
    const std::uint64_t decoded = kDecodedBytes / std::max<std::uint64_t>(source_.decodeBytes(), 1);
    return static_cast<std::int64_t>(std::max(kFewest, std::min(kSampleBytes / bytesOf(box_), decoded)));
  }

  void readBoxes() {
    const Extent3& dims = info_.geometry.dims;
    const Extent3 lattice = {(dims.x + box_.x - 1) / box_.x, (dims.y + box_.y - 1) / box_.y,
                             (dims.z + box_.z - 1) / box_.z};
    for (const std::int64_t i : spread(lattice.count(), boxes())) {
      const VoxelCoord lo = {i % lattice.x * box_.x, i / lattice.x % lattice.y * box_.y,
                             i / lattice.x / lattice.y * box_.z};
      count(intersection({lo, {lo.x + box_.x, lo.y + box_.y, lo.z + box_.z}}, boxOf(dims)));
    }
  }

  // Streams are read by whole rows, in order.
  void readFromBegin() {
    const Extent3& dims = info_.geometry.dims;
    const std::int64_t rows = std::clamp<std::int64_t>(box_.count() / dims.x, 1, dims.y);
    for (std::int64_t z = 0; z < dims.z; ++z) {
      for (std::int64_t y = 0; y < dims.y; y += rows) {
        if (out_.voxels * sizeOf(info_.type) >= kStreamSampleBytes) {
          out_.from_begin = true;
          return;
        }
        count({{0, y, z}, {dims.x, std::min(y + rows, dims.y), z + 1}});
      }
    }
  }

  void count(const VoxelBox& box) {
    progress_.throwIfCancelled("sampling the values");
    voxels_.resize(static_cast<std::size_t>(bytesOf(box.extent())));
    source_.read(box, voxels_);
    counter_.count(voxels_, box, box);
    out_.manifest.range.include(rangeOf(voxels_, info_.type, box, box));
    out_.voxels += static_cast<std::uint64_t>(box.count());
  }

  VolumeSample finished() {
    Manifest& manifest = out_.manifest;
    manifest.type = info_.type;
    manifest.nan_count = counter_.nanCount();
    manifest.background = info_.background;
    manifest.volume_class = info_.volume_class;
    manifest.look = info_.look;
    manifest.histogram = histogramOf(manifest, counter_, manifest.range);
    manifest.levels.resize(1);
    manifest.levels.front().geometry = info_.geometry;
    manifest.source.format = info_.format;
    return std::move(out_);
  }

  VolumeSource& source_;
  const SourceInfo info_;
  const Extent3 box_;
  Progress& progress_;
  ValueCounter counter_;
  std::vector<std::byte> voxels_;
  VolumeSample out_;
};

}  // namespace

VolumeSample sampleOf(VolumeSource& source, std::uint64_t memory_bytes, Progress& progress) {
  return Sampler(source, memory_bytes, progress).run();
}

}  // namespace kiln

// NumPy arrays (.npy) of three axes, which are taken as z, y, x: equal arrays are equal volumes, whatever their order
// in the file. In C order x is consecutive, as in raw files. In Fortran order z is consecutive; a box is then read as
// the file stores it, block by block, and the blocks are transposed. Source:
// numpy.org/doc/stable/reference/generated/numpy.lib.format.html.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cstring>

#include "base/error.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/npy/npy_header.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "ingest/source/wrapped_source.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Most bytes of a block. A block is not larger than its box, and a conversion makes a brick's grids after reading the
// brick, so the memory of a lane suffices for both.
constexpr std::int64_t kBlockBytes = 1 << 20;

Extent3 reversed(const Extent3& n) { return {n.z, n.y, n.x}; }
VoxelCoord reversed(const VoxelCoord& v) { return {v.z, v.y, v.x}; }

// Copies a block of `n` voxels, z fastest, to `to`, x fastest. unit of `row`, `slice`: voxels of the whole box.
template <std::size_t kSize>
void transpose(const std::byte* from, const Extent3& n, std::byte* to, std::int64_t row, std::int64_t slice) noexcept {
  constexpr auto kStep = static_cast<std::int64_t>(kSize);
  for (std::int64_t z = 0; z < n.z; ++z) {
    for (std::int64_t y = 0; y < n.y; ++y) {
      std::byte* const out = to + (z * slice + y * row) * kStep;
      const std::byte* const in = from + (y * n.z + z) * kStep;
      for (std::int64_t x = 0; x < n.x; ++x) std::memcpy(out + x * kStep, in + x * n.y * n.z * kStep, kSize);
    }
  }
}

/// The volume of a source whose axes x, y, z are this volume's z, y, x.
class ReversedSource : public WrappedSource {
 public:
  /// requires: `stored` is read in any order.
  ReversedSource(std::unique_ptr<VolumeSource> stored, const VolumeGeometry& geometry)
      : WrappedSource(std::move(stored)) {
    assert(order() == ReadOrder::kAnyBox && reversed(info_.geometry.dims) == geometry.dims);
    info_.geometry = geometry;
  }

  void read(const VoxelBox& box, std::span<std::byte> out) override;
  Extent3 cheapBox() const override { return reversed(WrappedSource::cheapBox()); }
};

// Blocks have the longest runs of z that fit, then of y: the file's order.
void ReversedSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  assert(out.size() == static_cast<std::size_t>(box.count()) * sizeOf(info_.type));
  if (box.empty()) return;
  const Extent3 n = box.extent();
  const auto size = static_cast<std::int64_t>(sizeOf(info_.type));
  Extent3 step;
  step.z = std::min(n.z, kBlockBytes / size);
  step.y = std::clamp<std::int64_t>(kBlockBytes / (size * step.z), 1, n.y);
  step.x = std::clamp<std::int64_t>(kBlockBytes / (size * step.z * step.y), 1, n.x);
  std::vector<std::byte> block(static_cast<std::size_t>(step.count() * size));
  for (std::int64_t x = box.lo.x; x < box.hi.x; x += step.x) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; y += step.y) {
      for (std::int64_t z = box.lo.z; z < box.hi.z; z += step.z) {
        const VoxelBox part = intersection({{x, y, z}, {x + step.x, y + step.y, z + step.z}}, box);
        WrappedSource::read({reversed(part.lo), reversed(part.hi)},
                            std::span(block).first(static_cast<std::size_t>(part.count() * size)));
        const std::int64_t first = ((z - box.lo.z) * n.y + (y - box.lo.y)) * n.x + (x - box.lo.x);
        withVoxelType(info_.type, [&]<class T>(std::type_identity<T>) {
          transpose<sizeof(T)>(block.data(), part.extent(), out.data() + first * size, n.x, n.x * n.y);
        });
      }
    }
  }
}

std::string shown(const std::vector<std::int64_t>& shape) { return fmt::format("({})", fmt::join(shape, ", ")); }

// Drops axes of length 1, the first ones first, until three are left: a single time or channel.
Extent3 dimsOf(const NpyHeader& header, const fs::path& path) {
  std::vector<std::int64_t> shape = header.shape;
  while (shape.size() > 3) {
    const auto single = std::find(shape.begin(), shape.end(), 1);
    if (single == shape.end()) break;
    shape.erase(single);
  }
  if (shape.size() != 3)
    throw Error(ErrorCode::kUnsupported, path, "shape",
                fmt::format("{} has {} {}; save an array of three", inQuotes(shown(header.shape)), header.shape.size(),
                            header.shape.size() == 1 ? "axis" : "axes"));
  return {shape[2], shape[1], shape[0]};
}

void noteChoices(const SourceOptions& options, SourceInfo& info) {
  const Extent3& dims = info.geometry.dims;
  if (!options.spacing)
    info.notes.push_back(
        fmt::format("the axes {} of the array are taken as z, y, x, and its voxels as 1 x 1 x 1, which the file does "
                    "not tell; --spacing sets another size",
                    shown({dims.z, dims.y, dims.x})));
  if (mayBeChannels(dims))
    info.notes.push_back(fmt::format(
        "the last axis is taken as {} voxels of space; if it holds colours or vectors, the volume is wrong", dims.x));
}

}  // namespace

std::unique_ptr<VolumeSource> openNpy(const fs::path& input, const SourceOptions& options) {
  const NpyHeader header = readNpyHeader(File(input));
  VolumeGeometry geometry;
  geometry.dims = dimsOf(header, input);
  geometry.world_from_index = axesAffine(options.spacing.value_or(glm::dvec3(1)), glm::dvec3(0));
  requireInvertible(geometry.world_from_index, input.string());

  SourceInfo info;
  info.format = "NumPy";
  info.type = header.type.voxel();
  info.geometry = geometry;
  noteChoices(options, info);
  LinearData data;
  data.file = input;
  data.offset_bytes = header.end_offset;
  data.stored_type = header.type;
  data.big_endian = header.big_endian;
  if (!header.fortran_order) return openDescribed(input, std::move(info), data);
  info.geometry.dims = reversed(geometry.dims);
  return std::make_unique<ReversedSource>(openDescribed(input, std::move(info), data), geometry);
}

}  // namespace kiln

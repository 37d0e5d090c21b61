#include "render/frame_memory.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "frame/brick_walk.h"
#include "frame/make_visibility.h"

namespace kiln {
namespace {

// The octree above bricks has some 12 bytes a brick and a seventh.
constexpr std::uint64_t kWalkBytes = 16;

// Samples that wait for their slabs at a time, measured over the test scenes: some 20 000 of 32 bytes at the most, in
// tiles of 64 pixels.
constexpr std::uint64_t kWaitingBytes = 2u << 20;

std::uint64_t slabBytes(const RenderJob& job) {
  const auto edge = static_cast<std::uint64_t>(job.speed.tile_px);
  const auto pixels =
      static_cast<std::uint64_t>(job.picture.size.width) * static_cast<std::uint64_t>(job.picture.size.height);
  const std::uint64_t tile = edge == 0 ? pixels : std::min(pixels, edge * edge);
  // Two sheets of RGBA, what each pixel owns, and a margin around them.
  const std::uint64_t sheets = tile * (2 * 4 * sizeof(std::int32_t) + 2 * sizeof(int)) * 5 / 4;
  const std::uint64_t tiles = tile / (64 * 64) + 1;
  return ThreadLimit::active() * (sheets + tiles * kWaitingBytes);
}

}  // namespace

FrameMemory frameMemory(const StoreReader& store, const RenderJob& job) {
  const ImageSize& size = job.picture.size;
  FrameMemory out;
  out.image = static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height) * 4 * sizeof(float);
  out.visibility = visibilityBytes(job.speed.visibility.method, size);
  out.index = store.index().size() * (sizeof(BrickEntry) + kWalkBytes + sizeof(BrickInView));
  if (job.picture.lattice == Lattice::kPixel) out.slabs = slabBytes(job);
  out.brick = store.largestReadBytes();
  return out;
}

std::uint64_t cacheBytes(const FrameMemory& memory, std::uint64_t budget_bytes, const std::filesystem::path& store) {
  if (memory.smallest() > budget_bytes) {
    throw Error(ErrorCode::kBudget, store, "--memory",
                fmt::format("{} is too little: {} is the smallest that works here ({} of image, {} of visibility, {} "
                            "of index, {} of slabs, {} to read one brick)",
                            formatBytes(budget_bytes), roundedUpBytes(memory.smallest()), formatBytes(memory.image),
                            formatBytes(memory.visibility), formatBytes(memory.index), formatBytes(memory.slabs),
                            formatBytes(memory.brick)));
  }
  return budget_bytes - memory.besideBricks();
}

}  // namespace kiln

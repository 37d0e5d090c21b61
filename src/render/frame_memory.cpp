#include "render/frame_memory.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/memory.h"
#include "frame/brick_walk.h"
#include "frame/make_visibility.h"

namespace kiln {
namespace {

// The octree above bricks has some 12 bytes a brick and a seventh.
constexpr std::uint64_t kWalkBytes = 16;

}  // namespace

FrameMemory frameMemory(const StoreReader& store, const RenderJob& job) {
  const ImageSize& size = job.picture.size;
  FrameMemory out;
  out.image = static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height) * 4 * sizeof(float);
  out.visibility = visibilityBytes(job.speed.visibility.method, size);
  out.index = store.index().size() * (sizeof(BrickEntry) + kWalkBytes + sizeof(BrickInView));
  out.brick = store.largestReadBytes();
  return out;
}

std::uint64_t cacheBytes(const FrameMemory& memory, std::uint64_t budget_bytes, const std::filesystem::path& store) {
  if (memory.smallest() > budget_bytes) {
    throw Error(ErrorCode::kBudget, store, "--memory",
                fmt::format("{} is too little: {} is the smallest that works here ({} of image, {} of visibility, {} "
                            "of index, {} to read one brick)",
                            formatBytes(budget_bytes), roundedUpBytes(memory.smallest()), formatBytes(memory.image),
                            formatBytes(memory.visibility), formatBytes(memory.index), formatBytes(memory.brick)));
  }
  return budget_bytes - memory.besideBricks();
}

}  // namespace kiln

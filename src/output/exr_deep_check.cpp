#include "output/exr_deep_check.h"

#include <ImathBox.h>
#include <ImfDeepScanLineInputPart.h>

#include <algorithm>
#include <stdexcept>

#include "output/exr_deep_row.h"
#include "output/exr_parts.h"

namespace kiln {
namespace {

// A slab is at least a hundredth of a pixel thick, and no picture needs a row of more.
constexpr std::uint64_t kMostOfARow = std::uint64_t{1} << 26;
// OpenEXR's and our copy of a sample's numbers, of which a deep picture has six.
constexpr std::uint64_t kSampleBytes = 2 * 6 * sizeof(float);

DeepRow rowOf(int width) {
  DeepRow out(width);
  for (const char* name : kExrChannelNames) out.addChannel(name, Imf::FLOAT);
  return out;
}

void requireSamples(const DeepRow& row, std::uint64_t memory_bytes) {
  if (row.samples() > std::min(kMostOfARow, memory_bytes / kSampleBytes))
    throw std::runtime_error("a row of a deep part claims too many samples");
}

}  // namespace

void requireRowsWithin(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes) {
  Imf::DeepScanLineInputPart in(file, part);
  const Imath::Box2i window = in.header().dataWindow();
  DeepRow row = rowOf(window.max.x - window.min.x + 1);
  in.setFrameBuffer(row.frameBuffer(window.min.x));
  for (int y = window.min.y; y <= window.max.y; ++y) {
    in.readPixelSampleCounts(y, y);
    requireSamples(row, memory_bytes);
  }
}

void checkDeepPart(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes) {
  Imf::DeepScanLineInputPart in(file, part);
  const Imath::Box2i window = in.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  if (width < 1 || width > kLargestSide_px) throw std::runtime_error("the data window of a deep part is no picture's");
  DeepRow row = rowOf(static_cast<int>(width));
  in.setFrameBuffer(row.frameBuffer(window.min.x));
  for (int y = window.min.y; y <= window.max.y; ++y) {
    in.readPixelSampleCounts(y, y);
    requireSamples(row, memory_bytes);
    row.layOut();
    in.readPixels(y, y);
  }
}

}  // namespace kiln

#include "image/file/exr_deep_check.h"

#include <ImathBox.h>
#include <ImfDeepScanLineInputPart.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "image/file/exr_deep_row.h"
#include "image/file/exr_parts.h"
#include "image/pixel_rect.h"

namespace kiln {
namespace {

// Limit of samples per row: a slab is at least a hundredth of a pixel thick, and no picture needs more.
constexpr std::uint64_t kMostOfARow = std::uint64_t{1} << 26;
// Two copies (OpenEXR's and Kiln's) of the six numbers of a sample.
constexpr std::uint64_t kSampleBytes = 2 * 6 * sizeof(float);

// Calls visit(part, row, y) for each row. throws: std::runtime_error if the samples of a row do not fit.
template <class Visit>
void forEachRow(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes, Visit visit) {
  Imf::DeepScanLineInputPart in(file, part);
  const Imath::Box2i window = in.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  if (width < 1 || width > kLargestSide_px)
    throw std::runtime_error("the data window of a deep part must be from 1 to " + std::to_string(kLargestSide_px) +
                             " pixels wide");
  DeepRow row(static_cast<int>(width));
  for (const char* name : kExrChannelNames) row.addChannel(name, Imf::FLOAT);
  in.setFrameBuffer(row.frameBuffer(window.min.x));
  for (int y = window.min.y; y <= window.max.y; ++y) {
    in.readPixelSampleCounts(y, y);
    if (row.samples() > std::min(kMostOfARow, memory_bytes / kSampleBytes))
      throw std::runtime_error("a row of a deep part claims too many samples");
    visit(in, row, y);
  }
}

}  // namespace

void requireRowsWithin(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes) {
  forEachRow(file, part, memory_bytes, [](Imf::DeepScanLineInputPart&, DeepRow&, int) {});
}

void checkDeepPart(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes) {
  forEachRow(file, part, memory_bytes, [](Imf::DeepScanLineInputPart& in, DeepRow& row, int y) {
    row.layOut();
    in.readPixels(y, y);
  });
}

}  // namespace kiln

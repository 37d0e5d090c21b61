#include "image/file/exr_deep_check.h"

#include <ImathBox.h>
#include <ImfDeepScanLineInputPart.h>

#include <algorithm>
#include <stdexcept>

#include "image/file/exr_deep_row.h"
#include "image/file/exr_parts.h"

namespace kiln {
namespace {

// A slab is at least a hundredth of a pixel thick, and no picture needs a row of more.
constexpr std::uint64_t kMostOfARow = std::uint64_t{1} << 26;
// OpenEXR's and our copy of a sample's numbers, of which a deep picture has six.
constexpr std::uint64_t kSampleBytes = 2 * 6 * sizeof(float);

// Calls visit(part, row, y) for each row. throws: std::runtime_error where a row has more samples than fit.
template <class Visit>
void forEachRow(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes, Visit visit) {
  Imf::DeepScanLineInputPart in(file, part);
  const Imath::Box2i window = in.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  if (width < 1 || width > kLargestSide_px) throw std::runtime_error("the data window of a deep part is no picture's");
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

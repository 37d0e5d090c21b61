#include "output/exr_edges.h"

#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfDeepScanLineInputPart.h>
#include <ImfDeepScanLineOutputPart.h>
#include <ImfPartType.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "output/exr_deep_row.h"
#include "output/exr_parts.h"

namespace kiln {
namespace {

constexpr std::size_t kCoverage = 4;
// A slab is at least a hundredth of a pixel thick, and no picture needs a row of more.
constexpr std::uint64_t kMostOfARow = std::uint64_t{1} << 26;
// OpenEXR's and our copy of a sample's numbers, of which a deep picture has six.
constexpr std::uint64_t kSampleBytes = 2 * 6 * sizeof(float);

DeepRow rowOf(int width) {
  DeepRow out(width);
  for (const char* name : kExrChannelNames) out.addChannel(name, Imf::FLOAT);
  out.addChannel("coverage", Imf::FLOAT);
  return out;
}

void requireSamples(const DeepRow& row, std::uint64_t memory_bytes) {
  if (row.samples() > std::min(kMostOfARow, memory_bytes / kSampleBytes))
    throw std::runtime_error("a row of a deep part claims too many samples");
}

// Calls f(y, row) for each row, from top to bottom, y counted from the data window's first.
template <class F>
void forEachRow(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes, F f) {
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
    f(y - window.min.y, row);
  }
}

}  // namespace

Imf::Header edgesHeader(Imf::Header flat) {
  flat.setName(kEdgesPart);
  flat.setType(Imf::DEEPSCANLINE);
  flat.compression() = Imf::ZIPS_COMPRESSION;
  flat.channels() = {};
  for (const char* name : kExrChannelNames) flat.channels().insert(name, Imf::Channel(Imf::FLOAT));
  flat.channels().insert("coverage", Imf::Channel(Imf::FLOAT));
  return flat;
}

void writeEdges(const EdgeLayers& edges, Imf::MultiPartOutputFile& file, int part) {
  Imf::DeepScanLineOutputPart out(file, part);
  const PixelRect& rect = edges.rect();
  DeepRow row = rowOf(rect.width());
  out.setFrameBuffer(row.frameBuffer(out.header().dataWindow().min.x));
  for (int y = rect.y0; y < rect.y1; ++y) {
    for (int x = rect.x0; x < rect.x1; ++x)
      row.counts()[static_cast<std::size_t>(x - rect.x0)] = static_cast<unsigned>(edges.count(x, y));
    row.layOut();
    std::size_t place = 0;
    for (int x = rect.x0; x < rect.x1; ++x) {
      edges.forEach(x, y, [&](const EdgeLayer& layer) {
        for (std::size_t c = 0; c < 4; ++c) row.values<float>(c)[place] = layer.rgba[c];
        row.values<float>(kCoverage)[place++] = layer.part;
      });
    }
    out.writePixels(1);
  }
}

std::shared_ptr<EdgeLayers> readEdges(Imf::MultiPartInputFile& file, int width, int height,
                                      std::uint64_t memory_bytes) {
  for (int part = 0; part < file.parts(); ++part) {
    const Imf::Header& header = file.header(part);
    if (!header.hasName() || header.name() != kEdgesPart || !header.hasType() || header.type() != Imf::DEEPSCANLINE)
      continue;
    const Imath::Box2i& window = header.dataWindow();
    if (std::int64_t{window.max.x} - window.min.x + 1 != width ||
        std::int64_t{window.max.y} - window.min.y + 1 != height)
      throw std::runtime_error("the part 'edges' has other pixels than the picture");
    auto out = std::make_shared<EdgeLayers>(PixelRect{0, 0, width, height});
    std::uint64_t layers = 0;
    forEachRow(file, part, memory_bytes, [&](int y, DeepRow& row) {
      layers += row.samples();
      if (layers > memory_bytes / (2 * sizeof(EdgeLayer)))
        throw std::runtime_error("the part 'edges' has more layers than there is memory for");
      std::size_t place = 0;
      for (int x = 0; x < width; ++x) {
        for (unsigned i = 0; i < row.counts()[static_cast<std::size_t>(x)]; ++i, ++place) {
          EdgeLayer layer{row.values<float>(kCoverage)[place], {}};
          for (std::size_t c = 0; c < 4; ++c) layer.rgba[c] = row.values<float>(c)[place];
          out->put(x, y, layer);
        }
      }
    });
    return out;
  }
  return nullptr;
}

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
  forEachRow(file, part, memory_bytes, [](int /*y*/, DeepRow& /*row*/) {});
}

}  // namespace kiln

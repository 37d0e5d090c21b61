#include "image/file/exr_deep.h"

#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfPartType.h>

#include <array>
#include <cmath>
#include <type_traits>

#include "base/error.h"
#include "image/file/exr_complete.h"
#include "image/file/exr_deep_row.h"
#include "image/file/exr_parts.h"

namespace kiln {
namespace {

// Rounds samples to half floats. Each sample compensates the rounding of the samples in front of it, so the composite
// of all samples is off by only the rounding of the last sample.
class HalfChain {
 public:
  std::array<float, 4> next(const std::array<float, 4>& sample) {
    const double open = 1 - wanted_[3], written_open = 1 - written_[3];
    const bool opaque = sample[3] >= 1;
    std::array<float, 4> out;
    for (std::size_t c = 0; c < 4; ++c) {
      wanted_[c] += open * sample[c];
      const double left = written_open > 0 ? (wanted_[c] - written_[c]) / written_open : 0;
      out[c] = clampedHalf(static_cast<float>(std::max(left, 0.0)));
    }
    // A sample that is not opaque must not become opaque by rounding.
    out[3] = opaque ? 1 : std::min(out[3], kLargestClear);
    for (std::size_t c = 0; c < 4; ++c) written_[c] += written_open * out[c];
    return out;
  }

 private:
  static constexpr float kLargestClear = 1 - 0x1p-11f;
  std::array<double, 4> wanted_{}, written_{};
};

// Fills a row with the samples of picture row y.
template <class T>
void fillRow(const DeepSamples& samples, int y, DeepRow& row, std::vector<DeepSample>& pixel) {
  const int first = samples.rect().x0;
  for (std::size_t x = 0; x < row.counts().size(); ++x)
    row.counts()[x] = static_cast<unsigned>(samples.count(first + static_cast<int>(x), y));
  row.layOut();
  std::size_t place = 0;
  for (std::size_t x = 0; x < row.counts().size(); ++x) {
    pixel.resize(row.counts()[x]);
    samples.copy(first + static_cast<int>(x), y, pixel.data());
    HalfChain chain;
    for (const DeepSample& sample : pixel) {
      const std::array<float, 4> rgba = std::is_same_v<T, half> ? chain.next(sample.rgba) : sample.rgba;
      for (std::size_t c = 0; c < 4; ++c) row.values<T>(c)[place] = T(rgba[c]);
      row.values<float>(4)[place] = sample.z;
      row.values<float>(5)[place] = sample.z_back;
      ++place;
    }
  }
}

template <class T>
void writeDeepRows(Imf::DeepScanLineOutputFile& file, const DeepSamples& samples, Imf::PixelType type) {
  DeepRow row(samples.rect().width());
  for (const char* name : kExrChannelNames) row.addChannel(name, type);
  for (const char* name : {"Z", "ZBack"}) row.addChannel(name, Imf::FLOAT);
  file.setFrameBuffer(row.frameBuffer(file.header().dataWindow().min.x));
  std::vector<DeepSample> pixel;
  for (int y = samples.rect().y0; y < samples.rect().y1; ++y) {
    fillRow<T>(samples, y, row, pixel);
    file.writePixels(1);
  }
  requireAllRows(file);
}

Imf::Compression deepCompression(const std::string& name) {
  const Imf::Compression found = exrCompression(name);
  if (found == Imf::ZIP_COMPRESSION) return Imf::ZIPS_COMPRESSION;
  if (found == Imf::NO_COMPRESSION || found == Imf::RLE_COMPRESSION || found == Imf::ZIPS_COMPRESSION) return found;
  throw Error(ErrorCode::kUsage, "'" + name + "' is no compression of deep files; choose none, rle or zips");
}

}  // namespace

void encodeDeepExr(const DeepSamples& samples, const ImageMetadata& metadata, const ImageFileOptions& options,
                   const std::filesystem::path& path, ScratchOutput& out) {
  const Imf::PixelType type = options.exr_float ? Imf::FLOAT : Imf::HALF;
  Imf::Header header =
      exrHeader(samples.rect().width(), samples.rect().height(), metadata, deepCompression(options.exr_compression));
  header.setType(Imf::DEEPSCANLINE);
  for (const char* name : kExrChannelNames) header.channels().insert(name, Imf::Channel(type));
  for (const char* name : {"Z", "ZBack"}) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  writeExr(out, path, [&](Imf::OStream& stream) {
    // The destructor writes the table of scanline offsets.
    Imf::DeepScanLineOutputFile file(stream, header, 0);
    if (options.exr_float)
      writeDeepRows<float>(file, samples, type);
    else
      writeDeepRows<half>(file, samples, type);
  });
}

}  // namespace kiln

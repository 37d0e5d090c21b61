// A row at a time: its samples are laid out channel by channel, and OpenEXR is told where each pixel's begin.
#include "output/exr_deep.h"

#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfPartType.h>

#include <array>
#include <cmath>

#include "base/error.h"
#include "output/exr_parts.h"

namespace kiln {
namespace {

// Samples as half floats. Each is chosen for what the ones before it have become, so that what all are when laid over
// one another is no farther off than the last of them is rounded.
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
    // What is not opaque hides nothing behind it.
    out[3] = opaque ? 1 : std::min(out[3], kLargestClear);
    for (std::size_t c = 0; c < 4; ++c) written_[c] += written_open * out[c];
    return out;
  }

 private:
  static constexpr float kLargestClear = 1 - 0x1p-11f;
  std::array<double, 4> wanted_{}, written_{};
};

// The samples of one row, a channel behind the other.
template <class T>
class DeepRow {
 public:
  DeepRow(const DeepSamples& samples, Imf::PixelType type)
      : samples_(samples),
        type_(type),
        width_(static_cast<std::size_t>(samples.rect().width())),
        counts_(width_),
        depth_at_{std::vector<char*>(width_), std::vector<char*>(width_)} {
    for (auto& pointers : color_at_) pointers.resize(width_);
  }

  // Rows lie on one another: what a row is written from is filled before.
  Imf::DeepFrameBuffer frameBuffer(int first_x) {
    Imf::DeepFrameBuffer out;
    const auto before = static_cast<std::ptrdiff_t>(first_x);
    out.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts_.data() - before), sizeof(unsigned), 0));
    const auto insert = [&](const char* name, std::vector<char*>& pointers, Imf::PixelType type, std::size_t bytes) {
      out.insert(name,
                 Imf::DeepSlice(type, reinterpret_cast<char*>(pointers.data() - before), sizeof(char*), 0, bytes));
    };
    for (std::size_t c = 0; c < 4; ++c) insert(kExrChannelNames[c], color_at_[c], type_, sizeof(T));
    insert("Z", depth_at_[0], Imf::FLOAT, sizeof(float));
    insert("ZBack", depth_at_[1], Imf::FLOAT, sizeof(float));
    return out;
  }

  void fill(int y) {
    std::size_t all = 0;
    for (std::size_t x = 0; x < width_; ++x) all += counts_[x] = static_cast<unsigned>(samples_.count(xOf(x), y));
    for (auto& values : colors_) values.resize(all);
    for (auto& values : depths_) values.resize(all);
    std::size_t place = 0;
    for (std::size_t x = 0; x < width_; ++x) {
      point(x, place);
      pixel_.resize(counts_[x]);
      samples_.copy(xOf(x), y, pixel_.data());
      put(place);
      place += counts_[x];
    }
  }

 private:
  int xOf(std::size_t x) const { return samples_.rect().x0 + static_cast<int>(x); }

  void point(std::size_t x, std::size_t place) {
    for (std::size_t c = 0; c < 4; ++c) color_at_[c][x] = reinterpret_cast<char*>(colors_[c].data() + place);
    for (std::size_t c = 0; c < 2; ++c) depth_at_[c][x] = reinterpret_cast<char*>(depths_[c].data() + place);
  }

  void put(std::size_t place) {
    HalfChain chain;
    for (const DeepSample& sample : pixel_) {
      const std::array<float, 4> rgba = type_ == Imf::HALF ? chain.next(sample.rgba) : sample.rgba;
      for (std::size_t c = 0; c < 4; ++c) colors_[c][place] = T(rgba[c]);
      depths_[0][place] = sample.z;
      depths_[1][place] = sample.z_back;
      ++place;
    }
  }

  const DeepSamples& samples_;
  const Imf::PixelType type_;
  const std::size_t width_;
  std::vector<unsigned> counts_;
  std::array<std::vector<T>, 4> colors_;
  std::array<std::vector<float>, 2> depths_;
  std::array<std::vector<char*>, 4> color_at_;
  std::array<std::vector<char*>, 2> depth_at_;
  std::vector<DeepSample> pixel_;
};

template <class T>
void writeDeepRows(Imf::DeepScanLineOutputFile& file, const DeepSamples& samples, Imf::PixelType type) {
  DeepRow<T> row(samples, type);
  file.setFrameBuffer(row.frameBuffer(file.header().dataWindow().min.x));
  for (int y = samples.rect().y0; y < samples.rect().y1; ++y) {
    row.fill(y);
    file.writePixels(1);
  }
}

Imf::Compression deepCompression(const std::string& name) {
  const Imf::Compression found = exrCompression(name);
  if (found == Imf::ZIP_COMPRESSION) return Imf::ZIPS_COMPRESSION;
  if (found == Imf::NO_COMPRESSION || found == Imf::RLE_COMPRESSION || found == Imf::ZIPS_COMPRESSION) return found;
  throw Error(ErrorCode::kUsage, "'" + name + "' is no compression of deep files; choose none, rle or zips");
}

}  // namespace

std::vector<std::byte> encodeDeepExr(const DeepSamples& samples, const ImageMetadata& metadata,
                                     const ImageFileOptions& options, const std::filesystem::path& path) {
  const Imf::PixelType type = options.exr_float ? Imf::FLOAT : Imf::HALF;
  Imf::Header header =
      exrHeader(samples.rect().width(), samples.rect().height(), metadata, deepCompression(options.exr_compression));
  header.setType(Imf::DEEPSCANLINE);
  for (const char* name : kExrChannelNames) header.channels().insert(name, Imf::Channel(type));
  for (const char* name : {"Z", "ZBack"}) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  try {
    ExrWriter stream;
    {
      Imf::DeepScanLineOutputFile file(stream, header, 0);
      if (options.exr_float)
        writeDeepRows<float>(file, samples, type);
      else
        writeDeepRows<half>(file, samples, type);
    }  // the destructor writes the table of scanline offsets
    return stream.take();
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kIo, path, "", std::string("OpenEXR cannot write this picture: ") + error.what());
  }
}

}  // namespace kiln

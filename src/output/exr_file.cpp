// Both ways go through memory: a file is written whole or not at all (FileSystem::writeAtomic), and a reader's bytes
// are bounded before OpenEXR sees them. Pixels go row by row, so that beside the image there is one row and the
// compressed file; and a header that claims more rows than the file has costs no memory, for the picture grows as rows
// arrive.
#include "output/exr_file.h"

#include <ImathBox.h>
#include <ImathMatrix.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "base/pixel_rect.h"

namespace kiln {
namespace {

constexpr const char* kChannelNames[] = {"R", "G", "B", "A"};

class MemoryWriter : public Imf::OStream {
 public:
  MemoryWriter() : Imf::OStream("memory") {}
  void write(const char data[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (place_ + size > bytes_.size()) bytes_.resize(place_ + size);
    std::memcpy(bytes_.data() + place_, data, size);
    place_ += size;
  }
  std::uint64_t tellp() override { return place_; }
  void seekp(std::uint64_t place) override { place_ = place; }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
  std::size_t place_ = 0;
};

class MemoryReader : public Imf::IStream {
 public:
  explicit MemoryReader(std::span<const std::byte> data) : Imf::IStream("memory"), data_(data) {}
  bool read(char out[], int count) override {
    const std::size_t left = place_ < data_.size() ? data_.size() - place_ : 0;
    if (count < 0 || static_cast<std::size_t>(count) > left) throw std::runtime_error("the file ends too early");
    std::memcpy(out, data_.data() + place_, static_cast<std::size_t>(count));
    place_ += static_cast<std::size_t>(count);
    return place_ < data_.size();
  }
  std::uint64_t tellg() override { return place_; }
  void seekg(std::uint64_t place) override { place_ = place; }

 private:
  std::span<const std::byte> data_;
  std::uint64_t place_ = 0;
};

// Imath multiplies row vectors (v·M), glm column vectors (M·v): the same map is the transpose, and as glm's [i] is a
// column where Imath's is a row, the entries keep their indices.
Imath::M44f imathOf(const glm::dmat4& m) {
  Imath::M44f out;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) out[i][j] = static_cast<float>(m[i][j]);
  }
  return out;
}

Imf::Compression compressionNamed(const std::string& name) {
  static const std::map<std::string, Imf::Compression> kCompressions = {
      {"none", Imf::NO_COMPRESSION},   {"rle", Imf::RLE_COMPRESSION}, {"zips", Imf::ZIPS_COMPRESSION},
      {"zip", Imf::ZIP_COMPRESSION},   {"piz", Imf::PIZ_COMPRESSION}, {"dwaa", Imf::DWAA_COMPRESSION},
      {"dwab", Imf::DWAB_COMPRESSION},
  };
  const auto found = kCompressions.find(name);
  if (found != kCompressions.end()) return found->second;
  throw Error(ErrorCode::kUsage, "'" + name + "' is no compression of OpenEXR's that Kiln writes");
}

Imf::Header headerFor(const Image& image, const ImageMetadata& metadata, Imf::PixelType type,
                      Imf::Compression compression) {
  const ImageMetadata::Whole whole = metadata.whole.value_or(ImageMetadata::Whole{0, 0, image.width, image.height});
  Imf::Header header(whole.width, whole.height);
  header.dataWindow() = {{whole.x, whole.y}, {whole.x + image.width - 1, whole.y + image.height - 1}};
  header.compression() = compression;
  for (const char* name : kChannelNames) {
    if (!image.rgba.empty()) header.channels().insert(name, Imf::Channel(type));
  }
  for (const Plane& plane : image.planes) header.channels().insert(plane.name, Imf::Channel(Imf::FLOAT));
  if (metadata.world_to_camera) Imf::addWorldToCamera(header, imathOf(*metadata.world_to_camera));
  if (metadata.world_to_ndc) Imf::addWorldToNDC(header, imathOf(*metadata.world_to_ndc));
  for (const auto& [name, text] : metadata.text) header.insert(name, Imf::StringAttribute(text));
  return header;
}

// One row that every scanline of the file is written from or read into: a stride of 0 from row to row.
template <class T>
Imf::FrameBuffer oneRow(std::vector<T>& row, Imf::PixelType type, int first_x) {
  Imf::FrameBuffer buffer;
  char* base = reinterpret_cast<char*>(row.data()) - static_cast<std::ptrdiff_t>(first_x) * 4 * sizeof(T);
  for (std::size_t channel = 0; channel < 4; ++channel) {
    const double fill = channel == 3 ? 1 : 0;
    buffer.insert(kChannelNames[channel], Imf::Slice(type, base + channel * sizeof(T), 4 * sizeof(T), 0, 1, 1, fill));
  }
  return buffer;
}

// OpenEXR counts pixels from the display window's corner, and never writes to what it reads.
Imf::Slice wholePlane(const Plane& plane, int width, const Imath::V2i& first) {
  constexpr std::ptrdiff_t kBytes = sizeof(float);
  const std::ptrdiff_t before = kBytes * (std::ptrdiff_t{first.y} * width + first.x);
  char* const values = reinterpret_cast<char*>(const_cast<float*>(plane.values.data()));
  return {Imf::FLOAT, values - before, kBytes, static_cast<std::size_t>(kBytes * width)};
}

template <class T, class Convert>
void writeRows(Imf::OutputFile& file, const Image& image, Imf::PixelType type, Convert convert) {
  std::vector<T> row(static_cast<std::size_t>(image.width) * 4);
  const Imath::V2i& first = file.header().dataWindow().min;
  // A slice of no channel of the file is passed over.
  Imf::FrameBuffer buffer = oneRow(row, type, first.x);
  for (const Plane& plane : image.planes) buffer.insert(plane.name, wholePlane(plane, image.width, first));
  file.setFrameBuffer(buffer);
  for (int y = 0; y < image.height; ++y) {
    if (!image.rgba.empty()) std::transform(image.pixel(0, y), image.pixel(0, y) + row.size(), row.begin(), convert);
    file.writePixels(1);
  }
}

half clampedHalf(float v) { return half(std::clamp(v, -65504.0f, 65504.0f)); }

// Runs what reads a hostile file; whatever OpenEXR throws becomes an error of the file.
template <class Read>
auto reading(const std::filesystem::path& path, Read read) {
  try {
    return read();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kFormat, path, "", std::string("cannot be read as OpenEXR: ") + error.what());
  }
}

void requireChannels(const Imf::ChannelList& channels, bool grey, const std::filesystem::path& path) {
  if (!grey && !channels.findChannel("R") && !channels.findChannel("G") && !channels.findChannel("B")) {
    throw Error(ErrorCode::kUnsupported, path, "channels", "the file has none of R, G, B and Y");
  }
  for (const char* name : {"R", "G", "B", "A", "Y"}) {
    const Imf::Channel* channel = channels.findChannel(name);
    if (channel && (channel->xSampling != 1 || channel->ySampling != 1)) {
      throw Error(ErrorCode::kUnsupported, path, std::string("channel ") + name, "subsampled channels are not read");
    }
  }
}

Image readRows(Imf::InputFile& file, std::size_t file_bytes, const std::filesystem::path& path) {
  const Imath::Box2i window = file.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (width < 1 || height < 1 || width > kLargestSide_px || height > kLargestSide_px) {
    throw Error(ErrorCode::kUnsupported, path, "dataWindow",
                std::to_string(width) + "x" + std::to_string(height) + " pixels; each side must be from 1 to 65536");
  }
  const Imf::ChannelList& channels = file.header().channels();
  const bool grey = channels.findChannel("Y") && !channels.findChannel("R");
  requireChannels(channels, grey, path);

  std::vector<float> row(static_cast<std::size_t>(width) * 4);
  Imf::FrameBuffer buffer = oneRow(row, Imf::FLOAT, window.min.x);
  if (grey) buffer.insert("Y", buffer["R"]);
  file.setFrameBuffer(buffer);
  Image image;
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  image.rgba.reserve(std::min(static_cast<std::size_t>(width * height) * 4, file_bytes * 64));
  for (int y = window.min.y; y <= window.max.y; ++y) {
    file.readPixels(y);
    for (std::size_t x = 0; grey && x < row.size(); x += 4) row[x + 1] = row[x + 2] = row[x];
    image.rgba.insert(image.rgba.end(), row.begin(), row.end());
  }
  return image;
}

// Of a file whose rows were read already.
void readPlanes(Imf::InputFile& file, std::span<const std::string> names, const std::filesystem::path& path,
                Image& image) {
  const Imath::Box2i window = file.header().dataWindow();
  for (const std::string& name : names) {
    const Imf::Channel* const channel = file.header().channels().findChannel(name);
    if (channel == nullptr || channel->xSampling != 1 || channel->ySampling != 1)
      throw Error(ErrorCode::kFormat, path, "channel " + name, "is missing, or is not of every pixel");
    image.planes.push_back({name, std::vector<float>(image.rgba.size() / 4)});
  }
  Imf::FrameBuffer buffer;
  const std::size_t row = static_cast<std::size_t>(image.width) * sizeof(float);
  for (Plane& plane : image.planes) {
    char* const base = reinterpret_cast<char*>(plane.values.data()) - std::ptrdiff_t{window.min.x} * 4 -
                       std::ptrdiff_t{window.min.y} * static_cast<std::ptrdiff_t>(row);
    buffer.insert(plane.name, Imf::Slice(Imf::FLOAT, base, sizeof(float), row));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
}

}  // namespace

bool looksLikeExr(std::span<const std::byte> data) {
  static constexpr unsigned char kMagic[] = {0x76, 0x2f, 0x31, 0x01};
  return data.size() >= sizeof kMagic && std::memcmp(data.data(), kMagic, sizeof kMagic) == 0;
}

std::vector<std::byte> encodeExr(const Image& image, const ImageMetadata& metadata, const ImageFileOptions& options,
                                 const std::filesystem::path& path) {
  const Imf::Compression compression = compressionNamed(options.exr_compression);
  try {
    const Imf::PixelType type = options.exr_float ? Imf::FLOAT : Imf::HALF;
    MemoryWriter stream;
    {
      Imf::OutputFile file(stream, headerFor(image, metadata, type, compression), 0);
      if (options.exr_float)
        writeRows<float>(file, image, type, [](float v) { return v; });
      else
        writeRows<half>(file, image, type, clampedHalf);
    }  // the destructor writes the table of scanline offsets
    return stream.take();
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kIo, path, "", std::string("OpenEXR cannot write this picture: ") + error.what());
  }
}

Image decodeExr(std::span<const std::byte> data, const std::filesystem::path& path,
                std::span<const std::string> planes) {
  return reading(path, [&] {
    MemoryReader stream(data);
    Imf::InputFile file(stream, 0);
    Image image = readRows(file, data.size(), path);
    if (!planes.empty()) readPlanes(file, planes, path, image);
    return image;
  });
}

void checkExr(std::span<const std::byte> data, const std::filesystem::path& path) {
  reading(path, [&] {
    MemoryReader stream(data);
    Imf::InputFile file(stream, 0);
    const Imath::Box2i window = file.header().dataWindow();
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    if (width < 1 || width > kLargestSide_px) throw std::runtime_error("its data window is no picture's");
    std::vector<float> row(static_cast<std::size_t>(width));
    char* const base = reinterpret_cast<char*>(row.data()) - std::ptrdiff_t{window.min.x} * 4;
    Imf::FrameBuffer buffer;
    for (auto channel = file.header().channels().begin(); channel != file.header().channels().end(); ++channel)
      buffer.insert(channel.name(),
                    Imf::Slice(Imf::FLOAT, base, 4, 0, channel.channel().xSampling, channel.channel().ySampling));
    file.setFrameBuffer(buffer);
    for (int y = window.min.y; y <= window.max.y; ++y) file.readPixels(y);
  });
}

std::map<std::string, std::string> decodeExrText(std::span<const std::byte> data, const std::filesystem::path& path) {
  return reading(path, [&] {
    MemoryReader stream(data);
    const Imf::InputFile file(stream, 0);
    std::map<std::string, std::string> text;
    for (auto entry = file.header().begin(); entry != file.header().end(); ++entry) {
      const auto* attribute = dynamic_cast<const Imf::StringAttribute*>(&entry.attribute());
      if (attribute) text[entry.name()] = attribute->value();
    }
    return text;
  });
}

}  // namespace kiln

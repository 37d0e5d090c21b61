// Writing: pixels are converted some rows at a time, so memory holds the image, these rows and the compressed file. The
// file is published whole or not at all (FileSystem::writeAtomic).
// Reading: lengths are checked before OpenEXR sees the bytes. The picture grows as rows arrive, so a header that claims
// more rows than the file has costs no memory.
#include "image/file/exr_file.h"

#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <half.h>

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "base/refusal.h"
#include "base/thread/parallel.h"
#include "image/file/exr_complete.h"
#include "image/file/exr_cost.h"
#include "image/file/exr_deep_check.h"
#include "image/file/exr_head.h"
#include "image/file/exr_parts.h"
#include "image/image_memory.h"
#include "image/pixel_rect.h"

namespace kiln {
namespace {

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

// Frame buffer of RGBA scanlines that start at pixel `first`, `row_bytes` apart. With `row_bytes` 0 every scanline uses
// the same memory.
template <class T>
Imf::FrameBuffer rowsFrom(std::vector<T>& values, Imf::PixelType type, const Imath::V2i& first, std::size_t row_bytes) {
  Imf::FrameBuffer buffer;
  char* const base = reinterpret_cast<char*>(values.data()) -
                     static_cast<std::ptrdiff_t>(first.x) * static_cast<std::ptrdiff_t>(4 * sizeof(T)) -
                     static_cast<std::ptrdiff_t>(first.y) * static_cast<std::ptrdiff_t>(row_bytes);
  for (std::size_t channel = 0; channel < 4; ++channel) {
    const double fill = channel == 3 ? 1 : 0;
    buffer.insert(kExrChannelNames[channel],
                  Imf::Slice(type, base + channel * sizeof(T), 4 * sizeof(T), row_bytes, 1, 1, fill));
  }
  return buffer;
}

// `image` has the channels of the picture and may be one of its bands.
Imf::Header headerOf(const Image& image, int height, const ImageMetadata& metadata, Imf::PixelType type,
                     Imf::Compression compression) {
  Imf::Header header = exrHeader(image.width, height, metadata, compression);
  for (const char* name : kExrChannelNames) {
    if (!image.rgba.empty()) header.channels().insert(name, Imf::Channel(type));
  }
  for (const Plane& plane : image.planes) header.channels().insert(plane.name, Imf::Channel(Imf::FLOAT));
  return header;
}

// OpenEXR offsets are relative to the corner of the display window. OpenEXR does not write to a slice of an output
// file.
Imf::Slice wholePlane(const Plane& plane, int width, const Imath::V2i& first) {
  constexpr std::ptrdiff_t kBytes = sizeof(float);
  const std::ptrdiff_t before = kBytes * (std::ptrdiff_t{first.y} * width + first.x);
  char* const values = reinterpret_cast<char*>(const_cast<float*>(plane.values.data()));
  return {Imf::FLOAT, values - before, kBytes, static_cast<std::size_t>(kBytes * width)};
}

// Threads and rows for a picture within the memory given by the options.
ExrWork workOf(const Image& image, int height, const ImageFileOptions& options) {
  const ExrShape shape{image.width, height, options.exr_float, sizeof(float) * image.planes.size(),
                       options.exr_compression};
  return exrWorkWithin(shape, options.writer_bytes);
}

// `File` is a one-part file or a part.
template <class T, class File, class Convert>
void writeRowsAs(File& file, ImageRows& picture, Imf::PixelType type, int most, Convert convert) {
  const std::size_t row = static_cast<std::size_t>(picture.width) * 4;
  std::vector<T> values(row * static_cast<std::size_t>(most));
  const Imath::V2i& first = file.header().dataWindow().min;
  for (int y = 0; y < picture.height;) {
    const ImageRows::Band band = picture.bandAt(y);
    const Image& image = *band.image;
    const int rows = std::min(most, band.end() - y);
    if (!image.rgba.empty()) {
      parallelFor(static_cast<std::size_t>(rows), [&](std::size_t i) {
        const float* const from = image.pixel(0, y - band.first_row + static_cast<int>(i));
        std::transform(from, from + row, values.begin() + static_cast<std::ptrdiff_t>(i * row), convert);
      });
    }
    // OpenEXR ignores a slice whose channel is not in the file.
    Imf::FrameBuffer buffer = rowsFrom(values, type, {first.x, first.y + y}, row * sizeof(T));
    for (const Plane& plane : image.planes)
      buffer.insert(plane.name, wholePlane(plane, image.width, {first.x, first.y + band.first_row}));
    file.setFrameBuffer(buffer);
    file.writePixels(rows);
    y += rows;
  }
  requireAllRows(file);
}

// `most`: upper bound of rows converted at a time.
template <class File>
void writeRows(File& file, ImageRows& picture, Imf::PixelType type, int most) {
  if (type == Imf::FLOAT)
    writeRowsAs<float>(file, picture, type, most, [](float v) { return v; });
  else
    writeRowsAs<half>(file, picture, type, most, clampedHalf);
}

void writePicture(Imf::OStream& stream, ImageRows& rows, const ImageMetadata& metadata,
                  const ImageFileOptions& options) {
  const Image& first = *rows.bandAt(0).image;
  const Imf::PixelType type = options.exr_float ? Imf::FLOAT : Imf::HALF;
  const ExrWork work = workOf(first, rows.height, options);
  // The destructor of the file writes the table of scanline offsets.
  Imf::OutputFile file(stream, headerOf(first, rows.height, metadata, type, exrCompression(options.exr_compression)),
                       compressingThreads(work.threads));
  writeRows(file, rows, type, work.rows);
}

// Calls `read` on a hostile file and converts exceptions of OpenEXR to an Error of the file.
template <class Read>
auto reading(const std::filesystem::path& path, Read read) {
  try {
    return read();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    rethrowRefusal();
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
                std::to_string(width) + "x" + std::to_string(height) + " pixels; each side must be from 1 to " +
                    std::to_string(kLargestSide_px));
  }
  const Imf::ChannelList& channels = file.header().channels();
  const bool grey = channels.findChannel("Y") && !channels.findChannel("R");
  requireChannels(channels, grey, path);

  std::vector<float> row(static_cast<std::size_t>(width) * 4);
  Imf::FrameBuffer buffer = rowsFrom(row, Imf::FLOAT, {window.min.x, 0}, 0);
  if (grey) buffer.insert("Y", buffer["R"]);
  file.setFrameBuffer(buffer);
  Image image;
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  // A header may claim more than the file holds: the picture has room for the rows read so far.
  const std::size_t all = static_cast<std::size_t>(width * height) * 4;
  image.rgba.resize(std::clamp(file_bytes * 64, row.size(), all));
  for (int y = window.min.y; y <= window.max.y; ++y) {
    file.readPixels(y);
    for (std::size_t x = 0; grey && x < row.size(); x += 4) row[x + 1] = row[x + 2] = row[x];
    const std::size_t at = row.size() * static_cast<std::size_t>(y - window.min.y);
    const std::size_t end = at + row.size();
    if (end > image.rgba.size()) image.rgba.resize(std::min(2 * end, all));
    std::copy(row.begin(), row.end(), image.rgba.begin() + at);
  }
  return image;
}

// Reads the planes. requires: the rows of the file have been read.
void readPlanes(Imf::InputFile& file, std::span<const std::string> names, const std::filesystem::path& path,
                Image& image) {
  const Imath::Box2i window = file.header().dataWindow();
  for (const std::string& name : names) {
    const Imf::Channel* const channel = file.header().channels().findChannel(name);
    if (channel == nullptr || channel->xSampling != 1 || channel->ySampling != 1)
      throw Error(ErrorCode::kFormat, path, "channel " + name, "is missing or subsampled");
    image.planes.push_back({name, ZeroPages<float>(image.rgba.size() / 4)});
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

// Reads every channel of every row. `File` is a one-part file or a part.
template <class File>
void readAll(File& file) {
  const Imath::Box2i window = file.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  if (width < 1 || width > kLargestSide_px)
    throw std::runtime_error("its data window must be from 1 to " + std::to_string(kLargestSide_px) + " pixels wide");
  std::vector<float> row(static_cast<std::size_t>(width));
  Imf::FrameBuffer buffer;
  for (auto channel = file.header().channels().begin(); channel != file.header().channels().end(); ++channel) {
    const int every_x = channel.channel().xSampling, every_y = channel.channel().ySampling;
    // A channel of every n-th column has its first number at column min.x / n, which OpenEXR requires to be whole.
    char* const base = reinterpret_cast<char*>(row.data()) - std::ptrdiff_t{window.min.x / every_x} * 4;
    buffer.insert(channel.name(), Imf::Slice(Imf::FLOAT, base, 4, 0, every_x, every_y));
  }
  file.setFrameBuffer(buffer);
  for (int y = window.min.y; y <= window.max.y; ++y) file.readPixels(y);
}

// Buffers of all parts, which OpenEXR may allocate at once. unit: bytes.
std::uint64_t bytesOfParts(const std::vector<ExrPart>& head) {
  std::uint64_t out = 0;
  for (const ExrPart& part : head) out += part.buffer_bytes;
  return out;
}

// Memory of a part's picture with `planes` planes. unit: bytes.
std::uint64_t bytesOfImage(const ExrPart& part, std::size_t planes) {
  return static_cast<std::uint64_t>(part.width * part.height) * sizeof(float) * (4 + planes);
}

// Checks a deep file that is read as a flat picture: OpenEXR holds all samples of a row.
void requireDeepRows(std::span<const std::byte> data, std::uint64_t memory_bytes) {
  MemoryReader stream(data);
  Imf::MultiPartInputFile parts(stream, 0);
  if (parts.header(0).hasType() && parts.header(0).type() == Imf::DEEPSCANLINE)
    requireRowsWithin(parts, 0, memory_bytes);
}

}  // namespace

bool looksLikeExr(std::span<const std::byte> data) {
  static constexpr unsigned char kMagic[] = {0x76, 0x2f, 0x31, 0x01};
  return data.size() >= sizeof kMagic && std::memcmp(data.data(), kMagic, sizeof kMagic) == 0;
}

std::vector<std::byte> encodeExr(const Image& image, const ImageMetadata& metadata, const ImageFileOptions& options,
                                 const std::filesystem::path& path) {
  RowsOfImage rows(image);
  ExrWriter stream;
  try {
    writePicture(stream, rows, metadata, options);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    rethrowRefusal();
    throw Error(ErrorCode::kIo, path, "", std::string("OpenEXR cannot write this picture: ") + error.what());
  }
  return stream.take();
}

void encodeExr(ImageRows& rows, const ImageMetadata& metadata, const ImageFileOptions& options,
               const std::filesystem::path& path, ScratchOutput& out) {
  writeExr(out, path, [&](Imf::OStream& stream) { writePicture(stream, rows, metadata, options); });
}

void encodeExrViews(std::span<const ImageView> views, const ImageFileOptions& options,
                    const std::filesystem::path& path, ScratchOutput& out) {
  const Imf::Compression compression = exrCompression(options.exr_compression);
  const Imf::PixelType type = options.exr_float ? Imf::FLOAT : Imf::HALF;
  writeExr(out, path, [&](Imf::OStream& stream) {
    std::vector<Imf::Header> headers;
    for (const ImageView& view : views) {
      Imf::Header& header =
          headers.emplace_back(headerOf(*view.image, view.image->height, view.metadata, type, compression));
      header.setType(Imf::SCANLINEIMAGE);
      header.setName(view.name);
      header.setView(view.name);
    }
    // The buffers of all parts exist at once.
    ImageFileOptions of_part = options;
    of_part.writer_bytes /= views.size();
    const ExrWork work = workOf(*views.front().image, views.front().image->height, of_part);
    Imf::MultiPartOutputFile file(stream, headers.data(), static_cast<int>(headers.size()), false,
                                  compressingThreads(work.threads));
    for (std::size_t i = 0; i < views.size(); ++i) {
      Imf::OutputPart part(file, static_cast<int>(i));
      RowsOfImage rows(*views[i].image);
      writeRows(part, rows, type, work.rows);
    }
  });
}

Image decodeExr(std::span<const std::byte> data, const std::filesystem::path& path, std::span<const std::string> planes,
                std::uint64_t memory_bytes) {
  const std::vector<ExrPart> head = readExrHead(exrBytesOf(data), path);
  const std::uint64_t needed = bytesOfParts(head) + bytesOfImage(head.front(), planes.size());
  requireMemory(needed, memory_bytes, path);
  return reading(path, [&] {
    requireDeepRows(data, memory_bytes - needed);
    MemoryReader stream(data);
    Imf::InputFile file(stream, 0);
    Image image = readRows(file, data.size(), path);
    if (!planes.empty()) readPlanes(file, planes, path, image);
    return image;
  });
}

void checkExr(std::span<const std::byte> data, const std::filesystem::path& path, std::uint64_t memory_bytes) {
  const std::uint64_t needed = bytesOfParts(readExrHead(exrBytesOf(data), path));
  requireMemory(needed, memory_bytes, path);
  reading(path, [&] {
    MemoryReader stream(data);
    Imf::MultiPartInputFile parts(stream, 0);
    if (parts.parts() > 1) {
      for (int i = 0; i < parts.parts(); ++i) {
        if (parts.header(i).type() == Imf::DEEPSCANLINE) {
          checkDeepPart(parts, i, memory_bytes - needed);
          continue;
        }
        Imf::InputPart part(parts, i);
        readAll(part);
      }
      return;
    }
    requireDeepRows(data, memory_bytes - needed);
    MemoryReader again(data);
    Imf::InputFile file(again, 0);
    readAll(file);
  });
}

ExrPart readExrPart(const File& file) {
  const ExrBytes bytes = {file.size(), [&file](std::uint64_t at, std::span<std::byte> out) { file.readAt(at, out); }};
  return readExrHead(bytes, file.path()).front();
}

}  // namespace kiln

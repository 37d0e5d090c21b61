// Streams, headers and conversions shared by the writers of flat and deep OpenEXR files. Not installed: the header
// names OpenEXR.
#pragma once

#include <ImfCompression.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <half.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/refusal.h"
#include "image/file/image_file.h"
#include "image/file/scratch_output.h"

namespace kiln {

inline constexpr const char* kExrChannelNames[] = {"R", "G", "B", "A"};

/// An output file in memory.
class ExrWriter : public Imf::OStream {
 public:
  ExrWriter() : Imf::OStream("memory") {}
  void write(const char data[], int count) override;
  std::uint64_t tellp() override { return place_; }
  void seekp(std::uint64_t place) override { place_ = place; }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
  std::size_t place_ = 0;
};

/// An output file on disk. OpenEXR drops exceptions of its last writes, so the first failure is stored for `finish`.
class ExrScratchWriter : public Imf::OStream {
 public:
  /// requires: `out` outlives this object.
  explicit ExrScratchWriter(ScratchOutput& out) : Imf::OStream("file"), out_(out) {}
  void write(const char data[], int count) override;
  std::uint64_t tellp() override { return place_; }
  void seekp(std::uint64_t place) override { place_ = place; }
  /// throws: the first failure of a write.
  void finish() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  ScratchOutput& out_;
  std::uint64_t place_ = 0;
  std::exception_ptr failure_;
};

/// Calls write(stream), which writes an OpenEXR file to `out`. throws: any exception of `out` and `write`; exceptions
/// of OpenEXR become Error kIo of the file `path`.
template <class Write>
void writeExr(ScratchOutput& out, const std::filesystem::path& path, Write write) {
  ExrScratchWriter stream(out);
  try {
    write(stream);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    stream.finish();
    rethrowRefusal();
    throw Error(ErrorCode::kIo, path, "", std::string("OpenEXR cannot write this picture: ") + error.what());
  }
  stream.finish();
}

/// throws: Error kUsage if no compression has this name.
Imf::Compression exrCompression(const std::string& name);

/// Header with windows and attributes, without channels.
Imf::Header exrHeader(int width, int height, const ImageMetadata& metadata, Imf::Compression compression);

/// Starts OpenEXR's compression threads for a file and returns their number. The threads belong to the process and
/// stay.
int compressingThreads(int wanted);

inline half clampedHalf(float v) { return half(std::clamp(v, -65504.0f, 65504.0f)); }

}  // namespace kiln

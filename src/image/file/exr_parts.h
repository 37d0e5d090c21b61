// What flat and deep OpenEXR files are written with. Not installed: it names OpenEXR.
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
#include "image/file/image_file.h"
#include "image/file/scratch_output.h"

namespace kiln {

inline constexpr const char* kExrChannelNames[] = {"R", "G", "B", "A"};

/// A file in memory.
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

/// A file on disk. OpenEXR drops exceptions of its last writes, so a failure is kept for `finish`.
class ExrScratchWriter : public Imf::OStream {
 public:
  /// requires: `out` outlives this.
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

/// Runs write(stream), which writes a file of OpenEXR to `out`. throws: what `out` and `write` throw; whatever OpenEXR
/// throws as Error kIo of the file `path`.
template <class Write>
void writeExr(ScratchOutput& out, const std::filesystem::path& path, Write write) {
  ExrScratchWriter stream(out);
  try {
    write(stream);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    stream.finish();
    throw Error(ErrorCode::kIo, path, "", std::string("OpenEXR cannot write this picture: ") + error.what());
  }
  stream.finish();
}

/// throws: Error kUsage where there is none of this name.
Imf::Compression exrCompression(const std::string& name);

/// Windows and attributes, without channels.
Imf::Header exrHeader(int width, int height, const ImageMetadata& metadata, Imf::Compression compression);

/// Makes as many of OpenEXR's own threads as are to compress a file, and returns their number. They are the process's,
/// and stay.
int compressingThreads(int wanted);

inline half clampedHalf(float v) { return half(std::clamp(v, -65504.0f, 65504.0f)); }

}  // namespace kiln

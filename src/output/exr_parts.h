// What flat and deep OpenEXR files are written with. Not installed: it names OpenEXR.
#pragma once

#include <ImfCompression.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <half.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "output/image_file.h"

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

/// throws: Error kUsage where there is none of this name.
Imf::Compression exrCompression(const std::string& name);

/// Windows and attributes, without channels.
Imf::Header exrHeader(int width, int height, const ImageMetadata& metadata, Imf::Compression compression);

/// How many of OpenEXR's own threads may compress a file: as many as are in force, none where that is one. They are the
/// process's, and stay.
int compressingThreads();

inline half clampedHalf(float v) { return half(std::clamp(v, -65504.0f, 65504.0f)); }

}  // namespace kiln

// The 348 bytes of a NIfTI-1 header: numbers at documented offsets, in the writer's byte order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace kiln {

class NiftiHeader {
 public:
  static constexpr std::size_t kBytes = 348;

  /// Offsets of the fields. unit: bytes. source: nifti1.h, the comments beside struct nifti_1_header.
  enum Field : std::size_t {
    kSizeofHdr = 0,
    kDim = 40,
    kIntentCode = 68,
    kDatatype = 70,
    kBitpix = 72,
    kPixdim = 76,
    kVoxOffset = 108,
    kSclSlope = 112,
    kSclInter = 116,
    kXyztUnits = 123,
    kQformCode = 252,
    kSformCode = 254,
    kQuaternB = 256,
    kQoffsetX = 268,
    kSrowX = 280,
    kMagic = 344,
  };

  /// requires: `bytes` are the first bytes of the header at `path`; every error names `path`.
  /// throws: Error kUnsupported for NIfTI-2 and ANALYZE, kFormat if the bytes are no header.
  NiftiHeader(std::span<const std::byte, kBytes> bytes, std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  /// True if the voxels are in a file of their own.
  bool pair() const { return magicIs("ni1"); }
  bool bigEndian() const;
  std::int16_t i16(std::size_t at) const;
  double f32(std::size_t at) const;
  int byteAt(std::size_t at) const { return std::to_integer<int>(bytes_[at]); }

  /// Throws an Error kFormat at `place` ("byte 40").
  [[noreturn]] void fail(const std::string& place, const std::string& what) const;
  /// Throws an Error kUnsupported.
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  template <class T>
  T get(std::size_t at, bool swap) const;
  bool magicIs(const char (&magic)[4]) const;

  std::array<std::byte, kBytes> bytes_;
  std::filesystem::path path_;
  bool swap_ = false;
};

}  // namespace kiln

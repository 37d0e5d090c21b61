// The header of a NIfTI-1, NIfTI-2 or ANALYZE 7.5 file: numbers at documented offsets, in the writer's byte order. A
// field has one name in all versions, whatever its place and type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "ingest/bytes/header_bytes.h"

namespace kiln {

enum class NiftiField {
  kDim,
  kIntentCode,
  kDatatype,
  kBitpix,
  kPixdim,
  kVoxOffset,
  kSclSlope,
  kSclInter,
  kXyztUnits,
  kQformCode,
  kSformCode,
  kQuaternB,
  kQoffsetX,
  kSrowX,
};

enum class NiftiVersion { kNifti1, kNifti2, kAnalyze };

class NiftiHeader {
 public:
  /// Reads the header at `path`, raw or in gzip.
  /// throws: Error kFormat if the file is too short or begins with no length of a header; kIo.
  explicit NiftiHeader(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return bytes_.path(); }
  NiftiVersion version() const { return version_; }
  /// "NIfTI-1", "NIfTI-2", "ANALYZE 7.5".
  const char* name() const;
  /// True if the voxels are in a file of their own.
  bool pair() const { return pair_; }
  bool bigEndian() const { return bytes_.bigEndian(); }
  bool inGzip() const { return bytes_.inGzip(); }
  /// The first byte that can hold voxels in the header's file, behind the header and the extension flag. unit: bytes.
  std::int64_t leastOffset() const;

  /// Returns a whole number of a field, number `index` of several. requires: the field is of integers.
  std::int64_t integer(NiftiField field, std::size_t index = 0) const;
  /// Returns a number of a field; integers become floating-point numbers. ANALYZE has no fields behind kVoxOffset: its
  /// numbers are 0.
  double real(NiftiField field, std::size_t index = 0) const;

  /// Throws an Error kFormat at the byte of a field: "byte 40".
  [[noreturn]] void fail(NiftiField field, std::size_t index, const std::string& what) const;
  /// Throws an Error kUnsupported.
  [[noreturn]] void refuse(const std::string& what) const { bytes_.refuse(what); }

 private:
  enum class Kind { kByte, kInt16, kInt32, kInt64, kFloat, kDouble };
  struct Place {
    std::size_t offset;
    Kind kind;
    bool in_analyze = false;
  };
  static std::size_t sizeOf(Kind kind);
  Place placeOf(NiftiField field, std::size_t index) const;

  HeaderBytes bytes_;
  NiftiVersion version_ = NiftiVersion::kNifti1;
  bool pair_ = false;
};

}  // namespace kiln

// NIfTI files written byte by byte from the offsets in nifti1.h and nifti2.h, independently of the tested reader.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace kiln::test {

/// Header fields that tests vary. The default is 5×4×3 unsigned bytes, 1 mm apart, in a single file.
struct NiftiHeader {
  std::array<int, 8> dim = {3, 5, 4, 3, 1, 1, 1, 1};
  int intent_code = 0, datatype = 2, bitpix = 8;
  std::array<float, 8> pixdim = {1, 1, 1, 1, 0, 0, 0, 0};
  float vox_offset = 352, scl_slope = 0, scl_inter = 0;
  int xyzt_units = 2, qform_code = 0, sform_code = 0;
  std::array<float, 6> quatern = {};  // b, c, d, offsets x, y, z
  std::array<float, 12> srow = {};
  const char* magic = "n+1";
  int sizeof_hdr = 348;
  bool big_endian = false;
};

using Bytes = std::vector<std::uint8_t>;

/// The 348 bytes of NIfTI-1, or the 540 of NIfTI-2 if `sizeof_hdr` is 540.
Bytes niftiHeader(const NiftiHeader& header);
/// Returns the header, zeros up to vox_offset, and `voxels` unchanged.
Bytes niftiFile(const NiftiHeader& header, const Bytes& voxels);
/// Appends `value` as an integer of `size` bytes in this byte order.
void appendInteger(Bytes& out, std::int64_t value, std::size_t size, bool big_endian);
/// Appends `value` as NIfTI stores this data type code.
void appendValue(Bytes& out, double value, int datatype, bool big_endian);

Bytes gzipped(const Bytes& data);
void writeBytes(const std::filesystem::path& path, const Bytes& data);

/// A directory that is removed with the object.
class ScratchDirectory {
 public:
  ScratchDirectory();
  ~ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  std::filesystem::path operator/(const char* name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace kiln::test

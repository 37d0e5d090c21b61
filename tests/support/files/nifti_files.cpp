#include "support/files/nifti_files.h"

#include <stdlib.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {

void put(Bytes& out, std::size_t at, std::int64_t value, std::size_t size, bool big_endian) {
  Bytes raw;
  appendInteger(raw, value, size, big_endian);
  std::copy(raw.begin(), raw.end(), out.begin() + static_cast<std::ptrdiff_t>(at));
}

void putFloat(Bytes& out, std::size_t at, float value, bool big_endian) {
  put(out, at, std::bit_cast<std::int32_t>(value), 4, big_endian);
}

void putDouble(Bytes& out, std::size_t at, double value, bool big_endian) {
  put(out, at, std::bit_cast<std::int64_t>(value), 8, big_endian);
}

// Byte offsets of nifti2.h.
Bytes nifti2Header(const NiftiHeader& h) {
  Bytes out(540);
  const bool big = h.big_endian;
  put(out, 0, h.sizeof_hdr, 4, big);
  std::memcpy(out.data() + 4, h.magic, std::min<std::size_t>(std::strlen(h.magic), 4));
  std::memcpy(out.data() + 8, "\r\n\x1a\n", 4);
  put(out, 12, h.datatype, 2, big);
  put(out, 14, h.bitpix, 2, big);
  for (std::size_t i = 0; i < 8; ++i) {
    put(out, 16 + 8 * i, h.dim[i], 8, big);
    putDouble(out, 104 + 8 * i, h.pixdim[i], big);
  }
  put(out, 168, static_cast<std::int64_t>(h.vox_offset), 8, big);
  putDouble(out, 176, h.scl_slope, big);
  putDouble(out, 184, h.scl_inter, big);
  put(out, 344, h.qform_code, 4, big);
  put(out, 348, h.sform_code, 4, big);
  for (std::size_t i = 0; i < 6; ++i) putDouble(out, 352 + 8 * i, h.quatern[i], big);
  for (std::size_t i = 0; i < 12; ++i) putDouble(out, 400 + 8 * i, h.srow[i], big);
  put(out, 500, h.xyzt_units, 4, big);
  put(out, 504, h.intent_code, 4, big);
  return out;
}

}  // namespace

void appendInteger(Bytes& out, std::int64_t value, std::size_t size, bool big_endian) {
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t shift = 8 * (big_endian ? size - 1 - i : i);
    out.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> shift));
  }
}

void appendValue(Bytes& out, double value, int datatype, bool big_endian) {
  switch (datatype) {
    case 16:
      return appendInteger(out, std::bit_cast<std::int32_t>(static_cast<float>(value)), 4, big_endian);
    case 64:
      return appendInteger(out, std::bit_cast<std::int64_t>(value), 8, big_endian);
    case 2:
    case 256:
      return appendInteger(out, static_cast<std::int64_t>(value), 1, big_endian);
    case 4:
    case 512:
      return appendInteger(out, static_cast<std::int64_t>(value), 2, big_endian);
    default:
      return appendInteger(out, static_cast<std::int64_t>(value), 4, big_endian);
  }
}

Bytes niftiHeader(const NiftiHeader& h) {
  if (h.sizeof_hdr == 540) return nifti2Header(h);
  Bytes out(348);
  const bool big = h.big_endian;
  put(out, 0, h.sizeof_hdr, 4, big);
  for (std::size_t i = 0; i < 8; ++i) {
    put(out, 40 + 2 * i, h.dim[i], 2, big);
    putFloat(out, 76 + 4 * i, h.pixdim[i], big);
  }
  put(out, 68, h.intent_code, 2, big);
  put(out, 70, h.datatype, 2, big);
  put(out, 72, h.bitpix, 2, big);
  putFloat(out, 108, h.vox_offset, big);
  putFloat(out, 112, h.scl_slope, big);
  putFloat(out, 116, h.scl_inter, big);
  out[123] = static_cast<std::uint8_t>(h.xyzt_units);
  put(out, 252, h.qform_code, 2, big);
  put(out, 254, h.sform_code, 2, big);
  for (std::size_t i = 0; i < 6; ++i) putFloat(out, 256 + 4 * i, h.quatern[i], big);
  for (std::size_t i = 0; i < 12; ++i) putFloat(out, 280 + 4 * i, h.srow[i], big);
  std::memcpy(out.data() + 344, h.magic, std::min<std::size_t>(std::strlen(h.magic), 4));
  return out;
}

Bytes niftiFile(const NiftiHeader& header, const Bytes& voxels) {
  Bytes out = niftiHeader(header);
  out.resize(static_cast<std::size_t>(header.vox_offset));
  out.insert(out.end(), voxels.begin(), voxels.end());
  return out;
}

Bytes gzipped(const Bytes& data) {
  z_stream stream{};
  if (deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("deflateInit2");
  Bytes out(deflateBound(&stream, data.size()));
  stream.next_in = const_cast<Bytef*>(data.data());
  stream.avail_in = static_cast<uInt>(data.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  if (deflate(&stream, Z_FINISH) != Z_STREAM_END) throw std::runtime_error("deflate");
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

void writeBytes(const std::filesystem::path& path, const Bytes& data) {
  writeAnew(path, {reinterpret_cast<const char*>(data.data()), data.size()});
}

ScratchDirectory::ScratchDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "kiln_test_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  path_ = name;
}

ScratchDirectory::~ScratchDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace kiln::test

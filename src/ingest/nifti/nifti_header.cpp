// The header begins with its own length, which reveals the byte order. Source: nifti1.h, the format's defining header,
// https://nifti.nimh.nih.gov/nifti-1.
#include "ingest/nifti/nifti_header.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "base/error.h"

namespace kiln {
namespace {

constexpr std::int32_t kLength = NiftiHeader::kBytes;
constexpr std::int32_t kNifti2Length = 540;

}  // namespace

NiftiHeader::NiftiHeader(std::span<const std::byte, kBytes> bytes, std::filesystem::path path)
    : path_(std::move(path)) {
  std::copy(bytes.begin(), bytes.end(), bytes_.begin());
  for (const bool swap : {false, true}) {
    if (get<std::int32_t>(kSizeofHdr, swap) == kNifti2Length) {
      refuse("is NIfTI-2, which Kiln does not read; save it as NIfTI-1");
    }
  }
  swap_ = get<std::int32_t>(kSizeofHdr, false) != kLength;
  if (get<std::int32_t>(kSizeofHdr, swap_) != kLength) {
    fail("byte 0", "the header does not begin with its length, 348");
  }
  if (!magicIs("n+1") && !magicIs("ni1")) {
    refuse("is ANALYZE 7.5 or unknown (no NIfTI-1 magic at byte 344); convert it to NIfTI-1");
  }
}

bool NiftiHeader::bigEndian() const { return swap_ == (std::endian::native == std::endian::little); }
std::int16_t NiftiHeader::i16(std::size_t at) const { return get<std::int16_t>(at, swap_); }
double NiftiHeader::f32(std::size_t at) const { return static_cast<double>(get<float>(at, swap_)); }

void NiftiHeader::fail(const std::string& place, const std::string& what) const {
  throw Error(ErrorCode::kFormat, path_, place, what);
}

void NiftiHeader::refuse(const std::string& what) const { throw Error(ErrorCode::kUnsupported, path_, "", what); }

template <class T>
T NiftiHeader::get(std::size_t at, bool swap) const {
  std::array<std::byte, sizeof(T)> raw;
  std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at), sizeof(T), raw.begin());
  if (swap) std::reverse(raw.begin(), raw.end());
  return std::bit_cast<T>(raw);
}

bool NiftiHeader::magicIs(const char (&magic)[4]) const { return std::memcmp(bytes_.data() + kMagic, magic, 4) == 0; }

}  // namespace kiln

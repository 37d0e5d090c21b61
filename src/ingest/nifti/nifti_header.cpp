// The header begins with its own length, which reveals the version and the byte order. Sources: nifti1.h and nifti2.h,
// the formats' defining headers, https://nifti.nimh.nih.gov; ANALYZE 7.5 File Format, Mayo Foundation.
#include "ingest/nifti/nifti_header.h"

#include <fmt/format.h>

#include <array>

#include "base/error.h"

namespace kiln {
namespace {

constexpr std::int32_t kNifti1Length = 348, kNifti2Length = 540;
// nifti1.h: the magic at byte 344; nifti2.h: the magic at byte 4, with the bytes that text transfers damage.
constexpr std::size_t kNifti1Magic = 344, kNifti2Magic = 4;

using namespace std::string_view_literals;

// Sets the byte order in which the first number is a length of a header, and returns the length.
std::int32_t lengthIn(HeaderBytes& bytes) {
  for (const bool big_endian : {false, true}) {
    bytes.setBigEndian(big_endian);
    const auto length = bytes.get<std::int32_t>(0);
    if (length == kNifti1Length || length == kNifti2Length) return length;
  }
  bytes.fail("byte 0", "the header does not begin with its length, 348 or 540");
}

}  // namespace

NiftiHeader::NiftiHeader(const std::filesystem::path& path) : bytes_(readHeaderBytes(path, kNifti1Length)) {
  if (lengthIn(bytes_) == kNifti2Length) {
    const bool big_endian = bytes_.bigEndian();
    bytes_ = readHeaderBytes(path, kNifti2Length);
    bytes_.setBigEndian(big_endian);
    version_ = NiftiVersion::kNifti2;
    pair_ = bytes_.holds(kNifti2Magic, "ni2\0"sv);
    if (!pair_ && !bytes_.holds(kNifti2Magic, "n+2\0"sv))
      bytes_.fail("byte 4", "the header has the length of NIfTI-2, but not its magic");
    return;
  }
  const bool single = bytes_.holds(kNifti1Magic, "n+1\0"sv), nifti_pair = bytes_.holds(kNifti1Magic, "ni1\0"sv);
  pair_ = !single;
  if (!single && !nifti_pair) version_ = NiftiVersion::kAnalyze;
}

const char* NiftiHeader::name() const {
  return version_ == NiftiVersion::kNifti1 ? "NIfTI-1" : version_ == NiftiVersion::kNifti2 ? "NIfTI-2" : "ANALYZE 7.5";
}

std::int64_t NiftiHeader::leastOffset() const {
  constexpr std::int64_t kFlagBytes = 4;
  return static_cast<std::int64_t>(bytes_.size()) + kFlagBytes;
}

std::size_t NiftiHeader::sizeOf(Kind kind) {
  constexpr std::size_t kBytes[] = {1, 2, 4, 8, 4, 8};
  return kBytes[static_cast<std::size_t>(kind)];
}

NiftiHeader::Place NiftiHeader::placeOf(NiftiField field, std::size_t index) const {
  using enum Kind;
  // In the order of NiftiField.
  constexpr std::array<Place, 14> kNifti1 = {{{40, kInt16, true},
                                              {68, kInt16},
                                              {70, kInt16, true},
                                              {72, kInt16, true},
                                              {76, kFloat, true},
                                              {108, kFloat, true},
                                              {112, kFloat},
                                              {116, kFloat},
                                              {123, kByte},
                                              {252, kInt16},
                                              {254, kInt16},
                                              {256, kFloat},
                                              {268, kFloat},
                                              {280, kFloat}}};
  constexpr std::array<Place, 14> kNifti2 = {{{16, kInt64},
                                              {504, kInt32},
                                              {12, kInt16},
                                              {14, kInt16},
                                              {104, kDouble},
                                              {168, kInt64},
                                              {176, kDouble},
                                              {184, kDouble},
                                              {500, kInt32},
                                              {344, kInt32},
                                              {348, kInt32},
                                              {352, kDouble},
                                              {376, kDouble},
                                              {400, kDouble}}};
  Place out = (version_ == NiftiVersion::kNifti2 ? kNifti2 : kNifti1)[static_cast<std::size_t>(field)];
  out.offset += index * sizeOf(out.kind);
  return out;
}

std::int64_t NiftiHeader::integer(NiftiField field, std::size_t index) const {
  const Place place = placeOf(field, index);
  if (version_ == NiftiVersion::kAnalyze && !place.in_analyze) return 0;
  switch (place.kind) {
    case Kind::kByte:
      return bytes_.get<std::uint8_t>(place.offset);
    case Kind::kInt16:
      return bytes_.get<std::int16_t>(place.offset);
    case Kind::kInt32:
      return bytes_.get<std::int32_t>(place.offset);
    default:
      return bytes_.get<std::int64_t>(place.offset);
  }
}

double NiftiHeader::real(NiftiField field, std::size_t index) const {
  const Place place = placeOf(field, index);
  if (version_ == NiftiVersion::kAnalyze && !place.in_analyze) return 0;
  if (place.kind == Kind::kFloat) return bytes_.f32(place.offset);
  if (place.kind == Kind::kDouble) return bytes_.get<double>(place.offset);
  return static_cast<double>(integer(field, index));
}

void NiftiHeader::fail(NiftiField field, std::size_t index, const std::string& what) const {
  bytes_.fail(fmt::format("byte {}", placeOf(field, index).offset), what);
}

}  // namespace kiln

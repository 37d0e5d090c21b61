// Extracts the few attributes that a volume needs. Attributes of a frame are searched in its own functional group, then
// in the shared group, then at the top of the file.
// Source: DICOM PS3.3, C.7.6 for images, C.7.6.16 for functional groups; PS3.5, annex A for transfer syntaxes.
#include "ingest/dicom/dicom_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "base/error.h"
#include "base/file/file.h"
#include "ingest/dicom/dicom_elements.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr DicomTag kModality = 0x00080060, kDescription = 0x0008103e, kThickness = 0x00180050, kBetween = 0x00180088,
                   kSeries = 0x0020000e, kInstance = 0x00200013, kPosition = 0x00200032, kOrientation = 0x00200037,
                   kSamples = 0x00280002, kPhotometric = 0x00280004, kFrames = 0x00280008, kRows = 0x00280010,
                   kColumns = 0x00280011, kSpacing = 0x00280030, kBitsAllocated = 0x00280100, kBitsStored = 0x00280101,
                   kHighBit = 0x00280102, kSigned = 0x00280103, kIntercept = 0x00281052, kSlope = 0x00281053,
                   kFrameOffsets = 0x3004000c, kDoseScaling = 0x3004000e;
// Functional groups: shared by all frames, one for each frame, and their members.
constexpr DicomTag kShared = 0x52009229, kPerFrame = 0x52009230, kPlanePosition = 0x00209113,
                   kPlaneOrientation = 0x00209116, kMeasures = 0x00289110, kTransformation = 0x00289145;

constexpr DicomTag kSegmentation = 0x00620001, kSegmentOfFrame = 0x0062000a, kSegmentNumber = 0x0062000b,
                   kLargestFraction = 0x0062000e;

// Limit of the frames of a file, of which each takes about 200 bytes of memory.
constexpr std::int64_t kMostFrames = 1'000'000;

// Places of a frame's attribute, in order of precedence: its own group, the shared group, the top of the file. Null
// if a group is missing.
std::array<const DicomSet*, 3> placesOf(const DicomSet& top, std::size_t frame, DicomTag group) {
  const auto in = [&](const DicomSet* set) { return set == nullptr ? nullptr : set->item(group); };
  return {in(top.item(kPerFrame, frame)), in(top.item(kShared)), &top};
}

std::vector<double> frameNumbers(const DicomSet& top, std::size_t frame, DicomTag group, DicomTag tag) {
  for (const DicomSet* const place : placesOf(top, frame, group)) {
    if (place == nullptr) continue;
    if (std::vector<double> out = place->numbers(tag); !out.empty()) return out;
  }
  return {};
}

// Returns a number that rescales values; nothing if the file has no value or an empty value.
std::optional<double> rescaling(const DicomSet& top, std::size_t frame, DicomTag tag, const fs::path& path) {
  for (const DicomSet* const place : placesOf(top, frame, kTransformation)) {
    const std::string text = place == nullptr ? "" : trimmed(place->text(tag));
    if (text.empty()) continue;
    const std::vector<double> numbers = place->numbers(tag);
    if (numbers.size() == 1) return numbers[0];
    throw Error(ErrorCode::kFormat, path, nameOf(tag), inQuotes(text) + " is not a number, so that no value is known");
  }
  return std::nullopt;
}

glm::dvec3 vectorAt(const std::vector<double>& numbers, std::size_t at) {
  return {numbers[at], numbers[at + 1], numbers[at + 2]};
}

DicomFrame frameOf(const DicomSet& top, std::size_t index, const fs::path& path) {
  DicomFrame out;
  if (const auto p = frameNumbers(top, index, kPlanePosition, kPosition); p.size() == 3) out.position = vectorAt(p, 0);
  if (const auto o = frameNumbers(top, index, kPlaneOrientation, kOrientation); o.size() == 6) {
    out.along_row = vectorAt(o, 0);
    out.along_column = vectorAt(o, 3);
  }
  // DICOM gives the distance of rows first.
  if (const auto s = frameNumbers(top, index, kMeasures, kSpacing); s.size() == 2) {
    out.spacing = glm::dvec2(s[1], s[0]);
    if (!(s[0] > 0 && s[1] > 0))
      throw Error(
          ErrorCode::kFormat, path, nameOf(kSpacing),
          fmt::format("expected distances of pixels above 0 (found {:g} and {:g} mm); correct the header", s[0], s[1]));
  }
  const auto measure = [&](DicomTag tag) {
    const std::vector<double> numbers = frameNumbers(top, index, kMeasures, tag);
    return numbers.size() == 1 ? std::abs(numbers[0]) : 0;
  };
  out.between = measure(kBetween);
  out.thickness = measure(kThickness);
  // A dose has its own additional factor.
  const std::optional<double> slope = rescaling(top, index, kSlope, path),
                              dose = rescaling(top, index, kDoseScaling, path);
  if (slope || dose) out.slope = slope.value_or(1) * dose.value_or(1);
  out.slope_is_zero = out.slope == 0;
  if (out.slope_is_zero) out.slope.reset();
  out.intercept = rescaling(top, index, kIntercept, path);
  return out;
}

// Places frames that have no position of their own. The file's position belongs to the first frame. A dose grid gives
// the offsets of its frames along one axis, relative to the first frame. Other frames have no known position.
void placeFrames(const DicomSet& top, std::vector<DicomFrame>& frames) {
  const DicomSet* const own = top.item(kPerFrame);
  if (frames.size() == 1 || (own != nullptr && own->item(kPlanePosition) != nullptr)) return;
  const std::vector<double> offsets = top.numbers(kFrameOffsets);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    DicomFrame& frame = frames[i];
    if (offsets.size() == frames.size() && frame.position && frame.along_row) {
      *frame.position += glm::cross(*frame.along_row, *frame.along_column) * (offsets[i] - offsets[0]);
    } else {
      frame.position.reset();
    }
  }
}

std::string refusalOf(const DicomFile& file, const DicomPixels& pixels) {
  constexpr std::array kPlain = {"1.2.840.10008.1.2", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.1.99",
                                 "1.2.840.10008.1.2.2", ""};
  // Run lengths, then the kinds of JPEG, JPEG-LS and JPEG 2000 that hold one image.
  constexpr std::array kPacked = {"1.2.840.10008.1.2.5",    "1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51",
                                  "1.2.840.10008.1.2.4.57", "1.2.840.10008.1.2.4.70", "1.2.840.10008.1.2.4.80",
                                  "1.2.840.10008.1.2.4.81", "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.4.91"};
  const auto among = [&](const auto& list) {
    return std::find(list.begin(), list.end(), file.transfer_syntax) != list.end();
  };
  const int samples = file.set.number(kSamples).value_or(1);
  const std::string photometric = file.set.text(kPhotometric);
  if (file.float_pixels) return "holds its pixels as floats, which are not read";
  if (file.deflated_offset_bytes > 0 && !file.pixels_bytes)
    return "is deflated, and its pixels are compressed once more";
  if (photometric == "PALETTE COLOR") return "holds indices into a palette of colours, not one value a pixel";
  if (samples != 1) return fmt::format("holds {} samples a pixel ({}); Kiln reads one", samples, inQuotes(photometric));
  const std::string segmentation = file.set.text(kSegmentation);
  const bool fractional = segmentation == "FRACTIONAL";
  if (fractional && pixels.bits_allocated != 8)
    return fmt::format("holds fractions of segments in {} bits; 8 are read", pixels.bits_allocated);
  if (fractional || (segmentation == "BINARY" && pixels.bits_allocated == 1)) {
    if (pixels.packed) return "holds compressed segments, which are not read";
    if (file.big_endian) return "holds segments in big-endian words, which are not read";
  } else if (pixels.bits_allocated != 8 && pixels.bits_allocated != 16 && pixels.bits_allocated != 32) {
    return fmt::format("allocates {} bits a pixel; 8, 16 and 32 are read", pixels.bits_allocated);
  }
  if (!among(kPlain) && !among(kPacked)) {
    return fmt::format("has its pixels in transfer syntax {}, which is not read", inQuotes(file.transfer_syntax));
  }
  if (among(kPacked) && pixels.high_bit != pixels.bits_stored - 1) {
    return fmt::format("is compressed with {} bits stored up to bit {}, which is not read", pixels.bits_stored,
                       pixels.high_bit);
  }
  return "";
}

DicomPixels pixelsOf(const DicomFile& file, const fs::path& path) {
  const auto fail = [&](DicomTag tag, const std::string& what) {
    throw Error(ErrorCode::kFormat, path, nameOf(tag), what);
  };
  const DicomSet& set = file.set;
  DicomPixels out;
  out.rows = set.number(kRows).value_or(0);
  out.columns = set.number(kColumns).value_or(0);
  if (out.rows < 1 || out.columns < 1) fail(kRows, fmt::format("{} rows of {} pixels", out.rows, out.columns));
  if (const auto frames = set.numbers(kFrames); frames.size() == 1) {
    if (!(frames[0] >= 0)) fail(kFrames, fmt::format("{} frames", frames[0]));
    if (frames[0] > static_cast<double>(kMostFrames))
      throw Error(ErrorCode::kUnsupported, path, nameOf(kFrames),
                  fmt::format("at most {} frames are read (found {})", kMostFrames, frames[0]));
    // Some programs write 0 for an image without further frames.
    out.frames = std::max<std::int64_t>(static_cast<std::int64_t>(frames[0]), 1);
  }
  out.bits_allocated = set.number(kBitsAllocated).value_or(0);
  out.bits_stored = set.number(kBitsStored).value_or(out.bits_allocated);
  out.high_bit = set.number(kHighBit).value_or(out.bits_stored - 1);
  out.is_signed = set.number(kSigned).value_or(0) == 1;
  out.smallest_is_white = trimmed(set.text(kPhotometric)) == "MONOCHROME1";
  if (out.bits_stored < 1 || out.bits_stored > out.bits_allocated || out.high_bit < out.bits_stored - 1 ||
      out.high_bit >= out.bits_allocated) {
    fail(kBitsStored,
         fmt::format("{} bits stored up to bit {} of {} allocated", out.bits_stored, out.high_bit, out.bits_allocated));
  }
  out.big_endian = file.big_endian;
  out.in_words = file.big_endian && out.bits_allocated == 8 && file.pixels_representation == "OW";
  out.packed = !file.pixels_bytes.has_value();
  out.deflated_offset_bytes = file.deflated_offset_bytes;
  out.offset_bytes = file.pixels_offset_bytes;
  out.transfer_syntax = file.transfer_syntax;
  return out;
}

void requirePixels(const DicomPixels& pixels, const DicomFile& parsed, const File& file) {
  // Upper bound for the expansion by deflate (zlib's technical notes, "Maximum Compression Factor").
  constexpr std::uint64_t kMaxExpansion = 1032;
  const std::uint64_t room = pixels.deflated_offset_bytes > 0
                                 ? kMaxExpansion * (file.size() - pixels.deflated_offset_bytes)
                                 : file.size() - pixels.offset_bytes;
  const std::uint64_t said = parsed.pixels_bytes.value_or(room);
  const auto count = static_cast<std::uint64_t>(pixels.frames);
  const auto frame_bits =
      static_cast<std::uint64_t>(pixels.columns * pixels.rows) * static_cast<std::uint64_t>(pixels.bits_allocated);
  // Each compressed frame takes at least the tag and the length of one item (8 bytes).
  if (pixels.packed ? count <= room / 8 : count <= std::min({room, said, UINT64_MAX / 8}) * 8 / frame_bits) return;
  throw Error(ErrorCode::kFormat, file.path(), fmt::format("byte {}", pixels.offset_bytes),
              fmt::format("{} x {} x {} pixels of {} bits should follow, but there are {} bytes; the file is cut short "
                          "or its header is wrong",
                          pixels.columns, pixels.rows, count, pixels.bits_allocated, std::min(room, said)));
}

// throws: Error kFormat if the frame's slope and intercept leave the range of a float.
DicomFrame checkedFrame(const DicomSet& set, std::size_t index, const DicomHeader& header, const fs::path& path) {
  DicomFrame out = frameOf(set, index, path);
  const ValueMap map = out.map(header.pixels.storedType(), VoxelType::f32);
  if (map.leavesFloat())
    throw Error(
        ErrorCode::kFormat, path, nameOf(kSlope),
        fmt::format("slope {:g} and intercept {:g} take values beyond what a float can hold, {:g} to {:g}; "
                    "correct the header",
                    map.slope, map.intercept, std::numeric_limits<float>::min(), std::numeric_limits<float>::max()));
  return out;
}

// throws: Error kFormat if a frame names no segment.
std::vector<int> segmentsOf(const DicomSet& top, std::size_t frames, const fs::path& path) {
  if (top.item(kPerFrame, frames - 1) == nullptr)
    throw Error(ErrorCode::kFormat, path, fmt::format("frame {}", frames), "has no group of its own, and so no place");
  std::vector<int> out;
  for (std::size_t i = 0; i < frames; ++i) {
    for (const DicomSet* const place : placesOf(top, i, kSegmentOfFrame)) {
      const int number = place == nullptr ? 0 : place->number(kSegmentNumber).value_or(0);
      if (number == 0) continue;
      out.push_back(number);
      break;
    }
    if (out.size() == i) throw Error(ErrorCode::kFormat, path, fmt::format("frame {}", i + 1), "names no segment");
  }
  return out;
}

}  // namespace

VoxelType DicomPixels::storedType() const {
  if (bits_allocated <= 8) return is_signed ? VoxelType::i8 : VoxelType::u8;
  if (bits_allocated == 16) return is_signed ? VoxelType::i16 : VoxelType::u16;
  return is_signed ? VoxelType::i32 : VoxelType::u32;
}

namespace {

// Fills the pixels and the frames of `out`. throws: Error if the header contradicts itself or the file.
void readFrames(const DicomFile& parsed, const File& file, DicomHeader& out) {
  out.pixels = pixelsOf(parsed, out.path);
  out.refusal = refusalOf(parsed, out.pixels);
  if (!out.refusal.empty()) return;
  requirePixels(out.pixels, parsed, file);
  const auto count = static_cast<std::size_t>(out.pixels.frames);
  try {
    if (parsed.set.text(kSegmentation) == "FRACTIONAL")
      out.largest_fraction = parsed.set.number(kLargestFraction).value_or(255);
    if (out.pixels.bits_allocated == 1 || out.largest_fraction) out.segments = segmentsOf(parsed.set, count, out.path);
    for (std::size_t i = 0; i < count; ++i) out.frames.push_back(checkedFrame(parsed.set, i, out, out.path));
    if (std::optional<DicomLut> lut = modalityLut(parsed.set, out.pixels.is_signed, out.path))
      out.lut = std::make_shared<const DicomLut>(*std::move(lut));
  } catch (const Error& error) {
    // Only slices taken into the volume must be valid.
    out.fault = error;
    return;
  }
  placeFrames(parsed.set, out.frames);
  if (!out.pixels.packed) return;
  std::vector<std::vector<ByteRange>> fragments = dicomFragments(file, out.pixels.offset_bytes, count);
  for (std::size_t i = 0; i < count; ++i) out.frames[i].fragments = std::move(fragments[i]);
}

}  // namespace

DicomHeader readDicomHeader(const fs::path& path) {
  const File file(path);
  const DicomFile parsed = readDicomElements(
      file, {kModality,       kDescription,  kThickness,      kBetween,       kSeries,           kInstance,
             kPosition,       kOrientation,  kSamples,        kPhotometric,   kFrames,           kRows,
             kColumns,        kSpacing,      kBitsAllocated,  kBitsStored,    kHighBit,          kSigned,
             kIntercept,      kSlope,        kModalityLut,    kLutDescriptor, kLutData,          kFrameOffsets,
             kDoseScaling,    kShared,       kPerFrame,       kPlanePosition, kPlaneOrientation, kMeasures,
             kTransformation, kSegmentation, kSegmentOfFrame, kSegmentNumber, kLargestFraction});
  DicomHeader out;
  out.path = path;
  out.series = parsed.set.text(kSeries);
  out.description = parsed.set.text(kDescription);
  out.modality = parsed.set.text(kModality);
  out.instance = integerOf(trimmed(parsed.set.text(kInstance)));
  out.is_image = parsed.set.find(kRows) != nullptr;
  out.damage = parsed.fault;
  out.has_pixels = parsed.pixels_offset_bytes > 0 && !out.damage;
  if (!out.has_pixels) return out;
  try {
    readFrames(parsed, file, out);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kFormat && error.code() != ErrorCode::kUnsupported) throw;
    out.damage = error;
    out.has_pixels = false;
  }
  return out;
}

}  // namespace kiln

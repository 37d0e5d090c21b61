#include "support/files/dicom_files.h"

#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gtest/gtest.h>

#include <cstdint>

#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {

// Appends elements in one of the three encodings.
class Elements {
 public:
  explicit Elements(DicomSyntax syntax)
      : syntax_(syntax == DicomSyntax::kDeflated ? DicomSyntax::kExplicitLittle : syntax) {}

  void text(std::uint16_t group, std::uint16_t element, const char* vr, std::string value) {
    if (value.empty()) return;
    if (value.size() % 2 == 1) value += vr == std::string("UI") ? '\0' : ' ';
    add(group, element, vr, value);
  }
  void number(std::uint16_t group, std::uint16_t element, int value) {
    std::string bytes;
    integer(bytes, static_cast<std::uint64_t>(value), 2);
    add(group, element, "US", bytes);
  }
  void add(std::uint16_t group, std::uint16_t element, const char* vr, const std::string& value) {
    integer(bytes_, group, 2);
    integer(bytes_, element, 2);
    const std::string name(vr);
    if (syntax_ == DicomSyntax::kImplicitLittle) {
      integer(bytes_, value.size(), 4);
    } else if (name == "OB" || name == "OW" || name == "SQ" || name == "UN") {
      bytes_ += name + std::string(2, '\0');
      integer(bytes_, value.size(), 4);
    } else {
      bytes_ += name;
      integer(bytes_, value.size(), 2);
    }
    bytes_ += value;
  }
  // Appends a sequence of items, which hold elements of their own.
  void sequence(std::uint16_t group, std::uint16_t element, const std::vector<Elements>& items) {
    std::string value;
    for (const Elements& item : items) {
      integer(value, 0xfffe, 2);
      integer(value, 0xe000, 2);
      integer(value, item.bytes_.size(), 4);
      value += item.bytes_;
    }
    add(group, element, "SQ", value);
  }
  Elements empty() const { return Elements(syntax_); }
  const std::string& bytes() const { return bytes_; }

 private:
  void integer(std::string& out, std::uint64_t value, int size) const {
    for (int i = 0; i < size; ++i) {
      const int shift = 8 * (syntax_ == DicomSyntax::kExplicitBig ? size - 1 - i : i);
      out += static_cast<char>(value >> shift & 0xff);
    }
  }
  DicomSyntax syntax_;
  std::string bytes_;
};

std::string metaHeader(DicomSyntax syntax, DicomPreamble preamble) {
  if (preamble == DicomPreamble::kNone) return "";
  constexpr const char* kUids[] = {"1.2.840.10008.1.2.1", "1.2.840.10008.1.2", "1.2.840.10008.1.2.2",
                                   "1.2.840.10008.1.2.1.99"};
  Elements meta(DicomSyntax::kExplicitLittle);
  meta.add(2, 1, "OB", std::string("\0\1", 2));
  meta.text(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.2");
  meta.text(2, 3, "UI", "1.2.3.4.5");
  meta.text(2, 0x10, "UI", kUids[static_cast<int>(syntax)]);
  meta.text(2, 0x12, "UI", "1.2.3");
  Elements length(DicomSyntax::kExplicitLittle);
  const auto n = static_cast<std::uint32_t>(meta.bytes().size());
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(n >> (8 * i) & 0xff);
  length.add(2, 0, "UL", bytes);
  std::string first(128, '\0');
  if (preamble == DicomPreamble::kTiff) first.replace(0, 8, std::string("II*\0\x08\0\0\0", 8));
  return first + "DICM" + length.bytes() + meta.bytes();
}

void addFunctionalGroups(Elements& out, const DicomSpec& spec) {
  const auto wrapped = [&](std::uint16_t group, std::uint16_t element, const Elements& item, Elements& into) {
    into.sequence(group, element, {item});
  };
  Elements orientation = out.empty(), measures = out.empty(), values = out.empty(), shared = out.empty();
  orientation.text(0x20, 0x37, "DS", spec.orientation);
  measures.text(0x18, 0x50, "DS", spec.thickness);
  measures.text(0x28, 0x30, "DS", spec.spacing);
  values.text(0x28, 0x1052, "DS", spec.intercept);
  values.text(0x28, 0x1053, "DS", spec.slope);
  wrapped(0x20, 0x9116, orientation, shared);
  wrapped(0x28, 0x9110, measures, shared);
  wrapped(0x28, 0x9145, values, shared);
  std::vector<Elements> frames;
  for (std::size_t i = 0; i < spec.frame_positions.size(); ++i) {
    Elements position = out.empty(), segment = out.empty(), frame = out.empty();
    position.text(0x20, 0x32, "DS", spec.frame_positions[i]);
    wrapped(0x20, 0x9113, position, frame);
    if (i < spec.frame_segments.size()) {
      segment.number(0x62, 0x0b, spec.frame_segments[i]);
      wrapped(0x62, 0x0a, segment, frame);
    }
    frames.push_back(frame);
  }
  out.sequence(0x5200, 0x9229, {shared});
  out.sequence(0x5200, 0x9230, frames);
}

}  // namespace

std::string dicomFile(const DicomSpec& spec) {
  const bool grouped = !spec.frame_positions.empty();
  Elements out(spec.syntax);
  out.text(0x08, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2");
  out.text(0x08, 0x18, "UI", "1.2.3.4.5");
  out.text(0x08, 0x60, "CS", spec.modality);
  out.text(0x08, 0x103e, "LO", spec.description);
  if (!grouped) out.text(0x18, 0x50, "DS", spec.thickness);
  out.text(0x20, 0x0d, "UI", "1.2.3");
  out.text(0x20, 0x0e, "UI", spec.series);
  out.text(0x20, 0x13, "IS", spec.instance);
  if (!grouped) {
    out.text(0x20, 0x32, "DS", spec.position);
    out.text(0x20, 0x37, "DS", spec.orientation);
  }
  out.number(0x28, 0x02, spec.samples);
  out.text(0x28, 0x04, "CS", spec.photometric);
  if (spec.frames != 1) out.text(0x28, 0x08, "IS", std::to_string(spec.frames));
  if (spec.image) {
    out.number(0x28, 0x10, spec.rows);
    out.number(0x28, 0x11, spec.columns);
  }
  if (!grouped) out.text(0x28, 0x30, "DS", spec.spacing);
  out.number(0x28, 0x100, spec.bits_allocated);
  out.number(0x28, 0x101, spec.bits_stored);
  out.number(0x28, 0x102, spec.high_bit < 0 ? spec.bits_stored - 1 : spec.high_bit);
  out.number(0x28, 0x103, spec.is_signed ? 1 : 0);
  if (!grouped) {
    out.text(0x28, 0x1052, "DS", spec.intercept);
    out.text(0x28, 0x1053, "DS", spec.slope);
  }
  if (!spec.lut_descriptor.empty()) {
    Elements table = out.empty();
    table.add(0x28, 0x3002, "US", spec.lut_descriptor);
    table.add(0x28, 0x3006, "OW", spec.lut_data);
    out.sequence(0x28, 0x3000, {table});
  }
  out.text(0x62, 0x01, "CS", spec.segmentation);
  out.text(0x3004, 0x0c, "DS", spec.frame_offsets);
  out.text(0x3004, 0x0e, "DS", spec.dose_scaling);
  if (grouped) addFunctionalGroups(out, spec);
  Elements pixels(spec.syntax);
  if (spec.pixels) {
    const std::string padding(spec.pixel_bytes.size() % 2, '\0');
    pixels.add(0x7fe0, 0x10, spec.bits_allocated == 8 && !spec.in_words ? "OB" : "OW", spec.pixel_bytes + padding);
  }
  const std::string elements = out.bytes() + spec.elements + pixels.bytes();
  return metaHeader(spec.syntax, spec.preamble) +
         (spec.syntax == DicomSyntax::kDeflated ? deflatedAlone(elements) : elements);
}

std::string dicomDirectory(const std::vector<std::string>& files) {
  Elements out(DicomSyntax::kExplicitLittle);
  std::vector<Elements> records;
  for (const std::string& file : files) {
    Elements& record = records.emplace_back(DicomSyntax::kExplicitLittle);
    record.text(4, 0x1430, "CS", "IMAGE");
    record.text(4, 0x1500, "CS", file);
  }
  out.sequence(4, 0x1220, records);
  return metaHeader(DicomSyntax::kExplicitLittle, DicomPreamble::kZeros) + out.bytes();
}

void compressDicom(const std::filesystem::path& path, DicomCodec codec) {
  constexpr gdcm::TransferSyntax::TSType kSyntaxes[] = {
      gdcm::TransferSyntax::RLELossless, gdcm::TransferSyntax::JPEGLosslessProcess14_1,
      gdcm::TransferSyntax::JPEGLSLossless, gdcm::TransferSyntax::JPEG2000Lossless};
  gdcm::ImageReader reader;
  reader.SetFileName(path.c_str());
  ASSERT_TRUE(reader.Read());
  gdcm::ImageChangeTransferSyntax change;
  change.SetTransferSyntax(kSyntaxes[static_cast<int>(codec)]);
  change.SetInput(reader.GetImage());
  ASSERT_TRUE(change.Change());
  gdcm::ImageWriter writer;
  writer.SetFile(reader.GetFile());
  writer.SetImage(change.GetOutput());
  writer.SetFileName(path.c_str());
  ASSERT_TRUE(writer.Write());
}

}  // namespace kiln::test

// The elements at the front of a DICOM file, as a tree of sequences, up to the pixels. This walks every length itself:
// GDCM, as Debian builds it, ends the process at a file that is cut short, so that it is shown compressed frames only.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ingest/dicom/dicom_bytes.h"

namespace kiln {

struct DicomElement;

/// The elements of a file or of an item of a sequence that the parser was asked for.
class DicomSet {
 public:
  void add(DicomElement element);
  /// Null where there is none.
  const DicomElement* find(DicomTag tag) const;
  /// The first item of the sequence `tag`, or item `index`; null where there is none.
  const DicomSet* item(DicomTag tag, std::size_t index = 0) const;
  /// The value as text without the padding behind it; empty where there is none.
  std::string text(DicomTag tag) const;
  /// The finite numbers of a value in text; empty where one of them is none.
  std::vector<double> numbers(DicomTag tag) const;
  /// An unsigned short.
  std::optional<int> number(DicomTag tag) const;

 private:
  std::vector<DicomElement> elements_;
};

struct DicomElement {
  DicomTag tag = 0;
  bool big_endian = false;
  std::string value;
  std::vector<DicomSet> items;
};

struct DicomFile {
  std::string transfer_syntax;
  bool big_endian = false;
  DicomSet set;
  /// Where the deflated stream begins, which holds all elements but the first group; 0 where there is none.
  std::uint64_t deflated_offset_bytes = 0;
  /// The pixels are 32- or 64-bit floats, under tags of their own.
  bool float_pixels = false;
  /// In the inflated elements where there are such. Just behind the tag, the representation and the length of the pixel
  /// data; 0 where there is none.
  std::uint64_t pixels_offset_bytes = 0;
  /// Empty where the pixels are in fragments, whose number is not known.
  std::optional<std::uint64_t> pixels_bytes;
  /// OB or OW, as far as the file says.
  std::string pixels_representation;
};

/// Reads up to the pixel data and keeps the elements of `wanted`, in sequences of `wanted`, too.
/// throws: Error kFormat with the byte and the element where the file is not DICOM, is cut short or contradicts itself;
/// kIo. cost: reads little more than the elements' heads; a file that is deflated as a whole is unpacked up to its
/// pixels.
DicomFile readDicomElements(const File& file, const std::vector<DicomTag>& wanted);

}  // namespace kiln

// Parses the elements of a DICOM file, up to the pixels, as a tree of sequences. The parser checks every length itself:
// GDCM, as Debian builds it, crashes on a file that is cut short, so GDCM only gets compressed frames.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "ingest/dicom/dicom_bytes.h"

namespace kiln {

struct DicomElement;

/// The wanted elements of a file or of an item of a sequence.
class DicomSet {
 public:
  void add(DicomElement element);
  /// Null if the set has no such element.
  const DicomElement* find(DicomTag tag) const;
  /// Returns item `index` of the sequence `tag`; null if there is no such item.
  const DicomSet* item(DicomTag tag, std::size_t index = 0) const;
  /// Returns the value as text without trailing padding; empty if there is no value.
  std::string text(DicomTag tag) const;
  /// Returns the finite numbers of a text value; empty if any of them is not a finite number.
  std::vector<double> numbers(DicomTag tag) const;
  /// Returns all numbers of a value of unsigned shorts; empty if there is no value.
  std::vector<std::uint16_t> shorts(DicomTag tag) const;
  /// Returns an unsigned short.
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
  /// Begin of the deflated stream, which holds all elements but the first group; 0 in files that are not deflated.
  std::uint64_t deflated_offset_bytes = 0;
  /// The pixels are 32- or 64-bit floats, under tags of their own.
  bool float_pixels = false;
  /// Begin of the pixels, behind tag, representation and length; 0 without pixel data. In a deflated file the offset
  /// counts in the inflated elements.
  std::uint64_t pixels_offset_bytes = 0;
  /// Empty if the pixels are in fragments, whose total size is unknown.
  std::optional<std::uint64_t> pixels_bytes;
  /// OB or OW; empty if the file gives no representation.
  std::string pixels_representation;
  /// The reason why parsing ended before the pixels, with the byte and the element; empty if it did not. All other
  /// members hold what was parsed before.
  std::optional<Error> fault;
};

/// Reads up to the pixel data and keeps the elements of `wanted`, also inside sequences of `wanted`.
/// A file that is cut short or contradicts itself is returned with its fault.
/// throws: Error kFormat if the file is not DICOM; kIo.
/// cost: reads little more than the elements' heads; a deflated file is inflated up to its pixels.
DicomFile readDicomElements(const File& file, const std::vector<DicomTag>& wanted);

}  // namespace kiln

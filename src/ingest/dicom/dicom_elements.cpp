// Problem. DICOM elements nest in sequences, with explicit lengths or end marks, and may be damaged anywhere.
// Method. One recursive walk; explicit elements carry their value representation, implicit elements do not.
// Invariant. Every step forward is checked against the enclosing element, and the outermost against the file.
// Source. DICOM PS3.5: 7.1 elements, 7.5 sequences, 6.2.2 unknown representations.
#include "ingest/dicom/dicom_elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "ingest/dicom/dicom_bytes.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

constexpr DicomTag kItemEnd = 0xfffee00d;
constexpr DicomTag kPixelData = 0x7fe00010, kFloatPixelData = 0x7fe00008, kDoublePixelData = 0x7fe00009,
                   kTransferSyntax = 0x00020010;
constexpr const char* kDeflated = "1.2.840.10008.1.2.1.99";
constexpr std::uint32_t kUndefined = 0xffffffff;
constexpr std::uint64_t kMaxValueBytes = 1 << 17;  // a table of 65536 entries
constexpr int kMaxDepth = 32;

struct Head {
  DicomTag tag = 0;
  std::string representation;  // empty in implicit files
  std::uint32_t length = 0;
};

class Parser {
 public:
  // The elements begin at `begin`: behind preamble and magic, or at 0 in files without preamble.
  Parser(const File& file, std::uint64_t begin, const std::vector<DicomTag>& wanted)
      : cursor_(file, begin), wanted_(wanted) {
    std::sort(wanted_.begin(), wanted_.end());
  }

  DicomFile run() {
    try {
      parse();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kFormat) throw;
      out_.fault = error;
    }
    return std::move(out_);
  }

 private:
  void parse() {
    out_.transfer_syntax = metaSyntax();
    if (out_.transfer_syntax == kDeflated) {
      out_.deflated_offset_bytes = cursor_.at();
      cursor_.inflate();
    }
    out_.big_endian = cursor_.big_endian =
        out_.transfer_syntax == "1.2.840.10008.1.2.2" || (out_.transfer_syntax.empty() && beginsBigEndian());
    const bool implicit =
        out_.transfer_syntax == "1.2.840.10008.1.2" || (out_.transfer_syntax.empty() && !beginsExplicit());
    while (cursor_.more()) {
      const Head head = readHead(implicit);
      out_.float_pixels = head.tag == kFloatPixelData || head.tag == kDoublePixelData;
      if (head.tag == kPixelData || out_.float_pixels) {
        out_.pixels_offset_bytes = cursor_.at();
        out_.pixels_representation = head.representation;
        if (head.length != kUndefined) out_.pixels_bytes = head.length;
        break;
      }
      readValue(head, implicit, out_.set, 0);
    }
  }

  // Files without a transfer syntax: tests whether the first group is 0x0008 in big-endian order, and whether the first
  // element has a value representation.
  bool beginsBigEndian() const { return cursor_.left() >= 2 && DicomBytes(cursor_).integer(2) == 0x0800; }
  bool beginsExplicit() const {
    if (cursor_.left() < 6) return false;
    DicomBytes ahead = cursor_;
    ahead.skip(4);
    const std::string text = ahead.text(2);
    return std::all_of(text.begin(), text.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
  }

  // Reads the file meta group, which is explicit and little-endian whatever the syntax of the rest.
  std::string metaSyntax() {
    std::string syntax;
    while (cursor_.left() >= 8) {
      DicomBytes ahead = cursor_;
      if (ahead.tag() >> 16 != 2) break;
      const Head head = readHead(false);
      if (head.length == kUndefined || head.length > kMaxValueBytes) {
        cursor_.skip(head.length);
      } else {
        std::string value = cursor_.text(head.length);
        while (!value.empty() && (value.back() == '\0' || value.back() == ' ')) value.pop_back();
        if (head.tag == kTransferSyntax) syntax = value;
      }
    }
    return syntax;
  }

  Head readHead(bool implicit) {
    Head head;
    head.tag = cursor_.tag();
    if (implicit || head.tag >> 16 == kDicomItem >> 16) {
      head.length = cursor_.integer(4);
      return head;
    }
    head.representation = cursor_.text(2);
    const auto upper = [](char c) { return c >= 'A' && c <= 'Z'; };
    // Old private elements may have "??".
    if (head.representation != "??" && !std::all_of(head.representation.begin(), head.representation.end(), upper)) {
      cursor_.fail(fmt::format("element {} has no value representation", nameOf(head.tag)));
    }
    // Further representations, also of future editions, have long lengths.
    constexpr std::array kShort = {"??", "AE", "AS", "AT", "CS", "DA", "DS", "DT", "FD", "FL", "IS",
                                   "LO", "LT", "PN", "SH", "SL", "SS", "ST", "TM", "UI", "UL", "US"};
    if (std::find(kShort.begin(), kShort.end(), head.representation) != kShort.end()) {
      head.length = cursor_.integer(2);
    } else {
      cursor_.skip(2);
      head.length = cursor_.integer(4);
    }
    return head;
  }

  void readValue(const Head& head, bool implicit, DicomSet& into, int depth) {
    const bool wanted = std::binary_search(wanted_.begin(), wanted_.end(), head.tag);
    const bool sequence = head.length == kUndefined || head.representation == "SQ" ||
                          ((implicit || head.representation == "UN") && isGroups(head.tag));
    if (!sequence || (!wanted && head.length != kUndefined)) {
      if (!wanted || head.length > kMaxValueBytes) return cursor_.skip(head.length);
      into.add({head.tag, cursor_.big_endian, cursor_.text(head.length), {}});
      return;
    }
    DicomElement element = {head.tag, cursor_.big_endian, "", {}};
    // Elements of unknown representation (UN) are implicit inside.
    readItems(head, implicit || head.representation == "UN", element, depth + 1);
    if (wanted) into.add(std::move(element));
  }

  // Implicit files do not mark sequences; among the wanted tags, the tags below are sequences.
  static bool isGroups(DicomTag tag) {
    constexpr std::array<DicomTag, 8> kSequences = {0x00209113, 0x00209116, 0x00283000, 0x00289110,
                                                    0x00289145, 0x0062000a, 0x52009229, 0x52009230};
    return std::find(kSequences.begin(), kSequences.end(), tag) != kSequences.end();
  }

  std::uint64_t endOf(const Head& head) const {
    if (head.length == kUndefined) return cursor_.at() + cursor_.left();
    if (head.length > cursor_.left()) {
      cursor_.fail(fmt::format("element {} should have {} bytes, but the file ends after {}", nameOf(head.tag),
                               head.length, cursor_.left()));
    }
    return cursor_.at() + head.length;
  }

  void readItems(const Head& sequence, bool implicit, DicomElement& into, int depth) {
    if (depth > kMaxDepth) cursor_.fail("sequences are nested too deeply");
    const std::uint64_t end = endOf(sequence);
    // Other compressed pixels, for example of an icon: the items are fragments and hold no elements.
    const bool fragments = sequence.tag == kPixelData || sequence.representation.starts_with('O');
    while (cursor_.at() < end) {
      const Head item = readHead(implicit);
      if (item.tag == kDicomSequenceEnd && sequence.length == kUndefined) return;
      if (item.tag != kDicomItem)
        cursor_.fail(fmt::format("element {} holds {} and no item", nameOf(sequence.tag), nameOf(item.tag)));
      if (fragments) {
        cursor_.skip(item.length);
        continue;
      }
      into.items.emplace_back();
      readItem(item, implicit, into.items.back(), depth);
    }
    if (sequence.length == kUndefined) cursor_.fail(fmt::format("element {} has no end", nameOf(sequence.tag)));
    if (cursor_.at() > end) cursor_.fail(fmt::format("element {} is longer inside than outside", nameOf(sequence.tag)));
  }

  void readItem(const Head& item, bool implicit, DicomSet& into, int depth) {
    const std::uint64_t end = endOf(item);
    while (cursor_.at() < end) {
      const Head head = readHead(implicit);
      if (head.tag == kItemEnd && item.length == kUndefined) return;
      readValue(head, implicit, into, depth);
    }
    if (cursor_.at() > end) cursor_.fail("an item is longer inside than outside");
  }

  DicomBytes cursor_;
  std::vector<DicomTag> wanted_;
  DicomFile out_;
};

}  // namespace

void DicomSet::add(DicomElement element) { elements_.push_back(std::move(element)); }

const DicomElement* DicomSet::find(DicomTag tag) const {
  const auto found =
      std::find_if(elements_.begin(), elements_.end(), [&](const DicomElement& e) { return e.tag == tag; });
  return found == elements_.end() ? nullptr : &*found;
}

const DicomSet* DicomSet::item(DicomTag tag, std::size_t index) const {
  const DicomElement* const sequence = find(tag);
  return sequence == nullptr || index >= sequence->items.size() ? nullptr : &sequence->items[index];
}

std::string DicomSet::text(DicomTag tag) const {
  const DicomElement* const element = find(tag);
  std::string out = element == nullptr ? "" : element->value;
  while (!out.empty() && (out.back() == '\0' || out.back() == ' ')) out.pop_back();
  return out;
}

std::vector<double> DicomSet::numbers(DicomTag tag) const {
  std::vector<double> out;
  const std::string all = text(tag);
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = std::min(all.find('\\', at), all.size());
    std::string part = trimmed(std::string_view(all).substr(at, end - at));
    if (part.starts_with('+')) part.erase(0, 1);
    const std::optional<double> value = doubleOf(part);
    if (!value || !std::isfinite(*value)) return {};
    out.push_back(*value);
    at = end + 1;
  }
  return out;
}

std::vector<std::uint16_t> DicomSet::shorts(DicomTag tag) const {
  const DicomElement* const element = find(tag);
  std::vector<std::uint16_t> out;
  for (std::size_t i = 0; element != nullptr && i + 1 < element->value.size(); i += 2) {
    const auto a = static_cast<unsigned char>(element->value[i]), b = static_cast<unsigned char>(element->value[i + 1]);
    out.push_back(static_cast<std::uint16_t>(element->big_endian ? a << 8 | b : b << 8 | a));
  }
  return out;
}

std::optional<int> DicomSet::number(DicomTag tag) const {
  const std::vector<std::uint16_t> all = shorts(tag);
  return all.empty() ? std::nullopt : std::optional<int>(all.front());
}

DicomFile readDicomElements(const File& file, const std::vector<DicomTag>& wanted) {
  std::string first(512, '\0');
  first.resize(file.readSomeAt(0, std::as_writable_bytes(std::span(first))));
  if (!looksLikeDicom(first)) throw Error(ErrorCode::kFormat, file.path(), "byte 128", "is not a DICOM file");
  const bool magic = first.size() >= 132 && first.substr(128, 4) == "DICM";
  return Parser(file, magic ? 132 : 0, wanted).run();
}

}  // namespace kiln

// Layout: a table of offsets, which may be empty, then the fragments, then an end mark. Source: DICOM PS3.5, A.4.
#include "ingest/dicom/dicom_fragments.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "ingest/dicom/dicom_bytes.h"

namespace kiln {

std::vector<std::vector<ByteRange>> dicomFragments(const File& file, std::uint64_t offset_bytes, std::size_t frames) {
  DicomBytes cursor(file, offset_bytes);
  std::vector<ByteRange> items;
  while (true) {
    const DicomTag tag = cursor.tag();
    const std::uint32_t length = cursor.integer(4);
    if (tag == kDicomSequenceEnd) break;
    if (tag != kDicomItem) cursor.fail(fmt::format("{} stands among the fragments of the pixels", nameOf(tag)));
    items.push_back({cursor.at(), length});
    cursor.skip(length);
  }
  if (items.size() < 2) cursor.fail("the pixels have no fragment");
  // The first item is the offset table: the begin of each frame, counted from the second item.
  const ByteRange table = items.front();
  items.erase(items.begin());
  std::vector<std::vector<ByteRange>> out(frames);
  if (frames == 1) {
    out[0] = items;
  } else if (items.size() == frames) {
    for (std::size_t i = 0; i < frames; ++i) out[i] = {items[i]};
  } else if (table.size == 4 * static_cast<std::uint64_t>(frames)) {
    DicomBytes offsets(file, table.offset);
    std::vector<std::uint64_t> begins(frames);
    for (std::uint64_t& begin : begins) begin = items.front().offset + offsets.integer(4);
    for (const ByteRange& item : items) {
      const auto after = std::upper_bound(begins.begin(), begins.end(), item.offset);
      if (after != begins.begin()) out[static_cast<std::size_t>(after - begins.begin()) - 1].push_back(item);
    }
  } else {
    throw Error(ErrorCode::kUnsupported, file.path(), fmt::format("byte {}", offset_bytes),
                fmt::format("{} fragments hold {} frames, and the table of offsets is missing", items.size(), frames));
  }
  for (const auto& fragments : out) {
    if (fragments.empty()) cursor.fail("a frame has no fragment");
  }
  return out;
}

}  // namespace kiln

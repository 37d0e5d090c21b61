#include "ingest/dicom/dicom_decode.h"

#include <fmt/format.h>

#include <memory>
#include <numeric>

#include "base/error.h"
#include "base/file/file.h"
#include "base/module.h"
#include "ingest/dicom/dicom_codestream.h"
#include "ingest/dicom/gdcm_protocol.h"

namespace kiln {
namespace {

std::unique_ptr<WorkerProcess> startGdcm(std::uint64_t frame_bytes) {
  const WorkerLimits limits{.memory_bytes = (std::uint64_t{1} << 30) + 16 * frame_bytes,
                            .request_s = 60 + static_cast<int>(frame_bytes >> 20)};
  return std::make_unique<WorkerProcess>(programBesideModules("kiln_gdcm_reader", "compressed DICOM cannot be read"),
                                         "GDCM", limits);
}

GdcmFrameHead headOf(const DicomPixels& pixels, std::size_t fragments) {
  GdcmFrameHead out{};
  out.frame_bytes = pixels.frameBytes();
  out.columns = static_cast<std::uint32_t>(pixels.columns), out.rows = static_cast<std::uint32_t>(pixels.rows);
  out.fragments = static_cast<std::uint32_t>(fragments);
  out.bits_allocated = static_cast<std::uint16_t>(pixels.bits_allocated);
  out.bits_stored = static_cast<std::uint16_t>(pixels.bits_stored);
  out.high_bit = static_cast<std::uint16_t>(pixels.high_bit);
  out.is_signed = pixels.is_signed;
  pixels.transfer_syntax.copy(out.transfer_syntax, sizeof out.transfer_syntax - 1);
  return out;
}

}  // namespace

std::vector<std::byte> DicomDecoder::frame(const DicomHeader& header, std::int64_t index) {
  const WorkerPlace place{header.path, fmt::format("frame {}", index + 1)};
  const std::vector<ByteRange>& ranges = header.frames[static_cast<std::size_t>(index)].fragments;
  std::vector<std::uint64_t> sizes;
  for (const ByteRange& range : ranges) sizes.push_back(range.size);
  std::vector<std::byte> packed(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
  const File file(header.path);
  std::span<std::byte> to = packed;
  for (const ByteRange& range : ranges) {
    file.readAt(range.offset, to.first(range.size));
    to = to.subspan(range.size);
  }
  const DicomPixels& pixels = header.pixels;
  if (const std::string fault = codestreamFault(pixels, packed); !fault.empty())
    throw Error(ErrorCode::kFormat, place.file, place.part,
                fault + "; the file is damaged, or was put together wrongly");
  const GdcmFrameHead head = headOf(pixels, sizes.size());
  std::vector<std::byte> out(static_cast<std::size_t>(pixels.frameBytes()));
  const auto worker = workers_.take(out.size(), [&] { return startGdcm(out.size()); });
  const std::uint64_t bytes =
      worker->request(place, 0, {std::as_bytes(std::span(&head, 1)), std::as_bytes(std::span(sizes)), packed});
  if (bytes != out.size())
    throw Error(ErrorCode::kFormat, place.file, place.part,
                fmt::format("GDCM gives {} bytes of pixels (expected {})", bytes, out.size()));
  worker->receive(place, out);
  return out;
}

// Here: the compressed bytes, which may be as many as the pixels, and the pixels. In the worker: the request, GDCM's
// copy, its pixels and the answer, and OpenJPEG's numbers of 32 bits in two arrays. Measured: 10 MiB for frames of 512
// KiB.
std::uint64_t DicomDecoder::decodeBytes(const DicomPixels& pixels) {
  constexpr std::uint64_t kProcessBytes = 8 << 20, kNumberBytes = 8;
  return 6 * pixels.frameBytes() + kNumberBytes * static_cast<std::uint64_t>(pixels.columns * pixels.rows) +
         kProcessBytes;
}

}  // namespace kiln

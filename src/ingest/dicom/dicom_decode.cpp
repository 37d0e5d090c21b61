#include "ingest/dicom/dicom_decode.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/file/file.h"
#include "base/module.h"
#include "ingest/dicom/dicom_codestream.h"
#include "ingest/dicom/gdcm_frames.h"
#include "ingest/source/header_text.h"

namespace kiln {

std::vector<std::byte> decodeDicomFrame(const DicomHeader& header, std::int64_t frame) {
  static const auto decode = reinterpret_cast<decltype(&kilnDecodeByGdcm)>(
      functionOfModule(KILN_GDCM_MODULE, "kilnDecodeByGdcm", "compressed DICOM cannot be read"));
  const File file(header.path);
  std::vector<std::vector<char>> fragments;
  for (const ByteRange& range : header.frames[static_cast<std::size_t>(frame)].fragments) {
    fragments.emplace_back(static_cast<std::size_t>(range.size));
    file.readAt(range.offset, std::as_writable_bytes(std::span(fragments.back())));
  }
  const std::string place = fmt::format("frame {}", frame + 1);
  if (const std::string fault = codestreamFault(header.pixels, fragments); !fault.empty())
    throw Error(ErrorCode::kFormat, header.path, place, fault + "; the file is damaged, or was put together wrongly");
  std::vector<std::byte> out(static_cast<std::size_t>(header.pixels.frameBytes()));
  std::string why;
  if (!decode(header.pixels, fragments, out, why))
    throw Error(ErrorCode::kFormat, header.path, place,
                fmt::format("the pixels cannot be decoded{}; the file is damaged",
                            why.empty() ? "" : " (" + inQuotes(why) + ")"));
  return out;
}

}  // namespace kiln

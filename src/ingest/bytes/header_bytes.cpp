#include "ingest/bytes/header_bytes.h"

#include "base/error.h"
#include "base/file/file.h"
#include "ingest/bytes/inflate_stream.h"

namespace kiln {

void HeaderBytes::fail(const std::string& place, const std::string& what) const {
  throw Error(ErrorCode::kFormat, path_, place, what);
}

void HeaderBytes::refuse(const std::string& what) const { throw Error(ErrorCode::kUnsupported, path_, "", what); }

HeaderBytes readHeaderBytes(const std::filesystem::path& path, std::size_t count) {
  File file(path);
  std::array<std::byte, 2> first{};
  const bool in_gzip = file.readSomeAt(0, first) == 2 && first[0] == std::byte{0x1f} && first[1] == std::byte{0x8b};
  std::vector<std::byte> bytes(count);
  if (in_gzip) {
    InflateStream(std::move(file), 0, StreamWrapper::kGzip).read(bytes, "header");
  } else {
    file.readAt(0, bytes);
  }
  return {path, std::move(bytes), in_gzip};
}

}  // namespace kiln

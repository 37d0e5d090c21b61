#include "ingest/bytes/header_bytes.h"

#include "base/error.h"
#include "base/file.h"
#include "ingest/bytes/inflate_stream.h"

namespace kiln {

void HeaderBytes::fail(const std::string& place, const std::string& what) const {
  throw Error(ErrorCode::kFormat, path_, place, what);
}

void HeaderBytes::refuse(const std::string& what) const { throw Error(ErrorCode::kUnsupported, path_, "", what); }

bool isGzip(const std::filesystem::path& path) {
  std::array<std::byte, 2> first{};
  return File(path).readSomeAt(0, first) == 2 && first[0] == std::byte{0x1f} && first[1] == std::byte{0x8b};
}

HeaderBytes readHeaderBytes(const std::filesystem::path& path, std::size_t count) {
  std::vector<std::byte> bytes(count);
  if (isGzip(path)) {
    InflateStream(File(path), 0, StreamWrapper::kGzip).read(bytes, "header");
  } else {
    File(path).readAt(0, bytes);
  }
  return {path, std::move(bytes)};
}

}  // namespace kiln

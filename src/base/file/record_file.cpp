#include "base/file/record_file.h"

#include <algorithm>
#include <cstring>
#include <system_error>

#include "base/byte_record.h"
#include "base/file/path_status.h"
#include "base/hash.h"

namespace kiln {

void appendRecord(std::vector<std::byte>& out, std::span<const std::byte> payload) {
  appendValue(out, static_cast<std::uint32_t>(payload.size()));
  appendValue(out, hashOf(payload));
  out.insert(out.end(), payload.begin(), payload.end());
}

std::vector<std::byte> beginningOf(const RecordMagic& magic) {
  const auto bytes = std::as_bytes(std::span(magic));
  return {bytes.begin(), bytes.end()};
}

std::optional<std::uint64_t> readRecords(const std::filesystem::path& path, const RecordMagic& magic,
                                         const std::function<bool(std::span<const std::byte>)>& take) {
  if (!isThere(path)) return std::nullopt;
  const File file(path);
  RecordMagic found{};
  if (file.readSomeAt(0, std::as_writable_bytes(std::span(found))) < sizeof found || found != magic)
    return std::nullopt;
  std::uint64_t whole = sizeof found;
  while (true) {
    std::byte head[sizeof(std::uint32_t) + sizeof(Hash128)];
    if (file.readSomeAt(whole, head) < sizeof head) return whole;
    ByteTaker taker{head};
    const auto bytes = taker.take<std::uint32_t>();
    const auto hash = taker.take<Hash128>();
    const std::uint64_t begin = whole + sizeof head;
    if (file.size() < begin || file.size() - begin < bytes) return whole;
    std::vector<std::byte> payload(bytes);
    file.readAt(begin, payload);
    if (hashOf(payload) != hash || !take(payload)) return whole;
    whole = begin + bytes;
  }
}

}  // namespace kiln

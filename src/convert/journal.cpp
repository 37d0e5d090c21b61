// The file: "KILNJNL2", then records of a u32 length, the hash of the payload, and the payload. The first is the
// identity as three strings that end in 0, each other one is a brick.
#include "convert/journal.h"

#include <cstring>
#include <system_error>

#include "base/byte_record.h"
#include "base/error.h"
#include "base/hash.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr char kMagic[8] = {'K', 'I', 'L', 'N', 'J', 'N', 'L', '2'};

struct RecordHead {
  std::uint32_t bytes;
  Hash128 hash;
};

void appendRecord(std::vector<std::byte>& out, std::span<const std::byte> payload) {
  appendValue(out, static_cast<std::uint32_t>(payload.size()));
  appendValue(out, hashOf(payload));
  out.insert(out.end(), payload.begin(), payload.end());
}

std::vector<std::byte> identityPayload(const ConversionIdentity& identity) {
  std::vector<std::byte> out;
  for (const std::string* text : {&identity.volume, &identity.command, &identity.time}) appendText(out, *text);
  return out;
}

std::optional<ConversionIdentity> identityFrom(std::span<const std::byte> payload) {
  ByteTaker taker{payload};
  ConversionIdentity out;
  out.volume = taker.takeText();
  out.command = taker.takeText();
  out.time = taker.takeText();
  return taker.ok ? std::optional(out) : std::nullopt;
}

}  // namespace

std::vector<std::byte> bytesOf(const FinishedBrick& brick) {
  std::vector<std::byte> out;
  appendValue(out, static_cast<std::int32_t>(brick.key.level));
  appendValue(out, brick.key.brick);
  appendEntry(out, brick.entry);
  appendValue(out, brick.counts.nan_count);
  appendValue(out, static_cast<std::uint32_t>(brick.counts.keys.size()));
  for (const auto& [key, count] : brick.counts.keys) {
    appendValue(out, key);
    appendValue(out, count);
  }
  return out;
}

std::optional<FinishedBrick> finishedBrickFrom(std::span<const std::byte> bytes) {
  ByteTaker taker{bytes};
  FinishedBrick out;
  out.key.level = taker.take<std::int32_t>();
  out.key.brick = taker.take<BrickCoord>();
  std::optional<BrickEntry> entry = takeEntry(taker.left);
  if (!entry) return std::nullopt;
  out.entry = *std::move(entry);
  out.counts.nan_count = taker.take<std::uint64_t>();
  const auto keys = taker.take<std::uint32_t>();
  for (std::uint32_t i = 0; i < keys && taker.ok; ++i) {
    const auto key = taker.take<std::uint32_t>();
    out.counts.keys.emplace_back(key, taker.take<std::uint64_t>());
  }
  return taker.ok && taker.left.empty() ? std::optional(std::move(out)) : std::nullopt;
}

fs::path Journal::pathIn(const fs::path& directory) { return directory / "journal.bin"; }

Journal::Journal(const fs::path& directory, const JournalContent& content, FileSystem& disk)
    : path_(pathIn(directory)), disk_(disk) {
  std::vector<std::byte> file;
  for (const char c : kMagic) appendValue(file, c);
  appendRecord(file, identityPayload(content.identity));
  for (const FinishedBrick& brick : content.bricks) appendRecord(file, bytesOf(brick));
  disk_.writeAtomic(path_, file, WriteMode::kUnsynced);
}

void Journal::append(const FinishedBrick& brick) {
  std::vector<std::byte> record;
  appendRecord(record, bytesOf(brick));
  const std::scoped_lock lock(mutex_);
  disk_.appendFile(path_, record);
}

std::optional<JournalContent> Journal::read(const fs::path& directory) {
  std::error_code ignored;
  if (!fs::exists(pathIn(directory), ignored)) return std::nullopt;
  const File file(pathIn(directory));
  char magic[sizeof kMagic];
  if (file.readSomeAt(0, std::as_writable_bytes(std::span(magic))) < sizeof magic ||
      std::memcmp(magic, kMagic, sizeof magic) != 0)
    return std::nullopt;
  JournalContent out;
  std::uint64_t at = sizeof magic;
  for (bool first = true;; first = false) {
    RecordHead head;
    std::byte raw[sizeof head.bytes + sizeof head.hash];
    if (file.readSomeAt(at, raw) < sizeof raw) break;
    std::memcpy(&head.bytes, raw, sizeof head.bytes);
    std::memcpy(&head.hash, raw + sizeof head.bytes, sizeof head.hash);
    at += sizeof raw;
    if (file.size() < at || file.size() - at < head.bytes) break;
    std::vector<std::byte> payload(head.bytes);
    file.readAt(at, payload);
    at += head.bytes;
    if (hashOf(payload) != head.hash) break;
    if (first) {
      const std::optional<ConversionIdentity> identity = identityFrom(payload);
      if (!identity) return std::nullopt;
      out.identity = *identity;
      continue;
    }
    std::optional<FinishedBrick> brick = finishedBrickFrom(payload);
    if (!brick) break;
    out.bricks.push_back(std::move(*brick));
  }
  if (out.identity.volume.empty()) return std::nullopt;
  return out;
}

}  // namespace kiln

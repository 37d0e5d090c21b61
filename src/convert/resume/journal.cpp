// File format: "KILNJNL4", then records of a u32 length, the hash of the payload, and the payload. The first record is
// the identity as three zero-terminated strings; each other record is a brick.
#include "convert/resume/journal.h"

#include <utility>

#include "base/byte_record.h"
#include "base/file/record_file.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr RecordMagic kJournalMagic = {'K', 'I', 'L', 'N', 'J', 'N', 'L', '4'};

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

// Calls take(brick, payload) for each brick of a journal, up to the first record that is not whole.
template <class Take>
void readBricks(const fs::path& path, Take&& take) {
  bool is_first = true;
  readRecords(path, kJournalMagic, [&](std::span<const std::byte> payload) {
    if (std::exchange(is_first, false)) return identityFrom(payload).has_value();
    const std::optional<FinishedBrick> brick = finishedBrickFrom(payload);
    if (brick) take(*brick, payload);
    return brick.has_value();
  });
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

Journal::Journal(const fs::path& directory, const ConversionIdentity& identity,
                 const std::function<bool(const FinishedBrick&)>& keep, FileSystem& disk)
    : path_(pathIn(directory)), disk_(disk) {
  constexpr std::size_t kAtOnce = 1 << 20;
  std::vector<std::byte> bytes = beginningOf(kJournalMagic);
  appendRecord(bytes, identityPayload(identity));
  disk_.writeOwn(path_, [&](const fs::path& next) {
    disk_.writeFile(next, bytes, WritePolicy::kUnsynced);
    bytes.clear();
    readBricks(path_, [&](const FinishedBrick& brick, std::span<const std::byte> payload) {
      if (keep(brick)) appendRecord(bytes, payload);
      if (bytes.size() < kAtOnce) return;
      disk_.appendFile(next, bytes);
      bytes.clear();
    });
    if (!bytes.empty()) disk_.appendFile(next, bytes);
  });
}

void Journal::append(const FinishedBrick& brick) {
  std::vector<std::byte> record;
  appendRecord(record, bytesOf(brick));
  const std::scoped_lock lock(mutex_);
  disk_.appendFile(path_, record);
}

std::optional<ConversionIdentity> Journal::identityIn(const fs::path& directory) {
  std::optional<ConversionIdentity> out;
  readRecords(pathIn(directory), kJournalMagic, [&](std::span<const std::byte> payload) {
    out = identityFrom(payload);
    return false;
  });
  return out;
}

void Journal::forEachBrick(const fs::path& directory, const std::function<void(const FinishedBrick&)>& take) {
  readBricks(pathIn(directory),
             [&](const FinishedBrick& brick, std::span<const std::byte> /*payload*/) { take(brick); });
}

}  // namespace kiln

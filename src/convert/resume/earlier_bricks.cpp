#include "convert/resume/earlier_bricks.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "base/byte_record.h"
#include "base/file/file.h"
#include "base/hash.h"
#include "base/thread/parallel.h"
#include "store/store_writer.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

bool isWhole(const FinishedBrick& brick, const fs::path& directory) {
  if (brick.entry.constant) return true;
  const fs::path path = directory / brickPath(brick.key);
  std::error_code ignored;
  return fs::file_size(path, ignored) == brick.entry.file_bytes && hashOf(readFile(path)) == brick.entry.checksum;
}

// Bricks examined together: 128 bytes each and, for a brick with a file, up to 1 KiB of sub-ranges.
constexpr std::size_t kAtOnce = 4096;

// Collective. Copies the first rank's bricks to all ranks.
void shareBricks(std::vector<FinishedBrick>& noted, Ranks& ranks) {
  if (ranks.alone()) return;
  std::vector<std::byte> bytes;
  if (ranks.first()) {
    for (const FinishedBrick& brick : noted) {
      const std::vector<std::byte> record = bytesOf(brick);
      appendValue(bytes, static_cast<std::uint64_t>(record.size()));
      bytes.insert(bytes.end(), record.begin(), record.end());
    }
  }
  ranks.broadcast(bytes);
  if (ranks.first()) return;
  noted.clear();
  for (ByteTaker taker{bytes}; !taker.left.empty() && taker.ok;) {
    const auto size = taker.take<std::uint64_t>();
    if (std::optional<FinishedBrick> brick = finishedBrickFrom(taker.takeBytes(size)))
      noted.push_back(*std::move(brick));
  }
}

// Collective, with equal bricks on all ranks. Returns a byte per brick: 1 if its file is whole.
std::vector<std::byte> wholeOf(const std::vector<FinishedBrick>& noted, const fs::path& directory, Ranks& ranks,
                               Progress& progress) {
  std::vector<std::byte> whole(noted.size());
  const auto step = static_cast<std::size_t>(ranks.count()), first = static_cast<std::size_t>(ranks.rank());
  parallelFor(noted.size() > first ? (noted.size() - first + step - 1) / step : 0, [&](std::size_t i) {
    progress.throwIfCancelled("looking at what is finished");
    const std::size_t at = first + i * step;
    whole[at] = std::byte{isWhole(noted[at], directory)};
  });
  for (const std::vector<std::byte>& of_rank : ranks.gather(whole))
    std::transform(whole.begin(), whole.end(), of_rank.begin(), whole.begin(), std::bit_or());
  ranks.broadcast(whole);
  return whole;
}

}  // namespace

void forEachWholeBrick(const fs::path& directory, Ranks& ranks, Progress& progress,
                       const std::function<void(const FinishedBrick&)>& keep) {
  std::vector<FinishedBrick> noted;
  // Collective. Returns false if the first rank has no more bricks.
  const auto lookAtThem = [&] {
    shareBricks(noted, ranks);
    if (noted.empty()) return false;
    const std::vector<std::byte> whole = wholeOf(noted, directory, ranks, progress);
    for (std::size_t i = 0; i < noted.size(); ++i) {
      if (whole[i] != std::byte{0}) keep(noted[i]);
    }
    noted.clear();
    return true;
  };
  if (ranks.first()) {
    Journal::forEachBrick(directory, [&](const FinishedBrick& brick) {
      noted.push_back({brick.key, brick.entry, {}});
      if (noted.size() == kAtOnce) lookAtThem();
    });
    // Sends the last bricks, then an empty list, which ends the loop of the other ranks.
    if (lookAtThem()) lookAtThem();
  } else {
    while (lookAtThem()) {
    }
  }
}

}  // namespace kiln

#include "convert/earlier_bricks.h"

#include <algorithm>
#include <set>
#include <system_error>

#include "base/byte_record.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/parallel.h"
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

}  // namespace

std::vector<FinishedBrick> wholeBricksOf(const std::vector<FinishedBrick>& noted, const fs::path& directory,
                                         Ranks& ranks, Progress& progress) {
  if (noted.empty()) return {};
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
  std::vector<FinishedBrick> out;
  std::set<BrickKey> taken;
  for (std::size_t i = 0; i < noted.size(); ++i) {
    if (whole[i] != std::byte{0} && taken.insert(noted[i].key).second) out.push_back(noted[i]);
  }
  return out;
}

void shareBricks(std::vector<FinishedBrick>& noted, Ranks& ranks) {
  if (ranks.alone()) return;
  std::vector<std::byte> bytes;
  if (ranks.first()) {
    for (const FinishedBrick& brick : noted) {
      const std::vector<std::byte> record = bytesOf(FinishedBrick{brick.key, brick.entry, {}});
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

}  // namespace kiln

#include "cluster/agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "base/byte_record.h"
#include "base/error.h"
#include "base/hash.h"
#include "base/process.h"
#include "cluster/shared_lists.h"

namespace kiln {
namespace {

// The first fact of the first rank that differs from rank 0; -1 if no rank differs.
struct Verdict {
  std::int64_t rank = -1, fact = -1;
};

Verdict firstDifference(const std::vector<std::vector<std::byte>>& all) {
  const std::vector<Hash128> own = listFrom<Hash128>(all[0]);
  for (std::size_t rank = 1; rank < all.size(); ++rank) {
    const std::vector<Hash128> other = listFrom<Hash128>(all[rank]);
    const auto place = std::mismatch(own.begin(), own.end(), other.begin(), other.end()).first - own.begin();
    if (static_cast<std::size_t>(place) < std::max(own.size(), other.size()))
      return {static_cast<std::int64_t>(rank), place};
  }
  return {};
}

std::string differenceOf(const RankFact& fact, const std::string& there, const std::string& here) {
  const auto shown = [](const std::string& value) { return value.empty() ? "not given" : value; };
  std::string text = fact.difference ? fact.difference(there, here) : std::string();
  if (text.empty()) text = fmt::format("{} is {} there and {} here", fact.name, shown(there), shown(here));
  return text;
}

}  // namespace

void requireAgreement(Ranks& ranks, std::span<const RankFact> facts) {
  if (ranks.alone()) return;
  std::vector<Hash128> hashes;
  for (const RankFact& fact : facts) hashes.push_back(hashOf(std::string_view(fact.value)));
  const auto all = ranks.gather(bytesOfList(hashes));
  std::vector<Verdict> verdict(1);
  if (ranks.first()) verdict[0] = firstDifference(all);
  broadcastList(ranks, verdict);
  if (verdict[0].rank < 0) return;
  const auto place = static_cast<std::size_t>(verdict[0].fact);
  std::vector<std::byte> of_rank;
  appendText(of_rank, hostName());
  appendText(of_rank, place < facts.size() ? facts[place].value : std::string());
  const auto texts = ranks.gather(std::move(of_rank));
  if (ranks.first()) {
    ByteTaker taker{texts[static_cast<std::size_t>(verdict[0].rank)]};
    const std::string host = taker.takeText(), there = taker.takeText();
    const std::string difference =
        place < facts.size() ? differenceOf(facts[place], there, facts[place].value) : "more is given there than here";
    throw Error(ErrorCode::kFormat,
                fmt::format("rank {} on {} differs from rank 0 on {}: {}; give all ranks one command, one version of "
                            "kiln and the same files",
                            verdict[0].rank, host, hostName(), difference));
  }
  ranks.barrier();
}

}  // namespace kiln

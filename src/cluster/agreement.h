// Compares the command, job, volumes and version of ranks before they begin. Ranks that differ would otherwise mix
// their results into one picture or store.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "cluster/ranks.h"

namespace kiln {

/// A property that all ranks must have in common.
struct RankFact {
  std::string name;   // of the property, as an error calls it: "--size", "version"
  std::string value;  // as text; only its hash is sent while all ranks agree
  /// Returns in words what differs between another rank's value (there) and this rank's (here). If empty, the error
  /// holds both values.
  std::function<std::string(const std::string& there, const std::string& here)> difference = {};
};

/// Collective. Compares every fact of every rank with that of the first rank. Returns on all ranks if they agree. If
/// not, the first rank throws and the others wait for it to end them (Ranks::abort). requires: the facts of all ranks
/// are listed in the same order. throws: Error kFormat naming a rank, its host and what differs.
/// cost: 16 bytes a fact and rank on the first rank.
void requireAgreement(Ranks& ranks, std::span<const RankFact> facts);

}  // namespace kiln

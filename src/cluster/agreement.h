// Compares command, job, volumes and version of all ranks before they begin. Differing ranks would mix incompatible
// results in a picture or store.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "cluster/ranks.h"

namespace kiln {

/// A property that must be equal on all ranks.
struct RankFact {
  std::string name;   // name of the property in errors: "--size", "version"
  std::string value;  // as text; only its hash is sent while all ranks agree
  /// Describes the difference between another rank's value (there) and this rank's (here). If empty, the error holds
  /// both values.
  std::function<std::string(const std::string& there, const std::string& here)> difference = {};
};

/// Collective. Compares every fact of every rank with rank 0. Returns on all ranks if they agree. Otherwise rank 0
/// throws and all further ranks wait until rank 0 ends them (Ranks::abort). requires: all ranks list the facts in equal
/// order. throws: Error kFormat naming a rank, its host and the difference.
/// cost: 16 bytes per fact and rank on rank 0.
void requireAgreement(Ranks& ranks, std::span<const RankFact> facts);

}  // namespace kiln

// Ranks that are threads of the test: what several processes do together, without any, so that sanitizers see it and
// each may have a disk of its own that fails.
#pragma once

#include <functional>

#include "cluster/ranks.h"

namespace kiln::test {

/// Calls body for each of `count` ranks at once and waits for all. As under mpirun the first that throws ends the
/// others: what they wait for throws in them, too. throws: what the first threw.
void runRanks(int count, const std::function<void(Ranks&)>& body);

}  // namespace kiln::test

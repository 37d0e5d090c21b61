// Ranks as threads of the test. They behave like several processes, but sanitizers cover them, and each may have a
// faulty disk of its own.
#pragma once

#include <functional>

#include "cluster/ranks.h"

namespace kiln::test {

/// Calls body for each of `count` ranks concurrently and waits for all. As under mpirun, the first rank that throws
/// ends the others: their waiting calls throw, too. throws: the first exception.
void runRanks(int count, const std::function<void(Ranks&)>& body);

}  // namespace kiln::test

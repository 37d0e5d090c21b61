// Durations for people, and the present time for files.
#pragma once

#include <string>

namespace kiln {

/// Returns "0.17 s", "43.1 s", "12 min", "3 h 20 min": three digits at most of the largest unit.
std::string durationText(double seconds);
/// Returns the same without fractions of a second, for estimates: "43 s".
std::string roughDurationText(double seconds);

/// Returns the present time in UTC. unit: ISO 8601.
std::string timeNow();

}  // namespace kiln

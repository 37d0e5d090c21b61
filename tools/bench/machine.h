// The machine and the build that numbers were measured with: without them a time means nothing.
#pragma once

#include <cstdint>
#include <string>

namespace kiln {

struct Machine {
  std::string processor;           // "AMD EPYC 9B14"; "unknown" where the system does not say
  unsigned logical_cores = 0;      // threads that run at once
  std::uint64_t memory_bytes = 0;  // 0 where the system does not say
  std::string system;              // "Linux 6.1.0-18-amd64"
  std::string compiler;            // "GCC 12.2.0"
  bool assertions = false;         // a build that checks itself, and is slower for it
  std::string version;             // Kiln's
};

Machine thisMachine();

}  // namespace kiln

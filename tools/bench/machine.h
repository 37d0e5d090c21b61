// The machine and the build of a measurement: times mean nothing without them.
#pragma once

#include <cstdint>
#include <string>

namespace kiln {

struct Machine {
  std::string processor;           // "AMD EPYC 9B14"; "unknown" if not reported
  unsigned logical_cores = 0;      // hardware threads
  std::uint64_t memory_bytes = 0;  // 0 if not reported
  std::string system;              // "Linux 6.1.0-18-amd64"
  std::string compiler;            // "GCC 12.2.0"
  bool assertions = false;         // assertions are on, which slows the build
  std::string version;             // version of Kiln
};

Machine thisMachine();

}  // namespace kiln

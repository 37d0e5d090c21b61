#pragma once

#include <cstdlib>
#include <string>

namespace kiln::test {

/// The command of a Python that has all `modules` ("json, numpy"): the first python3 on PATH, or the one for which the
/// system's packages install modules; empty where neither has them, so that a test skips and names the package.
inline std::string pythonWith(const std::string& modules) {
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    if (std::system((std::string(python) + " -c 'import " + modules + "' > /dev/null 2>&1").c_str()) == 0)
      return python;
  }
  return {};
}

}  // namespace kiln::test

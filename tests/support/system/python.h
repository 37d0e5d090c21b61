#pragma once

#include <cstdlib>
#include <string>

namespace kiln::test {

/// Returns the command of a Python with all `modules` ("json, numpy"): the first python3 on PATH, or the system's
/// Python, for which packages install modules. Empty if neither has them; the test then skips and names the package.
inline std::string pythonWith(const std::string& modules) {
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    if (std::system((std::string(python) + " -c 'import " + modules + "' > /dev/null 2>&1").c_str()) == 0)
      return python;
  }
  return {};
}

}  // namespace kiln::test

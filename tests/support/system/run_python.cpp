#include "support/system/run_python.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "base/shell_text.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// Empty if no Python has the modules.
std::string pythonWith(const std::string& modules) {
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    if (std::system((std::string(python) + " -c 'import " + modules + "' > /dev/null 2>&1").c_str()) == 0)
      return python;
  }
  return {};
}

}  // namespace

bool runPython(const std::string& modules, const std::filesystem::path& directory, const std::string& script,
               const std::vector<std::string>& arguments) {
  std::string command = pythonWith(modules);
  if (command.empty()) return false;
  const std::filesystem::path file = directory / "script.py";
  writeText(file, script);
  command += " " + shellText(file.string());
  for (const std::string& argument : arguments) command += " " + shellText(argument);
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  return true;
}

}  // namespace kiln::test

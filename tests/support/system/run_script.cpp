#include "support/system/run_script.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/file/file.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace fs = std::filesystem;

void runScript(const fs::path& directory, const std::string& script) {
  fs::create_directories(directory / "bin");
  fs::create_directories(directory / "work");
  if (!fs::exists(directory / "bin/kiln")) fs::create_symlink(KILN_TOOL, directory / "bin/kiln");
  writeText(directory / "script.sh", script);
  const std::string command =
      fmt::format("cd {0}/work && PATH={0}/bin:$PATH bash -exuo pipefail ../script.sh < /dev/null > ../log 2>&1",
                  directory.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << readTextFile(directory / "log");
}

}  // namespace kiln::test

#include "support/system/run_script.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

#include "base/file/file.h"
#include "support/system/tool_server.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace fs = std::filesystem;

void runScript(const fs::path& directory, const std::string& script) {
  fs::create_directories(directory / "bin");
  fs::create_directories(directory / "work");
  if (!fs::exists(directory / "bin/kiln")) fs::create_symlink(KILN_TEST_CLIENT, directory / "bin/kiln");
  writeText(directory / "script.sh", script);
  const int server = ::dup(toolServer());  // inherited by the script
  const std::string command = fmt::format(
      "cd {0}/work && {1}={2} PATH={0}/bin:$PATH bash -exuo pipefail ../script.sh < /dev/null > ../log 2>&1",
      directory.string(), kServerVariable, server);
  EXPECT_EQ(std::system(command.c_str()), 0) << readTextFile(directory / "log");
  ::close(server);
}

}  // namespace kiln::test

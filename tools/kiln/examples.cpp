#include "examples.h"

namespace kiln::tool {

void addExamples(CLI::App& command, const std::vector<std::string>& lines) {
  std::string text = "EXAMPLES";
  for (const std::string& line : lines) text += "\n  " + line;
  command.footer(text);
}

}  // namespace kiln::tool

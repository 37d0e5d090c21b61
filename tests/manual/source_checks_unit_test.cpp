// Known by hand: small source trees, each with one fault that the scripts of checks must report.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>

#include "base/file/file.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// The files of a source tree by name, and their text.
using Tree = std::map<std::string, std::string>;

// A tree without a fault: base is included by two formats of one row, and by a folder that names a set.
Tree soundTree() {
  return {{"src/ARCHITECTURE.md",
           "- `LOW` = `base` `ingest/a`\n\n| folder | what | may include |\n| --- | --- | --- |\n"
           "| `base/` | texts | nothing |\n| `ingest/{a,b}/` | formats | `base` |\n| `draw/` | pictures | `LOW` |\n"},
          {"src/DEPENDENCIES.md",
           "| library | headers | only in |\n| --- | --- | --- |\n| PNG | `png.h` | `draw/draw.cpp` |\n"},
          {"src/DECISIONS.md", "[Order](draw/decisions/order.md)\n"},
          {"src/README.md", "`text.h`, `a.h`, `b.h`, `draw.h`\n"},
          {"src/base/text.h", "#include <string>\n"},
          {"src/ingest/a/a.h", "#include \"base/text.h\"\n"},
          {"src/ingest/b/b.h", "#include \"base/text.h\"\n"},
          {"src/draw/draw.h", "// Figures: draw/decisions/order.md.\n#include \"ingest/a/a.h\"\n"},
          {"src/draw/draw.cpp", "#include <png.h>\n\n#include \"draw/draw.h\"\n"},
          {"src/draw/decisions/order.md", "# Order\n"},
          {"README.md", "See [the code](src/ARCHITECTURE.md).\n"},
          {"LICENSE", ""},
          {"tools/README.md", ""},
          {"tests/README.md", ""},
          {"scripts/README.md", ""},
          {"cmake/README.md", ""}};
}

// Runs scripts/`script` on the tree. Returns its output behind its exit code.
std::string checked(const std::string& script, const Tree& tree) {
  const fs::path directory = freshDirectory("source_checks"), root = directory / "tree";
  for (const auto& [name, text] : tree) {
    fs::create_directories((root / name).parent_path());
    writeText(root / name, text);
  }
  const std::string log = (directory / "log").string();
  const std::string command = std::string(KILN_SOURCE_DIR) + "/scripts/" + script + " " + root.string();
  const int status = std::system((command + " > " + log + " 2>&1").c_str());
  return std::to_string(WEXITSTATUS(status)) + ": " + readTextFile(log);
}

Tree with(const std::string& name, const std::string& text) {
  Tree tree = soundTree();
  tree[name] = text;
  return tree;
}

// The sound tree with one text of ARCHITECTURE replaced by another.
Tree withRow(const std::string& before, const std::string& after) {
  Tree tree = soundTree();
  std::string& table = tree.at("src/ARCHITECTURE.md");
  table.replace(table.find(before), before.size(), after);
  return tree;
}

void expectFault(const std::string& output, const std::string& fault) {
  EXPECT_TRUE(output.starts_with("1: ")) << output;
  EXPECT_NE(output.find(fault), std::string::npos) << output;
}

TEST(SourceChecks, SoundTree_passes) {
  for (const char* script : {"check_includes.sh", "check_documents.sh"}) {
    const std::string output = checked(script, soundTree());
    EXPECT_TRUE(output.starts_with("0: ")) << script << ": " << output;
  }
}

TEST(CheckIncludes, IncludeBeyondTheRow_isReported) {
  const auto expect = [](const Tree& tree, const std::string& fault) {
    expectFault(checked("check_includes.sh", tree), fault);
  };
  expect(with("src/base/text.h", "#include \"draw/draw.h\"\n"),
         "src/base/text.h:1: base may not include \"draw/draw.h\"");
  expect(with("src/ingest/b/b.h", "#include \"ingest/a/a.h\"\n"), "ingest/b may not include \"ingest/a/a.h\"");
  expect(with("src/draw/more.cpp", "#include \"ingest/b/b.h\"\n"), "draw may not include \"ingest/b/b.h\"");
  expect(with("src/draw/more.cpp", "#include <png.h>\n"), "<png.h> belongs in draw/draw.cpp only");
  expect(with("src/draw/more.cpp", "#include <tiff.h>\n"), "<tiff.h> has no row in src/DEPENDENCIES.md");
  expect(with("src/new/new.h", "#include \"base/text.h\"\n"), "new has no row in src/ARCHITECTURE.md");
}

TEST(CheckIncludes, RowBelowOrBeside_isReported) {
  const auto expect = [](const Tree& tree, const std::string& fault) {
    expectFault(checked("check_includes.sh", tree), fault);
  };
  expect(withRow("| nothing |", "| `draw` |"), "`base/` may include draw, which has no row above");
  expect(withRow("formats | `base` |", "formats | `base` `ingest/a` |"),
         "ingest/b may include ingest/a of the same row");
  expect(withRow("`LOW` = `base`", "`LOW` = `base` `draw`"), "`draw/` may include draw, which has no row above");
  expect(withRow("{a,b}", "{a,b,c}"), "ingest/c has no source file");
}

TEST(CheckDocuments, FaultOfADocument_isReported) {
  const auto expect = [](const Tree& tree, const std::string& fault) {
    expectFault(checked("check_documents.sh", tree), fault);
  };
  expect(with("README.md", "[code](src/CODE.md)\n"), "README.md:1: src/CODE.md is not there");
  expect(with("src/draw/draw.cpp", "// See draw/decisions/other.md.\n"),
         "src/draw/draw.cpp:1: draw/decisions/other.md is not there");
  expect(with("src/draw/draw.cpp", "// As in draw_all.h.\n"), "draw_all.h is not there");
  expect(with("src/draw/decisions/more.md", "# More\n"),
         "src/draw/decisions/more.md: src/DECISIONS.md does not list it");
  expect(with("src/draw/more.h", ""), "src/draw/more.h: no README of its folder or above names it");
  std::string lines;
  for (int line = 0; line < 41; ++line) lines += "\n";
  expect(with("src/draw/decisions/order.md", lines), "src/draw/decisions/order.md: 41 lines, more than 40");
}

}  // namespace
}  // namespace kiln::test

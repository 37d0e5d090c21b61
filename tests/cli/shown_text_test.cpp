// Texts of files and names reach no terminal unescaped. Known because every printed byte is part of a printable
// character or ends a line, for any input.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "base/file/file.h"
#include "base/text.h"
#include "image/file/image_file.h"
#include "store/store_reader.h"
#include "support/files/npy_files.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

// Escape sequences of both kinds, a bell, a bidirectional override, a second line, and an invalid UTF-8 byte.
const std::string kHostile =
    "a\x1b]0;t\x07\x1b[31m\xc2\x9b"
    "32m\xe2\x80\xae"
    "b\nkiln: done\r\xff"
    "c";
const std::string kShown = R"(a\x1b]0;t\x07\x1b[31m\x9b32m\u202eb\nkiln: done\r\xffc)";

class ShownTextCli : public ToolTest {
 protected:
  ShownTextCli() : ToolTest("shown_") {}
  void SetUp() override { done({"convert", "phantom:head:16x16x16", in("h.kiln")}); }

  static bool harmless(const std::string& text) {
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t bytes = bytesOfCharacter(std::string_view(text).substr(at));
      const auto byte = static_cast<unsigned char>(text[at]);
      if (bytes == 0 || (byte < 0x20 && byte != '\n') || byte == 0x7f) return false;
      if (bytes == 2 && byte == 0xc2 && static_cast<unsigned char>(text[at + 1]) < 0xa0) return false;
      if (bytes == 3 && text.compare(at, 2, "\xe2\x80") == 0 && static_cast<unsigned char>(text[at + 2]) >= 0xa8 &&
          static_cast<unsigned char>(text[at + 2]) <= 0xae)
        return false;
      at += bytes;
    }
    return true;
  }
  // Runs the command; the printed text has `mention`.
  static ToolResult expectHarmless(const std::vector<std::string>& arguments, const std::string& mention,
                                   const ToolOptions& options = {}) {
    const ToolResult result = runTool(arguments, options);
    EXPECT_TRUE(harmless(result.out)) << result.out;
    EXPECT_TRUE(harmless(result.err)) << result.err;
    EXPECT_NE((result.out + result.err).find(mention), std::string::npos)
        << mention << " is not in: " << result.out << result.err;
    return result;
  }
};

TEST_F(ShownTextCli, NamesOfFiles_areShownEscaped) {
  const std::string store = in(kHostile + ".kiln"), picture = in(kHostile + ".png");
  fs::copy(in("h.kiln"), store, fs::copy_options::recursive);
  expectHarmless({"render", store, "-o", picture, "--size", "8x8"}, kShown + ".png: 8 x 8 pixels");
  expectHarmless({"render", store, "-o", picture, "--size", "8x8", "--resume"}, "kept");
  expectHarmless({"info", store}, "store        " + in(kShown + ".kiln"));
  expectHarmless({"info", picture}, "picture      " + in(kShown + ".png"));
  expectHarmless({"verify", store}, kShown + ".kiln: whole");
  expectHarmless({"slice", store, "-o", picture}, kShown + ".png: ");
  expectHarmless({"export", store, in(kHostile + ".vdb")}, kShown + ".vdb: ");
  expectHarmless({"split", store, "-o", in(kHostile + "_#"), "--parts", "2"}, kShown);
  expectHarmless({"compare", picture, in(kHostile + "no.png")}, kShown + "no.png");
  expectHarmless({"tf", in(kHostile + "no.json")}, kShown + "no.json");
  expectHarmless({"render", in(kHostile + "no.kiln"), "-o", picture}, kShown + "no.kiln: ");
  expectHarmless({"convert", in(kHostile + "no.nrrd"), in("o.kiln")}, kShown + "no.nrrd");
  expectHarmless({kHostile}, kShown);
  expectHarmless({"render", store, "--" + kHostile}, kShown);
  expectHarmless({"render", store, "-o", picture, "--mode", kHostile}, kShown);
}

// Events stay JSON, and strings in JSON stay exact names.
TEST_F(ShownTextCli, Json_keepsTheExactText) {
  const std::string valid = kHostile.substr(0, kHostile.size() - 2);
  const std::string picture = in(valid + ".png");
  const ToolResult result =
      expectHarmless({"render", in("h.kiln"), "-o", picture, "--size", "8x8", "--progress", "json"}, "frame_done");
  const Json started = Json::parse(result.out.substr(0, result.out.find('\n')));
  EXPECT_EQ(started["outputs"][0], picture);
  fs::copy(in("h.kiln"), in(valid + ".kiln"), fs::copy_options::recursive);
  const std::string exr = in("x.exr");
  ASSERT_EQ(runTool({"render", in(valid + ".kiln"), "-o", exr, "--size", "8x8"}).exit_code, 0);
  EXPECT_EQ(Json::parse(expectHarmless({"info", exr, "--json"}, "\\u202e").out)["volume"], in(valid + ".kiln"));
}

// Bytes outside UTF-8 are \xNN, and no other name has this text.
TEST_F(ShownTextCli, Json_namesThatAreNotUtf8StayDifferent) {
  const auto nameOf = [&](const std::string& name) {
    const ToolResult result =
        done({"render", in("h.kiln"), "-o", in(name), "--size", "8x8", "--progress", "json", "--stats", in("s.json")});
    return Json::parse(result.out.substr(0, result.out.find('\n')))["outputs"][0].get<std::string>();
  };
  EXPECT_EQ(nameOf("\xff.png"), in(R"(\xff.png)"));
  EXPECT_EQ(nameOf(R"(\xff.png)"), in(R"(\x5cxff.png)"));
  EXPECT_EQ(nameOf(R"(\xf.png)"), in(R"(\xf.png)"));
  EXPECT_EQ(nameOf("\xc3\xbf.png"), in("\xc3\xbf.png"));
  // Warnings, the names of a source, and the manifest of its store.
  writeText(in("v\xfe.npy"), npyFile({{2, 2, 2}, VoxelType::u8, std::vector<std::byte>(8)}));
  const Json source = Json::parse(done({"info", in("v\xfe.npy"), "--json"}).out)["source"];
  EXPECT_EQ(source["files"][0], in(R"(v\xfe.npy)"));
  done({"convert", in("v\xfe.npy"), in("v.kiln")});
  EXPECT_EQ(Json::parse(done({"info", in("v.kiln"), "--json"}).out)["source"]["files"][0], in(R"(v\xfe.npy)"));
}

TEST_F(ShownTextCli, TextsOfFiles_areShownEscaped) {
  // A manifest's unit.
  const std::string text = readTextFile(in("h.kiln/manifest.json"));
  const std::string unit = "mm\\u001b[31m\\u009b1m\\u202e";
  const std::string changed = std::regex_replace(text, std::regex("\"unit\": \"mm\""), "\"unit\": \"" + unit + "\"");
  ASSERT_NE(changed, text);
  writeText(in("h.kiln/manifest.json"), restamped(changed));
  const std::string shown_unit = R"(mm\x1b[31m\x9b1m\u202e)";
  expectHarmless({"info", in("h.kiln")}, shown_unit);
  expectHarmless({"tf", in("h.kiln")}, shown_unit);
  EXPECT_EQ(Json::parse(expectHarmless({"info", in("h.kiln"), "--json"}, "storage").out)["unit"],
            "mm\x1b[31m\xc2\x9b"
            "1m\xe2\x80\xae");
  done({"convert", "phantom:head:16x16x16", in("other.kiln")});
  expectHarmless({"render", in("h.kiln"), "--add", in("other.kiln"), "-o", in("x.png"), "--size", "8x8"}, shown_unit);
  // Names of labels, keys of a job, comments of a picture.
  writeText(in("l.json"), R"({"labels": [{"label": 1, "name": "\u001b[31mliver\u009b", "color": [1, 0, 0]}]})");
  expectHarmless({"tf", in("l.json")}, R"(\x1b[31mliver\x9b)");
  writeText(in("job.json"), R"({"kiln": 2, "volume": "h.kiln", "\u001b[31mkey": 1})");
  expectHarmless({"render", in("job.json"), "-o", in("x.png")}, R"(\x1b[31mkey)");
  done({"render", in("h.kiln"), "-o", in("c.exr"), "--size", "8x8", "--comments", "two\nlines \x1b[31m"});
  expectHarmless({"info", in("c.exr")}, R"(lines \x1b[31m)");
  // A header's field, and progress on a terminal.
  writeText(in("bad.nrrd"), "NRRD0004\ntype: \x1b[31mfloat\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n");
  expectHarmless({"info", in("bad.nrrd")}, "bad.nrrd");
  expectHarmless({"convert", in("bad.nrrd"), in("bad.kiln")}, "[31mfloat");
}

// All printing is in say.cpp, so that no command prints unescaped text.
TEST(ShownText, OnlyOneFile_printsToTheTerminal) {
  const std::regex prints(
      R"(fmt::print|std::cout|std::cerr|printf\s*\(|\bputs\s*\(|\bputchar|\bfputs|\bfwrite|std::println)");
  for (const auto& entry : fs::directory_iterator(fs::path(KILN_SOURCE_DIR) / "tools" / "kiln")) {
    if (entry.path().stem() == "say") continue;
    std::ifstream source(entry.path());
    int number = 0;
    for (std::string line; std::getline(source, line);) {
      ++number;
      EXPECT_FALSE(std::regex_search(line, prints)) << entry.path() << ":" << number << ": " << line;
    }
  }
}

}  // namespace
}  // namespace kiln::test

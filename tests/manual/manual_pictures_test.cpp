// Known: the commands of the manual's page of pictures draw the pictures that the page shows.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "base/file/file.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "support/system/run_script.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

const fs::path kManual = fs::path(KILN_SOURCE_DIR) / "tools/kiln/manual";
// Pixels of the small pictures. Text has a least size: in pictures of less than 324 pixels along an edge it covers
// more.
constexpr int kWidth = 480, kHeight = 360;
// Pixels of what is compared: edges and noise of small and large pictures differ.
constexpr int kComparedWidth = 40, kComparedHeight = 30;
// Agreement of a right picture: a root mean square of at most 0.03. Two pictures of the page have 20 dB and less.
constexpr double kLeastPsnr = 30.46;

std::vector<std::string> picturesOfPage() {
  const std::string page = readTextFile(kManual / "pictures.md");
  const std::regex picture("\\(pictures/([a-z_]+)\\.jpg\\)");
  std::vector<std::string> names;
  for (std::sregex_iterator it(page.begin(), page.end(), picture), end; it != end; ++it) names.push_back((*it)[1]);
  return names;
}

TEST(ManualPictures, Commands_drawThePicturesOfThePage) {
  const fs::path directory = freshDirectory("manual_pictures");
  fs::create_directories(directory / "work");
  const fs::path head = fs::path(KILN_SOURCE_DIR) / "out/head/matrix.dat";
  if (fs::exists(head)) fs::copy(head, directory / "work/matrix.dat");
  runScript(directory, fmt::format("{}/scripts/pictures.sh ../bin/kiln . {}x{}", KILN_SOURCE_DIR, kWidth, kHeight));
  const std::vector<std::string> names = picturesOfPage();
  EXPECT_EQ(names.size(), 10u);
  for (const std::string& name : names) {
    runScript(
        directory,
        fmt::format("for file in {0}.jpg {1}/pictures/{0}.jpg; do\n"
                    "  oiiotool $file --resize:filter=box {2}x{3} -d uint16 -o $(basename $(dirname $file))_{0}.png\n"
                    "done",
                    name, kManual.string(), kComparedWidth, kComparedHeight));
    const Image drawn = readImage(directory / "work" / ("._" + name + ".png"));
    const Image shown = readImage(directory / "work" / ("pictures_" + name + ".png"));
    EXPECT_GT(compareImages(drawn, shown).foreground_psnr_db, kLeastPsnr) << name;
  }
}

}  // namespace
}  // namespace kiln::test

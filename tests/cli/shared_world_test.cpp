// Volumes of different frames and units in a picture. Known because a body has a single position whether written in RAS
// or LPS, in micrometres or in millimetres: the pictures are equal to the bit.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "image/compare.h"
#include "image/file/image_file.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {

class SharedWorldCli : public ToolTest {
 protected:
  SharedWorldCli() : ToolTest("shared_world_") {}

  // Writes an NRRD and converts the NRRD to a store.
  std::string volume(const std::string& name, bool labels, const std::string& space, double sign, double scale,
                     const std::string& unit, double origin = 0) const {
    constexpr int n = 24;
    std::string voxels(n * n * n, '\0');
    for (int z = 0; z < n; ++z) {
      for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
          const bool body = std::min({x, y, z}) >= 4 && std::max({x, y, z}) < 20;
          const bool spot = x >= 5 && x < 8 && y >= 5 && y < 10 && z >= 15 && z < 19;
          voxels[static_cast<std::size_t>(x + n * (y + n * z))] = static_cast<char>(labels ? spot : body ? 100 : 0);
        }
      }
    }
    writeText(in(name + ".nrrd"),
              fmt::format("NRRD0005\ntype: uchar\ndimension: 3\nsizes: {0} {0} {0}\nencoding: raw\n{1}\nspace "
                          "directions: ({2},0,0) (0,{2},0) (0,0,{3})\nspace origin: ({4},{5},{6})\n{7}\n",
                          n, space.empty() ? "space dimension: 3" : "space: " + space, sign * scale, scale,
                          origin + sign * -100 * scale, origin + sign * -50 * scale, origin + 20 * scale,
                          unit.empty() ? "" : fmt::format("space units: \"{0}\" \"{0}\" \"{0}\"\n", unit)) +
                  voxels);
    std::vector<std::string> convert = {"convert", in(name + ".nrrd"), in(name + ".kiln")};
    if (labels) convert.push_back("--labels");
    done(convert);
    return in(name + ".kiln");
  }
  std::string lps(const std::string& name, bool labels) const {
    return volume(name, labels, "left-posterior-superior", 1, 1, "mm");
  }
  std::string ras(const std::string& name, bool labels) const {
    return volume(name, labels, "right-anterior-superior", -1, 1, "mm");
  }

  struct Drawn {
    ZeroPages<float> rgba;
    std::string said;
  };
  Drawn drawn(const std::string& first, const std::string& second, std::vector<std::string> more = {}) const {
    writeText(in("tf.json"), R"({"points": [{"value": 50, "color": [0.5, 0.5, 0.5], "opacity": 0},
                                            {"value": 100, "color": [0.5, 0.5, 0.5], "opacity": 0.02}]})");
    if (std::find(more.begin(), more.end(), "--tf") == more.end()) more.insert(more.end(), {"--tf", in("tf.json")});
    more.insert(more.begin(), {"render", first, "-o", in("x.exr"), "--size", "48x48", "--add", second, "--view",
                               "front", "--azimuth", "30", "--elevation", "20", "--exr-type", "float"});
    const ToolResult result = done(more);
    return {readImage(in("x.exr")).rgba, result.err};
  }
  Image drawnImage(const std::string& first, const std::string& second, const std::vector<std::string>& more) const {
    drawn(first, second, more);
    return readImage(in("x.exr"));
  }
};

TEST_F(SharedWorldCli, RasBesideLps_landsInTheSamePlace) {
  const std::string ct = lps("ct", false), labels = lps("labels", true), labels_ras = ras("labels_ras", true);
  const Drawn right = drawn(ct, labels);
  EXPECT_EQ(right.said, "");
  const Drawn turned = drawn(ct, labels_ras);
  EXPECT_EQ(turned.said, "");
  EXPECT_TRUE(turned.rgba == right.rgba);
  EXPECT_FALSE(drawn(ct, ct).rgba == right.rgba);
  // World axes are the first volume's. With two volumes in RAS the camera's front is the same side of the patient.
  const std::string ct_ras = ras("ct_ras", false);
  const ZeroPages<float> of_ras = drawn(ct_ras, labels_ras).rgba;
  EXPECT_TRUE(drawn(ct_ras, labels).rgba == of_ras);
  // A job with equal options draws an equal picture, and so does the job in the picture's header.
  writeText(in("job.json"), R"({"kiln": 2, "volumes": [{"volume": "ct.kiln", "transferFunction": "tf.json"}, {"volume":
      "labels_ras.kiln"}], "image": {"width": 48, "height": 48}, "camera": {"view": "front", "azimuth": 30, "elevation":
      20}, "exr": {"type": "float"}})");
  done({"render", in("job.json"), "-o", in("job.exr")});
  EXPECT_TRUE(readImage(in("job.exr")).rgba == right.rgba);
  writeText(in("again.json"), readImageText(in("job.exr")).at("kiln:job"));
  done({"render", in("again.json"), "-o", in("again.exr"), "--exr-type", "float"});
  EXPECT_TRUE(readImage(in("again.exr")).rgba == right.rgba);
}

TEST_F(SharedWorldCli, UnknownFrameBesideAKnownOne_isWarnedOf) {
  const std::string ct = lps("ct", false), unknown = volume("unknown", true, "", 1, 1, "mm");
  const Drawn first = drawn(ct, unknown), second = drawn(unknown, ct, {"--tf", "auto", "--add-tf", in("tf.json")});
  for (const Drawn* const image : {&first, &second}) {
    EXPECT_NE(image->said.find("warning: " + unknown + ": its patient frame is unknown"), std::string::npos)
        << image->said;
  }
  EXPECT_EQ(
      drawn(unknown, volume("unknown_ct", false, "", 1, 1, "mm"), {"--tf", "auto", "--add-tf", in("tf.json")}).said,
      "");
  const ToolResult strict = runTool({"render", ct, "-o", in("s.exr"), "--size", "16x16", "--add", unknown, "--strict"});
  EXPECT_EQ(strict.exit_code, 1);
  EXPECT_NE(strict.err.find("--strict"), std::string::npos) << strict.err;
}

// A transfer function's unit is in the volume's own unit: 2 mm are 2000 um.
TEST_F(SharedWorldCli, MicrometresBesideMillimetres_areTheirLengths) {
  const std::string mm = lps("mm", false);
  const std::string second = lps("second", true);
  const std::string um = volume("second_um", true, "left-posterior-superior", 1, 1000, "um");
  const ZeroPages<float> right = drawn(mm, second).rgba;
  const Drawn converted = drawn(mm, um);
  EXPECT_TRUE(converted.rgba == right);
  EXPECT_EQ(converted.said, "");
  const auto looks = [&](const std::string& name, int unit) {
    writeText(in(name),
              fmt::format(R"({{"unit": {}, "labels": [{{"label": 1, "color": [1, 0, 0], "opacity": 0.3}}]}})", unit));
    return in(name);
  };
  const ZeroPages<float> by_mm = drawn(mm, second, {"--add-tf", looks("two_mm.json", 2)}).rgba;
  const ZeroPages<float> by_um = drawn(mm, um, {"--add-tf", looks("two_mm_in_um.json", 2000)}).rgba;
  EXPECT_FALSE(by_mm == right);
  for (std::size_t i = 0; i < by_mm.size(); ++i) ASSERT_NEAR(by_um[i], by_mm[i], 1e-5);
  writeText(in("um.json"), readImageText(in("x.exr")).at("kiln:job"));
  done({"render", in("um.json"), "-o", in("um.exr"), "--exr-type", "float"});
  EXPECT_TRUE(readImage(in("um.exr")).rgba == by_um);
  const std::string unitless = volume("unitless", true, "left-posterior-superior", 1, 1, "");
  EXPECT_NE(drawn(mm, unitless).said.find("its unit of length is unknown"), std::string::npos);
  const std::string furlongs = volume("furlongs", true, "left-posterior-superior", 1, 1, "furlong");
  EXPECT_NE(drawn(mm, furlongs).said.find("lengths in 'furlong' cannot be converted"), std::string::npos);
}

// Map coordinates: voxels of a tenth at 4.6 million. Cuts and labels move with the volume.
TEST_F(SharedWorldCli, LargeOrigins_drawThePicturesOfSmallOrigins) {
  constexpr double kFar = 4.6e6;
  const auto at = [&](double origin, const std::string& name) {
    return std::pair(volume(name + "_v", false, "left-posterior-superior", 1, 0.1, "m", origin),
                     volume(name + "_l", true, "left-posterior-superior", 1, 0.1, "m", origin));
  };
  const auto [near, near_labels] = at(0, "near");
  const auto [far, far_labels] = at(kFar, "far");
  // x + y + z is at least -11, near the middle.
  const std::vector<std::string> near_cut = {"--clip", "1,1,1,9"};
  const std::vector<std::string> far_cut = {"--clip", fmt::format("1,1,1,{:.1f}", 9 - 3 * kFar)};
  for (const char* projection : {"perspective", "orthographic"}) {
    const auto with = [&](std::vector<std::string> options) {
      options.insert(options.end(), {"--projection", projection});
      return options;
    };
    const Image whole = drawnImage(near, near_labels, with({})), cut = drawnImage(near, near_labels, with(near_cut));
    EXPECT_GT(compareImages(whole, drawnImage(far, far_labels, with({}))).psnr_db, 70) << projection;
    EXPECT_GT(compareImages(cut, drawnImage(far, far_labels, with(far_cut))).psnr_db, 70) << projection;
    EXPECT_LT(compareImages(whole, cut).psnr_db, 40) << projection;
  }
}

}  // namespace
}  // namespace kiln::test

// Options without effect are reported. Known: which files and modes an option's help names.
#include "job/command/idle_flags.h"

#include <gtest/gtest.h>

namespace kiln {
namespace {

using Texts = std::vector<std::pair<std::string, std::vector<std::string>>>;

// Returns the warnings for flags given beside a volume.
std::vector<std::string> warningsOf(const Texts& texts) {
  GivenFlags given;
  for (const JobFlag& flag : jobFlags()) {
    for (const auto& [name, values] : texts) {
      if (nameOfFlag(flag.flag) == name) given.add(flag, values);
    }
  }
  RenderJob job = parseJob(R"({"kiln": 2, "volume": "a.kiln"})", "job.json");
  given.apply(job);
  return idleFlags(given, job);
}

TEST(IdleFlags, OptionsOfAnotherFileFormat_areReported) {
  EXPECT_EQ(warningsOf({{"--output", {"a.png"}}, {"--exr-type", {"half"}}}),
            std::vector<std::string>{"--exr-type: has no effect here; applies to EXR pictures (none is written)"});
  EXPECT_EQ(warningsOf({{"--output", {"a.exr"}}, {"--png-bits", {"16"}}, {"--tone", {"soft"}}}).size(), 1u);
  EXPECT_EQ(warningsOf({{"--output", {"a.tif"}}, {"--jpeg-quality", {"90"}}, {"--exposure", {"1"}}}).size(), 1u);
  EXPECT_TRUE(warningsOf({{"--output", {"a.EXR"}}, {"--compression", {"zip"}}}).empty());
  EXPECT_TRUE(warningsOf({{"--output", {"a.mp4"}}, {"--exposure", {"1"}}}).empty());
}

TEST(IdleFlags, ADryRunWithoutFiles_hasOptionsOfAllFormats) {
  EXPECT_TRUE(warningsOf({{"--exr-type", {"half"}}, {"--png-bits", {"16"}}, {"--jpeg-quality", {"90"}}}).empty());
}

TEST(IdleFlags, LightOfAProjectionOrWithoutShading_isReportedOnce) {
  const Texts light = {{"--shadows", {}}, {"--light", {"dir:1,0,0"}}, {"--ambient-occlusion", {"0.5"}}};
  const auto with = [&](const std::string& flag, const std::string& value) {
    Texts out = light;
    out.push_back({flag, {value}});
    return warningsOf(out);
  };
  EXPECT_EQ(with("--mode", "mip").size(), 3u);
  EXPECT_EQ(with("--shading", "none").size(), 3u);
  EXPECT_TRUE(warningsOf(light).empty());
}

TEST(IdleFlags, OptionsWithoutTheirSubject_areReported) {
  const std::vector<std::pair<Texts, Texts>> pairs = {
      {{{"--attenuation", {"0.1"}}}, {{"--mode", {"attenuated-mip"}}}},
      {{{"--aperture-eyes", {"4"}}}, {{"--aperture", {"2"}}}},
      {{{"--legend-title", {"HU"}}}, {{"--legend", {}}}},
      {{{"--annotation-size", {"2"}}}, {{"--scale-bar", {}}}},
      {{{"--quadtree-epsilon", {"2"}}}, {{"--visibility", {"quadtree"}}}},
  };
  for (const auto& [option, subject] : pairs) {
    const std::vector<std::string> alone = warningsOf(option);
    ASSERT_EQ(alone.size(), 1u) << option.front().first;
    EXPECT_EQ(alone.front().rfind(option.front().first + ": has no effect here; applies to ", 0), 0u) << alone.front();
    Texts both = option;
    both.insert(both.end(), subject.begin(), subject.end());
    EXPECT_TRUE(warningsOf(both).empty()) << option.front().first;
  }
}

// A flag that is renamed here or there would lose its row.
TEST(IdleFlags, OfAProjection_areFlagsOfJobs) {
  const Texts all = {{"--shading", {"none"}},
                     {"--ambient", {"0.1"}},
                     {"--diffuse", {"0.1"}},
                     {"--specular", {"0.1"}},
                     {"--power", {"2"}},
                     {"--shadows", {}},
                     {"--light", {"headlight"}},
                     {"--ambient-occlusion", {"1"}},
                     {"--opacity-threshold", {"0.9"}},
                     {"--tone", {"soft"}},
                     {"--mode", {"mip"}}};
  EXPECT_EQ(warningsOf(all).size(), all.size() - 1);
}

}  // namespace
}  // namespace kiln

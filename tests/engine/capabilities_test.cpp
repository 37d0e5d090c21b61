// The table of engines: every choice has a row, refusals name constraint, found engine and remedy, and the manual
// prints the table.
#include "engine/capabilities.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "base/error.h"
#include "base/file/file.h"

namespace kiln::test {
namespace {

// Returns the message of the refusal; empty if nothing is refused.
std::string engineRefusal(const EngineChoice& engine, const EngineOptions& options) {
  try {
    requireOptions(engine, options);
    return "";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    return error.what();
  }
}

constexpr EngineChoice kVoxelEngine{Mode::kComposite, Lattice::kVoxel, false};
constexpr EngineChoice kMipEngine{Mode::kMip, Lattice::kPixel, false};

TEST(Capabilities, EachEngine_hasOneRow) {
  std::set<EngineKind> kinds;
  for (const EngineCapabilities& row : engineCapabilities()) EXPECT_TRUE(kinds.insert(row.kind).second);
  for (const Mode mode : {Mode::kComposite, Mode::kMip, Mode::kMinip, Mode::kAverage, Mode::kAttenuatedMip}) {
    for (const Lattice lattice : {Lattice::kPixel, Lattice::kVoxel}) {
      for (const bool several : {false, true}) {
        const EngineChoice engine{mode, lattice, several};
        EXPECT_EQ(engine.capabilities().kind, engine.kind());
      }
    }
  }
  EXPECT_EQ(kinds.size(), 4u);
}

TEST(Capabilities, DefaultOptions_fitEachEngine) {
  EXPECT_EQ(engineRefusal({}, {}), "");
  EXPECT_EQ(engineRefusal(kVoxelEngine, {}), "");
  EXPECT_EQ(engineRefusal(kMipEngine, {}), "");
  EXPECT_EQ(engineRefusal({Mode::kComposite, Lattice::kPixel, true}, {}), "");
}

TEST(Capabilities, Refusal_namesConstraintFoundEngineAndRemedy) {
  EXPECT_EQ(engineRefusal(kVoxelEngine, {.interpolation = Interpolation::kCubic, .aovs = {}}),
            "--interpolation cubic: needs --lattice pixel, or several volumes (found --lattice voxel); leave "
            "--interpolation out");
  EXPECT_EQ(engineRefusal(kMipEngine, {.aovs = {.depth = true}}),
            "--aov: depth and normal need --mode composite (found --mode mip); choose "
            "--aov value");
  EXPECT_EQ(engineRefusal({Mode::kMip, Lattice::kPixel, true}, {.aovs = {.depth = true}}),
            "--aov: depth and normal need --mode composite (found --mode mip); leave "
            "--aov out");
  EXPECT_EQ(
      engineRefusal({}, {.aovs = {.value = true}}),
      "--aov: value needs --mode mip, minip, average or attenuated-mip (found --lattice pixel); choose one of these "
      "modes");
}

TEST(Capabilities, EngineThatContradictsItself_isRefused) {
  EXPECT_EQ(engineRefusal({Mode::kAverage, Lattice::kVoxel, false}, {}),
            "--lattice voxel: needs --mode composite (found average); leave --lattice out");
  EXPECT_EQ(engineRefusal({Mode::kComposite, Lattice::kVoxel, true}, {}),
            "--lattice voxel: draws one volume (found several); leave it out, or draw each volume by itself");
  EXPECT_EQ(engineRefusal({Mode::kMinip, Lattice::kPixel, true}, {}), "");
  EXPECT_EQ(engineRefusal({Mode::kMinip, Lattice::kPixel, true}, {.aovs = {.value = true}}),
            "--aov: value is of one projected volume (found several); leave --aov out");
}

TEST(Capabilities, DistanceOfSamples_hasARangeAndAnEngine) {
  EXPECT_EQ(engineRefusal({}, {.sample_distance = 0.75, .aovs = {}}), "");
  for (const double wrong : {0.2, 1.1, -1.0}) {
    EXPECT_NE(engineRefusal({}, {.sample_distance = wrong, .aovs = {}}).find("from 0.25 to 1 (found "),
              std::string::npos)
        << wrong;
  }
  EXPECT_NE(engineRefusal(kVoxelEngine, {.sample_distance = 0.75, .aovs = {}}), "");
  EXPECT_NE(engineRefusal(kMipEngine, {.sample_distance = 0.75, .aovs = {}}), "");
}

TEST(Capabilities, Manual_printsTheTable) {
  const std::string page = readTextFile(std::filesystem::path(KILN_SOURCE_DIR) / "tools/kiln/manual/limits.md");
  EXPECT_NE(page.find(capabilityTable()), std::string::npos) << capabilityTable();
}

}  // namespace
}  // namespace kiln::test

#include <fmt/format.h>

#include "base/file.h"
#include "base/memory.h"
#include "commands.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace {

const char* className(VolumeClass volume_class) {
  switch (volume_class) {
    case VolumeClass::kFog:
      return "fog";
    case VolumeClass::kLevelSet:
      return "level set";
    case VolumeClass::kUnknown:
      break;
  }
  return "unknown";
}

const char* frameName(PatientFrame frame) {
  switch (frame) {
    case PatientFrame::kRas:
      return "RAS (+x right, +y anterior, +z superior)";
    case PatientFrame::kLps:
      return "LPS (+x left, +y posterior, +z superior)";
    case PatientFrame::kUnknown:
      break;
  }
  return "unknown";
}

void printForPeople(const StoreReader& store) {
  const Manifest& m = store.manifest();
  const VolumeGeometry& g = m.geometry();
  const glm::dvec3 spacing = g.spacing();
  const std::string unit = g.unit.empty() ? "world units" : g.unit;
  fmt::print("store        {} (format {})\n", store.path().string(), kFormatVersion);
  fmt::print("dimensions   {} x {} x {} voxels of {} ({})\n", g.dims.x, g.dims.y, g.dims.z, nameOf(m.type),
             formatBytes(static_cast<std::uint64_t>(g.dims.count()) * sizeOf(m.type)));
  fmt::print("spacing      {:.6g} x {:.6g} x {:.6g} {}\n", spacing.x, spacing.y, spacing.z, unit);
  fmt::print("affine       ");
  for (int row = 0; row < 3; ++row) {
    fmt::print("{}[{:.6g} {:.6g} {:.6g} {:.6g}]\n", row == 0 ? "" : "             ", g.world_from_index[0][row],
               g.world_from_index[1][row], g.world_from_index[2][row], g.world_from_index[3][row]);
  }
  fmt::print("patient      {}\n", frameName(g.frame));
  if (m.range.empty()) {
    fmt::print("values       none but NaN\n");
  } else {
    fmt::print("values       {:.9g} to {:.9g}, background {:.6g}, class {}\n", m.range.lo, m.range.hi, m.background,
               className(m.volume_class));
  }
  if (m.nan_count > 0) fmt::print("NaN          {} voxels\n", m.nan_count);
  for (std::size_t i = 0; i < m.levels.size(); ++i) {
    const LevelInfo& level = m.levels[i];
    fmt::print("level {}      {} x {} x {} voxels, {} bricks of {}^3, {} stored in {}\n", i, level.geometry.dims.x,
               level.geometry.dims.y, level.geometry.dims.z, level.bricks.count(), m.brick_size, level.stored_bricks,
               formatBytes(level.stored_bytes));
  }
  fmt::print("codec        {}, blosc\n", m.container_version);
  // A directory of slices comes first, then its slices.
  const std::vector<std::string>& files = m.source.files;
  const std::size_t named = files.size() > 3 ? 1 : files.size();
  for (std::size_t i = 0; i < named; ++i) fmt::print("source       {} ({})\n", files[i], m.source.format);
  if (named < files.size()) fmt::print("             and {} files in it\n", files.size() - named);
  if (!m.source.command.empty()) fmt::print("made by      {}\n", m.source.command);
  if (!m.source.time.empty()) fmt::print("made at      {}\n", m.source.time);
}

}  // namespace

void addInfo(CLI::App& app, Context& context) {
  auto path = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("info", "say what a store holds");
  command->add_option("STORE", *path, "the store")->required();
  command->add_flag("--json", *json, "the manifest as JSON, for programs");
  command->callback([path, json, &context] {
    context.action = [path, json] {
      const StoreReader store(*path);  // checks before anything is printed
      if (*json) {
        fmt::print("{}", readTextFile(store.path() / "manifest.json"));
      } else {
        printForPeople(store);
      }
    };
  });
}

}  // namespace kiln::tool

#include "engine/capabilities.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"

namespace kiln {
namespace {

struct CapabilityRow {
  Capability capability;
  std::string_view text;
};

// The rows of the printed table.
constexpr CapabilityRow kCapabilityRows[] = {
    {&EngineCapabilities::several_volumes, "several volumes in one picture (`--add`, `--labels`)"},
    {&EngineCapabilities::composites, "light and opacity; opaque pixels hide bricks"},
    {&EngineCapabilities::labels, "volumes of labels"},
    {&EngineCapabilities::gradient_opacity, "opacity by gradient"},
    {&EngineCapabilities::surfaces, "surfaces (`--tf iso:VALUE`)"},
    {&EngineCapabilities::cubic, "`--interpolation cubic`, `catmull-rom`"},
    {&EngineCapabilities::sample_distance, "`--sample-distance`"},
    {&EngineCapabilities::coarser_levels, "`--level auto+N`"},
    {&EngineCapabilities::filters_rays, "pixel filter, automatic `--samples`, `--samples 2`"},
    {&EngineCapabilities::depth_and_normal, "`--aov depth,normal`"},
    {&EngineCapabilities::value, "`--aov value`"},
    {&EngineCapabilities::companions, "`--mask`, `--color-by`"},
    {&EngineCapabilities::sections, "`--section`"},
    {&EngineCapabilities::deep, "`--deep`"},
    {&EngineCapabilities::parts, "`--part`, `--distribute bricks`"},
};

// Returns the options that choose engines with the capability: "A", "A, or B", "A, B, or C". A projection is left by
// --mode composite, whatever the lattice.
std::string enginesWith(Capability capability, EngineKind found) {
  std::vector<std::string_view> names;
  for (const EngineCapabilities& engine : engineCapabilities()) {
    if (!(engine.*capability)) continue;
    if (found == EngineKind::kProjection && engine.composites) return "--mode composite";
    names.push_back(engine.chosen_by);
  }
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) out += i + 1 == names.size() ? ", or " : ", ";
    out += names[i];
  }
  return out;
}

}  // namespace

const std::vector<EngineCapabilities>& engineCapabilities() {
  static const std::vector<EngineCapabilities> table = {
      {.kind = EngineKind::kPixel,
       .chosen_by = "--lattice pixel",
       .composites = true,
       .labels = true,
       .gradient_opacity = true,
       .surfaces = true,
       .cubic = true,
       .sample_distance = true,
       .coarser_levels = true,
       .filters_rays = true,
       .depth_and_normal = true,
       .companions = true,
       .sections = true,
       .deep = true,
       .parts = true},
      {.kind = EngineKind::kVoxel,
       .chosen_by = "--lattice voxel",
       .composites = true,
       .labels = true,
       .gradient_opacity = true,
       .depth_and_normal = true,
       .parts = true},
      {.kind = EngineKind::kProjection,
       .chosen_by = "--mode mip, minip, average or attenuated-mip",
       .several_volumes = true,
       .coarser_levels = true,
       .value = true},
      {.kind = EngineKind::kMultiVolume,
       .chosen_by = "several volumes",
       .several_volumes = true,
       .composites = true,
       .labels = true,
       .gradient_opacity = true,
       .surfaces = true,
       .cubic = true,
       .sample_distance = true,
       .coarser_levels = true,
       .filters_rays = true,
       .depth_and_normal = true,
       .companions = true,
       .sections = true,
       .deep = true},
  };
  return table;
}

EngineKind EngineChoice::kind() const {
  if (mode != Mode::kComposite) return EngineKind::kProjection;
  if (lattice == Lattice::kVoxel) return EngineKind::kVoxel;
  return several_volumes ? EngineKind::kMultiVolume : EngineKind::kPixel;
}

const EngineCapabilities& EngineChoice::capabilities() const {
  const std::vector<EngineCapabilities>& table = engineCapabilities();
  return *std::find_if(table.begin(), table.end(), [&](const EngineCapabilities& row) { return row.kind == kind(); });
}

std::string EngineChoice::text() const {
  switch (kind()) {
    case EngineKind::kProjection:
      return fmt::format("--mode {}", nameIn(kModeNames, mode));
    case EngineKind::kPixel:
    case EngineKind::kVoxel:
      return fmt::format("--lattice {}", nameIn(kLatticeNames, lattice));
    case EngineKind::kMultiVolume:
      break;
  }
  return std::string(capabilities().chosen_by);
}

void requireCapability(const EngineChoice& engine, Capability capability, std::string_view subject,
                       std::string_view remedy) {
  if (engine.capabilities().*capability) return;
  // The engine of several volumes draws as the pixel lattice does, which lacks nothing for one volume.
  if (engine.kind() == EngineKind::kMultiVolume)
    throw Error(ErrorCode::kUsage, fmt::format("{} one volume (found several volumes); {}", subject, remedy));
  throw Error(ErrorCode::kUsage, fmt::format("{} {} (found {}); {}", subject, enginesWith(capability, engine.kind()),
                                             engine.text(), remedy));
}

void requireOptions(const EngineChoice& engine, const EngineOptions& options) {
  if (engine.several_volumes && !engine.capabilities().several_volumes)
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: draws one volume (found several); leave it out, or draw each volume by itself",
                            engine.text()));
  if (engine.kind() == EngineKind::kProjection && engine.lattice != Lattice::kPixel)
    throw Error(ErrorCode::kUsage, fmt::format("--lattice {}: needs --mode composite (found {}); leave --lattice out",
                                               nameIn(kLatticeNames, engine.lattice), nameIn(kModeNames, engine.mode)));
  if (options.interpolation != Interpolation::kLinear)
    requireCapability(engine, &EngineCapabilities::cubic,
                      fmt::format("--interpolation {}: needs", nameIn(kInterpolationNames, options.interpolation)),
                      "leave --interpolation out");
  if (options.samples == 2)
    requireCapability(engine, &EngineCapabilities::filters_rays, "--samples 2: needs", "choose 1, 4 or 16 samples");
  const double distance = options.sample_distance;
  if (!(distance >= kLeastSampleDistance && distance <= kMostSampleDistance))
    throw Error(ErrorCode::kUsage,
                fmt::format("--sample-distance: expected a number of voxels from {} to {} (found {})",
                            kLeastSampleDistance, kMostSampleDistance, distance));
  if (distance != kSampleDistance)
    requireCapability(engine, &EngineCapabilities::sample_distance, "--sample-distance: needs",
                      "leave --sample-distance out");
  if (options.coarser > 0)
    requireCapability(engine, &EngineCapabilities::coarser_levels,
                      fmt::format("--level auto+{}: needs", options.coarser), "choose a level by its number");
  if (options.aovs.depth || options.aovs.normal) {
    const bool has_values = engine.capabilities().value && !engine.several_volumes;
    requireCapability(engine, &EngineCapabilities::depth_and_normal, "--aov: depth and normal need",
                      has_values ? "choose --aov value" : "leave --aov out");
  }
  if (options.aovs.value && engine.several_volumes)
    throw Error(ErrorCode::kUsage, "--aov: value is of one projected volume (found several); leave --aov out");
  if (options.aovs.value)
    requireCapability(engine, &EngineCapabilities::value, "--aov: value needs", "choose one of these modes");
}

void requireSurfaces(const EngineChoice& engine, const TransferFunction& function) {
  if (function.surfaces.empty()) return;
  requireCapability(engine, &EngineCapabilities::surfaces, "--tf: surfaces (iso:VALUE) need", "choose solid:VALUE");
}

std::string capabilityTable() {
  std::string head = "| |", line = "| --- |";
  for (const EngineCapabilities& engine : engineCapabilities()) {
    head += fmt::format(" {} |", engine.chosen_by);
    line += " --- |";
  }
  std::string out = head + "\n" + line + "\n";
  for (const CapabilityRow& row : kCapabilityRows) {
    out += fmt::format("| {} |", row.text);
    for (const EngineCapabilities& engine : engineCapabilities()) out += engine.*row.capability ? " yes |" : " no |";
    out += "\n";
  }
  return out;
}

}  // namespace kiln

#include <fmt/format.h>

#include "base/file/file.h"
#include "base/memory/memory.h"
#include "commands.h"
#include "examples.h"
#include "foreign_store.h"
#include "frame/transfer_function_picture.h"
#include "image/file/image_file.h"
#include "image/named_color.h"
#include "ingest/open_source.h"
#include "job/job_names.h"
#include "job/transfer_function_json.h"
#include "output_files.h"
#include "say.h"
#include "scene/transfer/presets.h"
#include "scene_arguments.h"
#include "store/manifest/read_manifest.h"
#include "volume_values.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

struct TfArguments {
  std::string input, tf, window, output, memory = kDefaultMemory;
  bool json = false;
  ForeignArguments source;
};

// The volume for which a function is shown: a store's or a file's, or without a volume typical values: Hounsfield units
// from air to dense bone for CT, else 0 to 1, with voxels of 1.
struct Subject {
  VolumeValues values;
  TransferFunctionChoice choice;
  bool volume = false;
  bool unit_is_voxel = false;  // without a volume, a function without a unit of its own counts in voxels

  std::string lengthUnit() const {
    if (unit_is_voxel) return "voxel";
    const std::string& stated = values.manifest.geometry().unit;
    return stated.empty() ? "world unit" : stated;
  }
};

Manifest withoutVolume(const TransferFunctionChoice& choice) {
  const auto* name = std::get_if<std::string>(&choice);
  if (name != nullptr && (*name == "auto" || name->starts_with("mr-")))
    throw Error(ErrorCode::kUsage,
                fmt::format("'{0}' is found in a volume's histogram: run kiln tf VOLUME --tf {0}", *name));
  Manifest out;
  out.type = VoxelType::f32;
  out.range = {0, 1};
  if (name != nullptr && name->starts_with("ct-")) out.range = {-1024, 3071};
  out.levels.resize(1);
  out.levels[0].geometry.dims = {256, 256, 256};
  const auto* file = std::get_if<fs::path>(&choice);
  if (file != nullptr && !readTransferFunction(*file, out).labels.empty()) out.volume_class = VolumeClass::kLabels;
  return out;
}

VolumeValues valuesOfFile(const TfArguments& a, const OutputFiles& outputs, Context& context) {
  const ForeignVolume volume = a.source.volume(a.input);
  const std::uint64_t memory_bytes = parseBytes(a.memory, "--memory");
  const std::unique_ptr<VolumeSource> source = openedWithin(memory_bytes, volume);
  outputs.requireNoneOf(source->info().files);
  return valuesOf(volume, *source, memory_bytes, context.progress);
}

Subject subjectOf(const TfArguments& a, const OutputFiles& outputs, Context& context) {
  const auto choice = [&] { return transferFunctionNamed(a.tf.empty() ? "auto" : a.tf, "--tf"); };
  if (namesVolumeFile(a.input, a.source)) {
    const TransferFunctionChoice function = choice();
    return {valuesOfFile(a, outputs, context), function, true};
  }
  std::error_code ignored;
  if (fs::is_directory(a.input, ignored)) {
    a.source.requireNoneForStore(a.input);
    return {{readManifest(a.input), "", 0}, choice(), true};
  }
  if (!a.tf.empty())
    throw Error(ErrorCode::kUsage, fmt::format("--tf goes with a store or a volume file, and '{}' is none", a.input));
  const TransferFunctionChoice function = transferFunctionNamed(a.input, "kiln tf");
  if (a.source.any() || a.source.namesDirectory())
    throw Error(ErrorCode::kUsage, fmt::format("'{}' is no volume file, and the options of foreign files are of these; "
                                               "leave the options out",
                                               a.input));
  return {{withoutVolume(function), "", 0}, function, false};
}

void printSurfaces(const TransferFunction& f) {
  say("{:>14}  {:>8}  {:>7}  {:<24}\n", "value", "opacity", "sRGB", "red, green, blue (linear light)");
  for (const IsoSurface& s : f.surfaces)
    say("{:>14.9g}  {:>8.5f}  {}  {:.4f}, {:.4f}, {:.4f}\n", s.value, s.opacity, hexText(s.color), s.color.r, s.color.g,
        s.color.b);
  say("{} surfaces; opacity is per crossing\n", f.surfaces.size());
}

// Opacity over values and gradients, and light.
void printPlane(const TransferFunction& f, std::string_view unit) {
  for (const GradientRegion& r : f.regions)
    say("{:>14.9g}  {:>8.5f}  of the opacity, up to value {:.9g}, gradients {:.9g} to {:.9g} per {}, a {}{}\n",
        r.values.x, r.opacity, r.values.y, r.gradients.x, r.gradients.y, unit, nameIn(kRegionShapeNames, r.shape),
        r.color ? ", " + hexText(*r.color) : std::string());
  if (const GradientTable& t = f.table; t.columns > 0)
    say("{} x {} factors of the opacity, values {:.9g} to {:.9g}, gradients {:.9g} to {:.9g} per {}\n", t.columns,
        t.rows, t.values.x, t.values.y, t.gradients.x, t.gradients.y, unit);
  if (f.scattering)
    say("scatters light: albedo {:.6g}, anisotropy {:.6g}\n", f.scattering->albedo, f.scattering->anisotropy);
  else if (!f.shaded)
    say("without light\n");
}

void print(const TransferFunction& f, const Subject& subject) {
  const Manifest& manifest = subject.values.manifest;
  const std::string unit = subject.lengthUnit();
  if (subject.volume && manifest.range.empty()) {
    say("volume       no value is a number\n");
  } else if (subject.volume) {
    say("volume       values {:.9g} to {:.9g}\n", manifest.range.lo, manifest.range.hi);
    sayHistogram(subject.values);
    sayWindows(manifest);
  }
  if (!f.surfaces.empty()) return printSurfaces(f);
  say("opacity      per {:.6g} {}, between points linear, outside of them as at the ends\n", f.unit, unit);
  say("{:>14}  {:>8}  {:>12}  {:>7}  {:<24}\n", "value", "opacity", "extinction", "sRGB",
      "red, green, blue (linear light)");
  for (const TransferPoint& p : f.points) {
    say("{:>14.9g}  {:>8.5f}  {:>12.5g}  {}  {:.4f}, {:.4f}, {:.4f}\n", p.value, p.opacity,
        extinctionOf(p.opacity, f.unit), hexText(p.color), p.color.r, p.color.g, p.color.b);
  }
  for (const GradientPoint& p : f.gradient_opacity)
    say("{:>14.9g}  {:>8.5f}  of the opacity, by gradient in values per {}\n", p.gradient, p.factor, unit);
  printPlane(f, unit);
  say("{} points; extinction is per {}\n", f.points.size(), unit);
}

void printLabels(const TransferFunction& f, const Subject& subject) {
  say("{:>9}  {:>8}  {:>12}  {:>7}  {}\n", "label", "opacity", "extinction", "sRGB", "name");
  for (const LabelStyle& look : f.labels)
    say("{:>9.0f}  {:>8.5f}  {:>12.5g}  {}  {}\n", look.label, look.opacity, extinctionOf(look.opacity, f.unit),
        hexText(look.color), look.name);
  say("{} labels; opacity is per {:.6g} {}\n", f.labels.size(), f.unit, subject.lengthUnit());
}

void run(const TfArguments& a, Context& context) {
  if (!a.output.empty()) {
    requireImagePath(a.output);
    FileSystem::real().requirePlaceFor(a.output);
  }
  OutputFiles outputs;
  outputs.add(a.output);
  for (const std::string& read : {a.input, a.tf}) {
    outputs.requireNone(read);
    outputs.requireNone(fileOf(read));
  }
  Subject subject = subjectOf(a, outputs, context);
  const Manifest& manifest = subject.values.manifest;
  std::optional<Window> window;
  if (!a.window.empty()) window = parseWindow(a.window, "--window");
  const TransferFunction function = resolve(subject.choice, window, manifest);
  subject.unit_is_voxel = !subject.volume && functionFor(subject.choice, window, manifest).unit == 0;
  if (!function.labels.empty() && !a.output.empty())
    throw Error(ErrorCode::kUsage, "-o: labels have no curve to draw; leave -o out");
  if (!a.output.empty()) writeImage(transferFunctionPicture(function, manifest.histogram), {}, {}, a.output);
  if (a.json)
    // Without a volume, a unit that depends on the volume stays so.
    sayJson(transferFunctionText(subject.volume ? function : functionFor(subject.choice, window, manifest)));
  else if (function.labels.empty())
    print(function, subject);
  else
    printLabels(function, subject);
}

}  // namespace

void addTf(CLI::App& app, Context& context) {
  auto a = std::make_shared<TfArguments>();
  CLI::App* command =
      app.add_subcommand("tf", "Show a transfer function as text, and as a picture over the histogram.");
  command
      ->add_option("INPUT", a->input,
                   fmt::format("A store, a volume file (which is sampled), a transfer function file (FILE or "
                               "FILE#NAME), points VALUE:OPACITY[:COLOR],..., or "
                               "a preset: {}",
                               presetList()))
      ->required();
  context.facts.offer(
      command->add_option("--tf", a->tf,
                          "The transfer function of the store or volume file: a file, points or a preset (default "
                          "auto)."),
      presetNames());
  command
      ->add_option("--window", a->window, "Stretch the function so that it begins and ends with this window of values.")
      ->type_name("CENTRE,WIDTH");
  command->add_flag("--json", a->json,
                    "Print the function as a transfer function file: the object transferFunction of a job.");
  command->add_option("-o,--output", a->output, "The picture, .png, .exr, .tif or .jpg.");
  addExamples(*command, {"kiln tf ct-bone", "kiln tf scan.nrrd", "kiln tf head.kiln --tf viridis -o viridis.png",
                         "kiln tf head.kiln --tf ct-bone --json > bone.json"});
  addMemory(*command, a->memory, "the sample of a volume file")->capture_default_str();
  addForeignArguments(*command, context.facts, a->source);
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool

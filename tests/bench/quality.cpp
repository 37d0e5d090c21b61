// Quality of Kiln's pictures of real volumes against the reference renderer (16 rays a pixel, steps of a tenth of a
// voxel). Baselines: a ray caster of one ray a pixel with steps of a whole voxel (VTK's default) and of half a voxel.
// Pictures smaller than the volume are also compared with a reference of their level of the pyramid, and this reference
// with the volume's: the upper bound for the level. Edges are measured separately: within two pixels of silhouettes.
// Prints a line per scene and averages per magnification. Writes the pictures (Kiln's, the reference, the difference)
// and a contact sheet per volume to the output folder.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>

#include "base/error.h"
#include "convert/convert.h"
#include "frame/render_frame.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "job/frame/auto_samples.h"
#include "job/job_names.h"
#include "support/reference/contact_sheet.h"
#include "support/reference/quality_scenes.h"
#include "support/reference/reference_cache.h"
#include "support/reference/silhouettes.h"
#include "support/volumes/level_volume.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

/// By default a ray ends when its pixel closes; the rest adds a ten-thousandth.
constexpr ReferenceSettings kTruth{4, 0.1, 0.9999};
constexpr ReferenceSettings kHalfStep{1, 0.5, 1};
/// Larger differences between neighbouring depths separate two surfaces. unit: voxels, or pixels if larger.
constexpr double kSilhouetteJump = 4;

struct Options {
  std::vector<std::string> volumes, materials{"skin", "bone", "bone_in_skin"};
  std::vector<std::string> projections{"orthographic", "perspective"};
  std::vector<double> px_per_voxel{0.5, 1, 2, 4};
  int size = 256;
  std::string samples = "auto", lattice = "pixel", interpolation = "linear", reference_interpolation;
  double opacity_threshold = 0.9999, sample_distance = kSampleDistance;
  fs::path data = KILN_TEST_DATA_DIR, output = fs::path(KILN_TEST_OUTPUT_DIR) / "quality";
  bool full = false, no_reference_cache = false, no_levels = false;
};

Options parsed(int argc, char** argv) {
  Options o;
  for (const QualityVolume& v : qualityVolumes()) o.volumes.push_back(v.name);
  const std::vector<std::string> names(kInterpolationNames.begin(), kInterpolationNames.end());
  CLI::App app("Measures the quality of pictures against the reference renderer.");
  app.add_option("--data", o.data, "folder of the real volumes")->capture_default_str();
  app.add_option("--output", o.output, "folder for pictures, stores and kept references")->capture_default_str();
  app.add_option("--volumes", o.volumes)->check(CLI::IsMember(o.volumes))->capture_default_str();
  app.add_option("--materials", o.materials)->check(CLI::IsMember(o.materials))->capture_default_str();
  app.add_option("--projections", o.projections)->check(CLI::IsMember(o.projections))->capture_default_str();
  app.add_option("--px-per-voxel", o.px_per_voxel)->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--size", o.size, "pixels along each side")->capture_default_str();
  app.add_option("--lattice", o.lattice)
      ->check(CLI::IsMember(std::vector<std::string>(kLatticeNames.begin(), kLatticeNames.end())))
      ->capture_default_str();
  app.add_option("--interpolation", o.interpolation)->check(CLI::IsMember(names))->capture_default_str();
  app.add_option("--reference-interpolation", o.reference_interpolation, "that of --interpolation if not given")
      ->check(CLI::IsMember(names));
  app.add_option("--samples", o.samples, "a pixel")
      ->check(CLI::IsMember({"auto", "1", "2", "4", "16"}))
      ->capture_default_str();
  app.add_option("--opacity-threshold", o.opacity_threshold)->capture_default_str();
  app.add_option("--sample-distance", o.sample_distance, "between samples, in voxels")->capture_default_str();
  app.add_flag("--full", o.full, "512x512 pixels, 0.25 to 8 pixels a voxel");
  app.add_flag("--no-reference-cache", o.no_reference_cache, "make every reference anew and keep none");
  app.add_flag("--no-levels", o.no_levels, "leave out references of the coarser levels that pictures show");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::exit(app.exit(error));
  }
  if (o.reference_interpolation.empty()) o.reference_interpolation = o.interpolation;
  if (o.full) {
    o.size = 512;
    o.px_per_voxel = {0.25, 0.5, 1, 2, 4, 8};
  }
  return o;
}

Interpolation interpolationNamed(const std::string& name) {
  const auto found = std::find(kInterpolationNames.begin(), kInterpolationNames.end(), name);
  return static_cast<Interpolation>(found - kInterpolationNames.begin());
}

template <class T>
bool among(const std::vector<T>& values, const T& value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

// Results of a scene. unit: dB, seconds.
struct Measured {
  double px_per_voxel = 1;
  ImageDifference kiln, voxel_steps, half_steps;
  std::optional<ImageDifference> same_level, level_itself;
  double edge_db = 0;  // within two pixels of silhouettes
  int level = 0;
  double frame_s = 0;
};

// A volume with all inputs of its pictures.
class Studio {
 public:
  Studio(const Options& options, const QualityVolume& subject)
      : options_(options), subject_(subject), volume_(readVolume(options.data / subject.file)) {
    const fs::path store = options.output / "stores" / (subject.name + ".kiln");
    fs::create_directories(store.parent_path());
    DenseSource source(volume_);
    Progress silent;
    convert(source, store, {.overwrite = true, .command = "quality", .time = "2000-01-01T00:00:00Z"}, silent);
    store_.emplace(store);
    cache_.emplace(*store_, 4ull << 30);
    references_.emplace(volume_, referenceFolder());
  }

  Measured measure(Material material, Projection projection, double px_per_voxel, std::vector<Image>& triple) {
    const Camera camera = cameraOf(subject_, volume_.geometry, projection, px_per_voxel, options_.size);
    FrameRequest request;
    request.view = resolve(camera, {options_.size, options_.size});
    request.transfer_function = transferFunctionOf(subject_, material);
    request.transfer_function.unit = volume_.geometry.meanSpacing();  // constant over all levels
    request.opacity_threshold = options_.opacity_threshold;
    request.sample_distance = options_.sample_distance;
    const auto* const name = std::find(kLatticeNames.begin(), kLatticeNames.end(), options_.lattice);
    request.lattice = static_cast<Lattice>((name - kLatticeNames.begin()) % std::ptrdiff_t{kLatticeCount});
    request.interpolation = interpolationNamed(options_.interpolation);
    request.samples = samplesFor(camera);
    FrameStatistics statistics;
    drawn(request, statistics);  // reads the bricks
    const Image image = drawn(request, statistics);
    const Image reference = referenceOf(*references_, request, kTruth);
    Measured out;
    out.px_per_voxel = px_per_voxel;
    out.frame_s = statistics.wall_s;
    out.kiln = compareImages(reference, image);
    out.voxel_steps = compareImages(reference, referenceOf(*references_, request, ReferenceSettings::vtkLike()));
    out.half_steps = compareImages(reference, referenceOf(*references_, request, kHalfStep));
    out.edge_db = psnrWithin(bandOf(reference, request, px_per_voxel), reference, image);
    out.level = mostDrawn(statistics);
    if (out.level > 0 && !options_.no_levels) {
      request.level = out.level;
      const Image level_reference = referenceOf(levelReferences(out.level), request, kTruth);
      out.same_level = compareImages(level_reference, drawn(request, statistics));
      out.level_itself = compareImages(reference, level_reference);
    }
    triple = {image, reference, differenceImage(image, reference)};
    return out;
  }

 private:
  struct Level {
    DenseVolume volume;
    std::optional<ReferencePictures> references;
  };

  std::optional<fs::path> referenceFolder() const {
    return options_.no_reference_cache ? std::nullopt : std::optional(options_.output / "references");
  }

  Image drawn(const FrameRequest& request, FrameStatistics& statistics) {
    Progress silent;
    statistics = {};
    return renderFrame(*cache_, request, silent, statistics);
  }

  Image referenceOf(const ReferencePictures& pictures, const FrameRequest& request, ReferenceSettings settings) const {
    settings.interpolation = interpolationNamed(options_.reference_interpolation);
    return pictures.draw(request.view, request.transfer_function, request.shading, settings);
  }

  std::vector<bool> bandOf(const Image& reference, const FrameRequest& request, double px_per_voxel) const {
    const double jump = kSilhouetteJump * volume_.geometry.shortestEdge() * std::max(1.0, 1 / px_per_voxel);
    return silhouetteBand(reference, firstHits(volume_, request.view, request.transfer_function, kHalfStep), jump);
  }

  int samplesFor(const Camera& camera) const {
    if (options_.samples != "auto") return std::stoi(options_.samples);
    RenderJob job;
    job.picture.size = {options_.size, options_.size};
    return automaticSamples(job, camera, centreOf(volume_.geometry), {&store_->manifest()});
  }

  static int mostDrawn(const FrameStatistics& statistics) {
    const auto& levels = statistics.levels;
    const auto most = std::max_element(levels.begin(), levels.end(),
                                       [](const auto& a, const auto& b) { return a.voxels_splats < b.voxels_splats; });
    return static_cast<int>(most - levels.begin());
  }

  const ReferencePictures& levelReferences(int level) {
    Level& entry = levels_[level];
    if (!entry.references) {
      entry.volume = levelVolume(*store_, level);
      entry.references.emplace(entry.volume, referenceFolder());
    }
    return *entry.references;
  }

  const Options& options_;
  const QualityVolume& subject_;
  DenseVolume volume_;
  std::optional<StoreReader> store_;
  std::optional<BrickCache> cache_;
  std::optional<ReferencePictures> references_;
  std::map<int, Level> levels_;
};

void printScene(const std::string& scene, const Measured& m) {
  const std::string level = m.same_level
                                ? fmt::format("{:5.2f} (level {}, itself {:5.2f})", m.same_level->foreground_psnr_db,
                                              m.level, m.level_itself->foreground_psnr_db)
                                : "";
  fmt::print("{:<40} {:>5} px {:6.2f} dB {:6.2f} {:6.2f} {:6.2f}  {:+6.2f} %  {:6.0f} ms  {}\n", scene, m.px_per_voxel,
             m.kiln.foreground_psnr_db, m.edge_db, m.voxel_steps.foreground_psnr_db, m.half_steps.foreground_psnr_db,
             100 * (m.kiln.mean_brightness_ratio - 1), 1e3 * m.frame_s, level);
  std::fflush(stdout);
}

void printAverages(const std::vector<Measured>& all) {
  std::map<double, std::vector<const Measured*>> by_magnification;
  for (const Measured& m : all) by_magnification[m.px_per_voxel].push_back(&m);
  for (const auto& [px, scenes] : by_magnification) {
    double kiln = 0, least = 1e9, edges = 0, least_edges = 1e9, voxel_steps = 0, half_steps = 0, brightness = 0,
           frame_s = 0, level = 0;
    int below = 0, with_edges = 0, with_level = 0;
    for (const Measured* m : scenes) {
      kiln += m->kiln.foreground_psnr_db;
      least = std::min(least, m->kiln.foreground_psnr_db);
      // Some close-ups have no silhouette.
      if (std::isfinite(m->edge_db)) edges += m->edge_db, ++with_edges;
      least_edges = std::min(least_edges, m->edge_db);
      voxel_steps += m->voxel_steps.foreground_psnr_db;
      half_steps += m->half_steps.foreground_psnr_db;
      brightness = std::max(brightness, std::abs(m->kiln.mean_brightness_ratio - 1));
      frame_s += m->frame_s;
      below += m->kiln.foreground_psnr_db < m->voxel_steps.foreground_psnr_db;
      if (m->same_level) level += m->same_level->foreground_psnr_db;
      with_level += m->same_level.has_value();
    }
    const auto n = static_cast<double>(scenes.size());
    fmt::print(
        "mean of {:>3} scenes at {:>5} px/voxel: kiln {:.2f} dB (least {:.2f}), edges {:.2f} (least {:.2f}), "
        "voxel steps {:.2f}, half steps {:.2f}; {} below voxel steps; brightness off by {:.2f} % at most; {:.0f} ms",
        scenes.size(), px, kiln / n, least, edges / with_edges, least_edges, voxel_steps / n, half_steps / n, below,
        100 * brightness, 1e3 * frame_s / n);
    fmt::print("{}\n", with_level > 0 ? fmt::format("; same level {:.2f} dB", level / with_level) : "");
  }
}

void measureVolume(const Options& options, const QualityVolume& subject, std::vector<Measured>& all) {
  if (!fs::exists(options.data / subject.file)) {
    fmt::print("{}: {} is not here; left out\n", subject.name, (options.data / subject.file).string());
    return;
  }
  Studio studio(options, subject);
  std::vector<std::vector<Image>> sheet;
  for (const Material material : kMaterials) {
    if (!among(options.materials, std::string(nameOf(material)))) continue;
    for (const Projection projection : {Projection::kOrthographic, Projection::kPerspective}) {
      if (!among(options.projections, std::string(nameOf(projection)))) continue;
      const std::size_t row = sheet.size();
      sheet.resize(row + 3);
      for (const double px_per_voxel : options.px_per_voxel) {
        std::vector<Image> triple;
        all.push_back(studio.measure(material, projection, px_per_voxel, triple));
        const std::string scene = fmt::format("{} {} {}", subject.name, nameOf(material), nameOf(projection));
        printScene(scene, all.back());
        std::string file =
            fmt::format("{}_{}_{}_{}px.png", subject.name, nameOf(material), nameOf(projection), px_per_voxel);
        fs::create_directories(options.output / "scenes");
        writeImage(contactSheet({triple}, options.size), {}, {}, options.output / "scenes" / file);
        for (std::size_t i = 0; i < 3; ++i) sheet[row + i].push_back(std::move(triple[i]));
      }
    }
  }
  const fs::path file = options.output / fmt::format("sheet_{}_{}.png", subject.name, options.lattice);
  writeImage(contactSheet(sheet, 256), {}, {}, file);
  fmt::print("{}\n", file.string());
}

int run(int argc, char** argv) {
  const Options options = parsed(argc, argv);
  fmt::print(
      "foreground PSNR of lattice {}, {} interpolation (reference {}), {} sample(s) a pixel, {}x{} px, opacity "
      "threshold {}\n",
      options.lattice, options.interpolation, options.reference_interpolation, options.samples, options.size,
      options.size, options.opacity_threshold);
  fmt::print("{:<40} {:>8} {:>9} {:>6} {:>6} {:>6}  {:>8}  {:>9}  {}\n", "scene", "px/voxel", "kiln", "edges", "step 1",
             "step ½", "bright", "frame", "same level");
  std::vector<Measured> all;
  for (const QualityVolume& subject : qualityVolumes()) {
    if (among(options.volumes, subject.name)) measureVolume(options, subject, all);
  }
  printAverages(all);
  return 0;
}

}  // namespace
}  // namespace kiln::test

int main(int argc, char** argv) {
  try {
    return kiln::test::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "quality: %s\n", error.what());
    return 1;
  }
}

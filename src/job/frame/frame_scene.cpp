#include "job/frame/frame_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>
#include <utility>
#include <variant>

#include "base/error.h"
#include "base/number_text.h"
#include "engine/shown_box.h"
#include "grid/length_unit.h"
#include "job/animation.h"
#include "job/frame/auto_samples.h"
#include "job/frame/series_look.h"
#include "job/job_facts.h"
#include "job/stereo.h"
#include "job/transfer_function_choice.h"
#include "scene/annotation_text.h"
#include "scene/camera/camera_path.h"
#include "scene/camera/framing.h"
#include "scene/scene_limits.h"
#include "scene/transfer/display_map.h"
#include "scene/transfer/label_styles.h"
#include "scene/transfer/presets.h"
#include "scene/transfer/projection_range.h"
#include "scene/transfer/transfer_function_fade.h"
#include "scene/volume_part.h"
#include "store/manifest/store_name.h"

namespace kiln {

namespace {

// Between a function of surfaces and a function of points there is no transition.
void requireSurfacesInAllOrNone(const std::vector<TransferFunction>& keys) {
  for (const TransferFunction& function : keys) {
    if (function.surfaces.empty() != keys.front().surfaces.empty())
      throw Error(
          ErrorCode::kUsage,
          "transferFunction.keyframes: expected surfaces in each key or in none; write solid:VALUE for iso:VALUE");
  }
}

// Regions of neighbouring keys are drawn together.
void requireFewRegions(const std::vector<TransferFunction>& keys) {
  for (std::size_t i = 1; i < keys.size(); ++i) {
    const std::size_t together = keys[i - 1].regions.size() + keys[i].regions.size();
    if (regionsFade(keys[i - 1], keys[i]) && together > kMostRegions)
      throw Error(
          ErrorCode::kUsage,
          fmt::format("transferFunction.keyframes: at most {} regions in two neighbouring keys, which fade into "
                      "each other (found {}); merge regions, or write equal regions in both keys",
                      kMostRegions, together));
  }
}

// Share of the volume that clipping leaves; 1 if that is nothing.
double shownShare(const VolumeGeometry& volume, const Clipping& clipping) {
  const std::int64_t shown = boxOfClip(volume, clipping).count();
  return shown > 0 ? static_cast<double>(shown) / static_cast<double>(volume.dims.count()) : 1;
}

}  // namespace

TransferFunction resolvedFor(const PictureOptions& picture, const TransferFunctionChoice& choice,
                             const Manifest& manifest, const std::optional<glm::dvec3>& color) {
  const EngineChoice engine = engineOf(picture);
  if (manifest.volume_class == VolumeClass::kLabels)
    requireCapability(engine, &EngineCapabilities::labels, "--mode: a volume of labels needs", "leave --mode out");
  const auto* const name = std::get_if<std::string>(&choice);
  const bool projected = !engine.capabilities().composites && name != nullptr;
  if (!projected || (*name != "auto" && (!isStretched(*name) || picture.window))) {
    TransferFunction function = resolve(choice, picture.window, manifest);
    requireSurfaces(engine, function);
    return function;
  }
  const ValueRange range = projectionRange(manifest, picture.mode, shownShare(manifest.geometry(), picture.clipping));
  if (*name != "auto") return resolve(choice, Window{std::midpoint(range.lo, range.hi), range.hi - range.lo}, manifest);
  return resolve(displayRamp(manifest, range, color), picture.window, manifest);
}

ShownFunction shownFunction(const std::filesystem::path& file, const TransferFunction& function,
                            const Manifest& manifest) {
  ShownFunction out{volumeNameOf(file), function, manifest.range};
  if (const auto counted = labelsOf(manifest)) {
    out.labels.emplace();
    for (const LabelCount& label : *counted) out.labels->push_back(label.label);
  }
  return out;
}

namespace {

// Colours of channels whose store declares none, as napari gives them: two, three, or more in turn.
glm::dvec3 paletteColor(std::size_t channel, std::size_t channels) {
  constexpr glm::dvec3 kRed(1, 0, 0), kGreen(0, 1, 0), kBlue(0, 0, 1), kCyan(0, 1, 1), kYellow(1, 1, 0),
      kMagenta(1, 0, 1);
  static const std::array<glm::dvec3, 2> kTwo = {kMagenta, kGreen};
  static const std::array<glm::dvec3, 3> kThree = {kRed, kGreen, kBlue};
  static const std::array<glm::dvec3, 6> kMore = {kCyan, kYellow, kMagenta, kRed, kGreen, kBlue};
  return channels == 2 ? kTwo[channel] : channels == 3 ? kThree[channel] : kMore[channel % kMore.size()];
}

// The colour of a channel with an automatic function; nothing for the colour of its own look.
std::optional<glm::dvec3> channelColor(const RenderJob& job, std::size_t channel, const Manifest& manifest) {
  const std::vector<glm::dvec3>& colors = job.picture.channel_colors;
  if (channel < colors.size()) return colors[channel];
  if (job.volumes.size() < 2 || manifest.look.ramp) return std::nullopt;
  return paletteColor(channel, job.volumes.size());
}

VolumeGeometry boxOfAll(const std::vector<const Manifest*>& manifests) {
  std::vector<VolumeGeometry> volumes;
  for (const Manifest* const manifest : manifests) volumes.push_back(manifest->geometry());
  return boxAround(volumes);
}

// Opaque where a projection is brighter than its background, the colour of the least value: by 8 of 255 steps.
TransferFunction brighterThanBackground(const ValueRange& window) {
  const double value = std::lerp(window.lo, window.hi, 1.0 / 32);
  return {0, {{value, glm::dvec3(1), 0}, {value, glm::dvec3(1), 1}}};
}

// The rule of thumb of stereo photography, "one over 30", there of the nearest object (Brewster's formula in Wattie,
// Stereo Base Formulae). Two digits are enough for a rule.
std::string usualInterocular(double depth) {
  const double exact = depth / 30, step = std::pow(10.0, std::floor(std::log10(exact)) - 1);
  return fmt::format("{:.6g}", std::round(exact / step) * step);
}

std::string unitOf(const VolumeGeometry& volume) {
  return volume.unit.empty() ? "world units" : shownUnit(volume.unit);
}

// The texts of placeholders, in their order.
PlaceholderTexts textsOfFrame(const RenderJob& job, int frame, const Manifest& manifest) {
  const double time_s = (frame - 1) / job.output.video.rate.perSecond();
  const Extent3& dims = manifest.geometry().dims;
  const ValueRange& range = manifest.range;
  const double step = isFloating(manifest.type) ? (range.hi - range.lo) / 1000 : 1;
  return {fmt::format("{}", frame),
          fmt::format("{:.2f}", time_s),
          volumeNameOf(job.volume),
          unitOf(manifest.geometry()),
          numberText(range.lo, step),
          numberText(range.hi, step),
          fmt::format("{} × {} × {}", dims.x, dims.y, dims.z)};
}

// Returns edges that leave free what either leaves free.
FreeEdges around(const FreeEdges& a, const FreeEdges& b) {
  return {std::max(a.left, b.left), std::max(a.right, b.right), std::max(a.top, b.top), std::max(a.bottom, b.bottom)};
}

// Choices that both pictures have, rows or columns, each wide enough for both; without a common choice, rows and
// columns. A picture without choices has no legend.
std::vector<FreeEdges> commonEdges(const std::vector<FreeEdges>& a, const std::vector<FreeEdges>& b) {
  if (a.empty() || b.empty()) return a.empty() ? b : a;
  const auto areRows = [](const FreeEdges& edges) { return edges.top > 0 || edges.bottom > 0; };
  std::vector<FreeEdges> out;
  for (const FreeEdges& of_a : a) {
    for (const FreeEdges& of_b : b) {
      if (areRows(of_a) == areRows(of_b)) out.push_back(around(of_a, of_b));
    }
  }
  if (out.empty()) out.push_back(around(a.front(), b.front()));
  return out;
}

Clipping withPlanes(Clipping clipping, const std::vector<ClipPlane>& planes) {
  clipping.planes.insert(clipping.planes.end(), planes.begin(), planes.end());
  return clipping;
}

std::vector<const Manifest*> looksOf(const RenderJob& job, const std::vector<const Manifest*>& manifests) {
  if (!job.series) return manifests;
  std::vector<const Manifest*> out;
  for (const Manifest& look : job.series->volumes) out.push_back(&look);
  for (std::size_t i = 0; i < manifests.size(); ++i) {
    const bool labels = manifests[i]->volume_class == VolumeClass::kLabels;
    if (labels != (out.at(i)->volume_class == VolumeClass::kLabels))
      throw Error(ErrorCode::kUsage,
                  fmt::format("a time series: this frame's volume holds {}, and its first frame's {}; "
                              "convert all with --labels, or none",
                              labels ? "labels" : "amounts", labels ? "amounts" : "labels"));
  }
  return out;
}

}  // namespace

void SceneOfJob::requireInterocular() const {
  if (!lacksInterocular(job_)) return;
  const std::optional<Stereo>& stereo = job_.picture.stereo;
  const Camera camera = cameraOf(framesOf(job_).front());
  resolve(camera, stereo, job_.picture.size);  // refuses cameras without a pair
  const double depth = stereo->convergence.value_or(glm::distance(camera.eye, camera.target));
  throw Error(
      ErrorCode::kUsage,
      fmt::format("--stereo: needs --interocular, the distance between both eyes; one thirtieth of the depth at "
                  "which both views agree is usual, here --interocular {} ({})",
                  usualInterocular(depth), unitOf(geometry_)));
}

SceneOfJob::SceneOfJob(const RenderJob& job, std::vector<const Manifest*> manifests, const SceneInputs& inputs,
                       const Progress& progress)
    : job_(job),
      manifests_(std::move(manifests)),
      looks_(looksOf(job, manifests_)),
      geometry_(boxOfAll(looks_)),
      companions_(inputs.companions),
      colors_(inputs.colors),
      framed_(geometry_) {
  requireWorldBox(job.picture.clipping, geometry_);
  for (std::size_t i = 0; i < job.volumes.size(); ++i) requireWorldBox(job.volumes[i].clipping, looks_[i]->geometry());
  PictureOptions still = job.picture;
  const auto add = [&](const std::vector<Key<TransferFunctionChoice>>& keys, const TransferFunctionChoice& choice,
                       const Manifest& manifest, const std::optional<glm::dvec3>& color) {
    Functions out{&keys, {}};
    for (const auto& key : keys) {
      progress.throwIfCancelled("preparing the transfer function");
      out.values.push_back(resolvedFor(still, key.value, manifest, color));
    }
    if (keys.empty()) out.values.push_back(resolvedFor(still, choice, manifest, color));
    requireSurfacesInAllOrNone(out.values);
    requireFewRegions(out.values);
    functions_.push_back(std::move(out));
  };
  if (job.volumes.empty()) add(job.animation.functions, still.transfer_function, *looks_.front(), {});
  for (std::size_t i = 0; i < job.volumes.size(); ++i) {
    const VolumeOptions& volume = job.volumes[i];
    still.window = volume.window;
    still.clipping = clippingOf(i);
    add(volume.functions, volume.transfer_function, *looks_[i], channelColor(job, i, *looks_[i]));
  }
  framed_ = framedBox(inputs.shown_box);
  if (inputs.free_edges) framed_.free_edges = freeEdges(inputs.free_edges);
  requireInterocular();
}

// Planes that move are left out: the box is the same in all frames.
Clipping SceneOfJob::clippingOf(std::size_t volume) const {
  const Clipping& common = job_.picture.clipping;
  return job_.volumes.empty() ? common : withPlanes(job_.volumes[volume].clipping, common.planes);
}

// The outline of the volume is part of what is seen.
Fit SceneOfJob::fit() const {
  return job_.picture.fit.value_or(job_.picture.annotations.box ? Fit::kRegion : Fit::kVisible);
}

// The functions that say what a camera fits; none if that is the whole region.
std::vector<TransferFunction> SceneOfJob::fittedFunctions(std::size_t volume) const {
  const std::vector<TransferFunction>& functions = functions_[volume].values;
  if (engineOf(job_).capabilities().composites) return functions;
  // Minima are those of the air around, and a background of the job's own shows the border of the region.
  if (job_.picture.mode == Mode::kMinip || job_.picture.background) return {};
  std::vector<TransferFunction> out;
  for (const TransferFunction& function : functions) {
    if (function.points.empty()) return {};
    out.push_back(brighterThanBackground({function.points.front().value, function.points.back().value}));
  }
  return out;
}

FramedBox SceneOfJob::framedBox(const ShownBoxOf& shown_box) const {
  const Fit fit = this->fit();
  if (fit == Fit::kBox || job_.series || !isFramed(job_.animation.camera, job_.picture.camera)) return geometry_;
  std::vector<VolumeGeometry> boxes;
  std::vector<glm::dvec3> outline;
  for (std::size_t i = 0; i < manifests_.size(); ++i) {
    const VolumeGeometry volume = manifests_[i]->geometry();
    const Clipping clipping = clippingOf(i);
    const std::vector<TransferFunction> functions =
        fit == Fit::kVisible && shown_box ? fittedFunctions(i) : std::vector<TransferFunction>();
    const FramedBox box =
        functions.empty() ? FramedBox(partOf(volume, boxOfClip(volume, clipping))) : shown_box(i, functions, clipping);
    if (box.volume.dims.count() == 0) continue;
    boxes.push_back(box.volume);
    outline.insert(outline.end(), box.outline.begin(), box.outline.end());
  }
  return boxes.empty() ? FramedBox(geometry_) : FramedBox(boxAround(boxes), std::move(outline), fit);
}

// All frames of a film have equal edges, so that nothing jumps. The edges hold the legends of all keys, and the legends
// half way between two keys, where the functions of both show.
std::vector<FreeEdges> SceneOfJob::freeEdges(const FreeEdgesOf& free_edges) const {
  const CameraSpec& still = job_.picture.camera;
  if (!job_.picture.annotations.legend || !still.leavesEdges() || !isFramed(job_.animation.camera, still)) return {};
  std::vector<int> frames;
  for (const Functions& functions : functions_) {
    double before = functions.keys->empty() ? 1 : functions.keys->front().frame;
    if (functions.keys->empty()) frames.push_back(1);
    for (const Key<TransferFunctionChoice>& key : *functions.keys) {
      for (const double frame : {std::midpoint(before, key.frame), key.frame})
        frames.push_back(static_cast<int>(std::lround(frame)));
      before = key.frame;
    }
  }
  std::ranges::sort(frames);
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  std::vector<FreeEdges> out;
  for (const int frame : frames) {
    FrameScene scene = unframed(frame);
    scene.picture.annotations.text = filledIn(job_.picture.annotations.text, {});
    scene.shown = shownIn(scene, looks_);
    // The name of a series' file is another in each frame.
    if (job_.series) {
      for (ShownFunction& shown : scene.shown) shown.name.clear();
    }
    out = commonEdges(out, free_edges(scene));
  }
  return out;
}

TransferFunction SceneOfJob::Functions::at(int frame) const {
  if (values.size() == 1) return values.front();
  const auto [i, t] = mixAt(KeyTimes(*keys), frame);
  return faded(values[i], values[i + 1], t);
}

std::uint64_t SceneOfJob::functionBytes() const {
  // Measured: the JSON of a header's text takes most of an entry's memory.
  constexpr std::uint64_t kOfEntry = 2048, kOfNameByte = 16, kOfNode = 256;
  // The grid that kernels look up instead of regions.
  constexpr std::uint64_t kOfGrid = 6u << 20;
  std::uint64_t out = 0;
  const auto add = [&](const TransferFunction& function) {
    out += kOfEntry * (function.points.size() + function.gradient_opacity.size() + function.regions.size() +
                       function.labels.size() + function.surfaces.size());
    out += kOfNode * function.table.opacity.size() + (function.regions.empty() ? 0 : kOfGrid);
    for (const LabelStyle& style : function.labels) out += kOfNameByte * style.name.size();
  };
  for (const Functions& of_volume : functions_) std::ranges::for_each(of_volume.values, add);
  for (const std::optional<ShownFunction>& colors : colors_) {
    if (colors) add(colors->function);
  }
  return out;
}

Camera SceneOfJob::cameraOf(int frame) const {
  return cameraAt(job_.animation.camera, job_.picture.camera, frame, framed_, job_.picture.size);
}

int SceneOfJob::samplesOf(const Camera& camera) const {
  if (job_.picture.samples) return *job_.picture.samples;
  return automaticSamples(job_, camera, centreOf(framed_.volume), manifests_);
}

int SceneOfJob::mostSamples(const Progress& progress) const {
  if (job_.picture.samples) return *job_.picture.samples;
  std::vector<int> frames = framesOf(job_);
  if (std::holds_alternative<std::monostate>(job_.animation.camera)) frames.resize(1);
  int most = 1;
  for (const int frame : frames) {
    progress.throwIfCancelled("counting samples");
    try {
      most = std::max(most, samplesOf(cameraOf(frame)));
    } catch (const Error&) {
      // Drawing the frame reports the error, with the frame's number.
    }
  }
  return most;
}

std::vector<ShownFunction> SceneOfJob::shownIn(const FrameScene& scene,
                                               const std::vector<const Manifest*>& manifests) const {
  std::vector<ShownFunction> out;
  const bool single = job_.volumes.empty();
  for (std::size_t i = 0; i < manifests.size(); ++i) {
    const std::filesystem::path& volume = single ? job_.volume : job_.volumes[i].volume;
    ShownFunction shown =
        shownFunction(volume, single ? scene.transfer_function : scene.volumes[i].transfer_function, *manifests[i]);
    const std::string of_section = single ? "section" : shown.name + ", section";
    const bool own = i >= colors_.size() || !colors_[i];
    out.push_back(own ? std::move(shown) : *colors_[i]);
    const Clipping& clipping = single ? scene.picture.clipping : scene.volumes[i].clipping;
    if (clipping.section && clipping.section->window) out.push_back({of_section, functionOf(*clipping.section), {}});
  }
  return out;
}

FrameScene SceneOfJob::at(int frame) const {
  FrameScene out = unframed(frame);
  if (out.picture.annotations.legend) out.shown = shownIn(out, manifests_);
  out.camera = cameraOf(frame);
  out.picture.samples = samplesOf(out.camera);
  return out;
}

FrameScene SceneOfJob::unframed(int frame) const {
  const Animation& animation = job_.animation;
  FrameScene out{job_.picture, {}, functions_.front().at(frame), companions_, {}, geometry_, {}};
  out.masked = job_.companions.mask || std::ranges::any_of(job_.volumes, [](const VolumeOptions& volume) {
                 return volume.companions.mask.has_value();
               });
  out.colors = colors_;
  if (const auto part = std::exchange(out.picture.part, std::nullopt))
    out.picture.clipping.part = boxOfPart(*part, manifest().geometry().dims, manifest().brick_size);
  out.picture.background = backgroundOf(out.picture, out.transfer_function);
  const auto between = [&](const auto& keys) {
    const auto [i, t] = mixAt(KeyTimes(keys), frame);
    if (t == 0 || t == 1) return keys[t == 0 ? i : i + 1].value;
    return mixed(keys[i].value, keys[i + 1].value, t);
  };
  if (!out.picture.annotations.text.empty())
    out.picture.annotations.text = filledIn(job_.picture.annotations.text, textsOfFrame(job_, frame, manifest()));
  if (!animation.lights.empty()) out.picture.shading.lights = between(animation.lights);
  if (!animation.stereo.empty()) {
    const StereoEye eye = out.picture.stereo->eye;
    out.picture.stereo = between(animation.stereo);
    out.picture.stereo->eye = eye;
  }
  if (!animation.clip.empty()) out.picture.clipping = withPlanes(out.picture.clipping, between(animation.clip));
  if (auto& section = out.picture.clipping.section)
    section = resolved(*section, *looks_.front(), out.transfer_function);
  for (std::size_t i = 0; i < job_.volumes.size(); ++i) {
    const VolumeOptions& volume = job_.volumes[i];
    VolumeScene scene{functions_[i].at(frame), volume.shading.value_or(out.picture.shading),
                      withPlanes(volume.clipping, out.picture.clipping.planes), manifests_[i]->world_per_own,
                      manifests_[i]->index_checksum};
    scene.shading.lights = out.picture.shading.lights;
    if (auto& section = scene.clipping.section) section = resolved(*section, *looks_[i], scene.transfer_function);
    out.volumes.push_back(std::move(scene));
  }
  return out;
}

}  // namespace kiln

// The options of a job, in the order of the resolved job, and their flags.
#include "job/job_options.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "image/named_color.h"
#include "ingest/source/formats.h"
#include "job/job_animation.h"
#include "job/job_facts.h"
#include "job/job_names.h"
#include "job/job_parts.h"
#include "job/json/points_text.h"
#include "job/look.h"
#include "job/quality.h"
#include "job/stated_job.h"
#include "scene/sampling.h"
#include "scene/scene_limits.h"
#include "scene/transfer/label_styles.h"
#include "scene/transfer/presets.h"

namespace kiln {
namespace {

using JobRow = Option<RenderJob>;

using enum OptionGroup;

using nlohmann::json;
using nlohmann::ordered_json;

bool ofQuadtree(const RenderJob& job) { return job.speed.visibility.method == VisibilityMethod::kQuadtree; }
bool ofOneVolume(const RenderJob& job) { return job.volumes.empty(); }

// An option with a reader of its own. `schema` is all that the schema states about its values.
template <class Read>
OptionValue<RenderJob> custom(ordered_json schema, Read read) {
  OptionForm form;
  form.schema = std::move(schema);
  return OptionValue<RenderJob>::custom(
      std::move(form), [read](const JobObject& object, std::string_view, RenderJob& job) { read(object, job); });
}

OptionForm functionForm() {
  OptionForm form;
  form.schema["anyOf"] = {{{"$ref", "text"}}, {{"$ref", "transferFunction"}}, {{"$ref", "functionKeyframes"}}};
  form.value_name = "PRESET|POINTS|FILE[#NAME]";
  form.words.assign(presetNames().begin(), presetNames().end());
  // A text with a dot or a slash is a file.
  form.parse = [](const std::string& text) -> json {
    const bool complete = isPreset(text) || isPointsText(text) || text.find_first_of("./") != std::string::npos;
    return complete ? text : "./" + text;
  };
  return form;
}

ordered_json listSchema(const ordered_json& items, std::size_t least, std::size_t most) {
  return {{"type", "array"}, {"items", items}, {"minItems", least}, {"maxItems", most}};
}

ordered_json matricesSchema() {
  return listSchema(listSchema(listSchema({{"$ref", "length"}}, 4, 4), 4, 4), 1, kMostMatrices);
}

constexpr std::string_view kRegionHelp = "Show this box of voxels only; X0 is inside, X1 outside.";
constexpr std::string_view kWorldRegionHelp = "Show this box of the world only.";
constexpr std::string_view kWindowHelp =
    "Stretch the transfer function so that its first and last points lie at the ends of this window of values.";
constexpr std::string_view kFunctionHelp =
    "Transfer function: a preset, points VALUE:OPACITY[:COLOR],... in order of their values, or a file of Kiln's, of "
    "ParaView's colour maps (FILE or FILE#NAME) or of labels (ITK-SNAP's, FreeSurfer's, names). "
    "iso:VALUE[:OPACITY[:COLOR]],... is a "
    "preset, too: surfaces at these values. solid:VALUE is solid from VALUE on.";

constexpr std::string_view kSectionHelp =
    "Cut faces, where the view enters the volume through --clip, --region or --world-region, show the values there, "
    "without light: in the colours of the transfer function (tf), or a window of values in grey or in the colours of "
    "a map.";

constexpr std::string_view kMaskHelp =
    "Show the volume only where another volume, at the same place in the world, has one of these labels.";
constexpr std::string_view kColorByHelp =
    "Colour the volume by the values of another volume at the same place in the world, such as a PET on a CT. Opacity "
    "stays the volume's own.";

// "LABEL,FIRST-LAST,..."; null if the text is anything else, or lists too many labels.
json labelsOfText(std::string_view text) {
  json out = json::array();
  for (const std::string_view part : splitAt(text, ',')) {
    const std::size_t dash = part.find('-', 1);  // a sign is no dash
    const auto first = decimalOf<std::int64_t>(part.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : decimalOf<std::int64_t>(part.substr(dash + 1));
    if (!first || !last || *last < *first) return {};
    if (static_cast<double>(*last) > kLargestLabel || static_cast<double>(*first) < -kLargestLabel) return {};
    if (static_cast<std::uint64_t>(*last - *first) >= kMostMaskLabels - out.size()) return {};
    for (std::int64_t label = *first; label <= *last; ++label) out.push_back(label);
  }
  return out;
}

// "STORE:LABELS".
void putMaskText(OptionForm& form) {
  form.value_name = "FILE:LABELS";
  form.expected = "the file of a volume of labels, a colon, and its labels that show, such as organs.kiln:3,7,10-19";
  form.parse = [](const std::string& text) -> json {
    const std::size_t colon = text.rfind(':');
    if (colon == std::string::npos || colon == 0) return {};
    const json labels = labelsOfText(std::string_view(text).substr(colon + 1));
    if (labels.is_null()) return {};
    return {{"volume", text.substr(0, colon)}, {"labels", labels}};
  };
}

// Returns the length of the file's name in "FILE[:TF]": of a computed volume, else of the shortest beginning that is on
// the disk, else of the text before the first colon.
std::size_t lengthOfFile(const std::string& text) {
  const std::size_t first = text.find(':');
  const auto next = [&](std::size_t colon) { return colon == std::string::npos ? colon : text.find(':', colon + 1); };
  if (namesPhantom(text)) return next(next(first));
  for (std::size_t colon = first;; colon = next(colon)) {
    std::error_code ignored;
    if (std::filesystem::exists(text.substr(0, colon), ignored)) return colon;
    if (colon == std::string::npos) return first;
  }
}

// "FILE[:TF]".
void putColorByText(OptionForm& form) {
  form.value_name = "FILE[:TF]";
  form.expected = "the file of a volume, and after a colon its transfer function, such as pet.kiln:fire";
  form.parse = [](const std::string& text) -> json {
    const std::size_t colon = lengthOfFile(text);
    if (colon == 0 || text.empty()) return {};
    json out = {{"volume", text.substr(0, colon)}};
    if (colon != std::string::npos) out["transferFunction"] = functionForm().parse(text.substr(colon + 1));
    return out;
  };
}

template <class Owner>
OptionValue<Owner> maskValue() {
  return objectValue("mask", optionsIn<Owner>(maskOptions(), KILN_MEMBER(companions.mask)));
}
template <class Owner>
OptionValue<Owner> colorByValue() {
  return objectValue("colorBy", optionsIn<Owner>(colorByOptions(), KILN_MEMBER(companions.color_by)));
}

template <class Owner, class Member>
OptionValue<Owner> sectionValue(Member member) {
  OptionValue<Owner> out = objectValue("section", optionsIn<Owner>(sectionOptions(), member));
  out.form = sectionForm();
  out.read = [member](const JobObject& object, std::string_view key, Owner& owner) {
    readSection(object, key, member(owner));
  };
  return out;
}

OptionForm channelColorsForm() {
  OptionForm form;
  form.schema = listSchema({{"$ref", "colorName"}}, 1, kMostVolumesOfJob);
  form.value_name = "COLOR:COLOR:...";
  form.expected = "names, #rgb or #rrggbb of colours, separated by colons, such as magenta:#0f0";
  form.parse = [](const std::string& text) -> json {
    json out = json::array();
    for (const std::string_view part : splitAt(text, ':')) {
      if (!colorNamed(std::string(part))) return {};
      out.push_back(part);
    }
    return out;
  };
  return form;
}

void readChannelColors(const JobObject& root, std::string_view key, PictureOptions& picture) {
  constexpr std::string_view kExpected = "a list of names, #rgb or #rrggbb of colours";
  picture.channel_colors.clear();
  const std::vector<std::string> texts = *root.texts(key, kExpected);
  for (const std::string& text : texts) {
    const std::optional<glm::dvec3> color = colorNamed(text);
    if (!color || picture.channel_colors.size() == kMostVolumesOfJob) root.refuse(key, kExpected);
    picture.channel_colors.push_back(*color);
  }
  if (picture.channel_colors.empty()) root.refuse(key, kExpected);
}

OptionForm sizeForm() {
  OptionForm form;
  form.value_name = "WIDTHxHEIGHT";
  form.expected = fmt::format("WIDTHxHEIGHT, each side from 1 to {} pixels", kLargestSide_px);
  form.parse = [](const std::string& text) -> json {
    const json sides = numbersOfText(text, text.find('x') != std::string::npos ? 'x' : ',');
    if (sides.size() != 2) return {};
    return {{"width", sides[0]}, {"height", sides[1]}};
  };
  return form;
}

Options<RenderJob> imageOptions() {
  return {
      JobRow("", "--size", kOutput, OptionValue<RenderJob>::custom(sizeForm(), nullptr),
             "Width and height in pixels. Default: 1024x1024; of a panorama 2048x1024."),
      JobRow("width", {KILN_MEMBER(picture.size.width), Whole{1, kLargestSide_px, "pixels"}, kAlways},
             "Width of the picture."),
      JobRow("height", {KILN_MEMBER(picture.size.height), Whole{1, kLargestSide_px, "pixels"}, kAlways},
             "Height of the picture."),
      JobRow("background", "--background", kLight, {KILN_MEMBER(picture.background), BackgroundColors{}, kAlways},
             "Background: transparent (default), one colour, or two from top to bottom. A colour is R,G,B in linear "
             "light, a name such as navy, #rgb or #rrggbb. With --mode mip, minip or average the default is the "
             "transfer function's colour for the least value, black in grey."),
      JobRow(
          "crop", "--crop", kOutput, {KILN_MEMBER(picture.crop), PixelBox{}, kAlways},
          "Draw these pixels of the picture only. Each is equal to that of the whole picture, except with --visibility "
          "quadtree."),
      JobRow(
          "aov", "--aov", kOutput, {KILN_MEMBER(picture.aovs), AovList{}, kAlways},
          "Add channels to the EXR: depth (Z, where alpha passes one half, and depth.mean; along the view, infinite "
          "where nothing is seen), normal (N.X, N.Y, N.Z in the world), or value of --mode mip, minip or average (NaN "
          "where there is none)."),
  };
}

Options<RenderJob> stereoObjectOptions() {
  Options<RenderJob> out = optionsIn<RenderJob>(stereoOptions(), KILN_MEMBER(picture.stereo));
  out.push_back(JobRow("keyframes", custom(keyframesSchema("stereoKeyframe"), [](const JobObject&, RenderJob&) {}),
                       "Distances of the eyes at some frames."));
  return out;
}

Options<RenderJob> visibilityOptions() {
  return {
      JobRow("threshold", "--opacity-threshold", kQuality,
             {KILN_MEMBER(picture.opacity_threshold), Number{{0, 1, true}}, kAlways},
             "Alpha at which a pixel takes no more light."),
      JobRow("method", "--visibility", kCost,
             {KILN_MEMBER(speed.visibility.method), Word{kVisibilityNames}, ofQuadtree},
             "Method that finds hidden bricks. All but quadtree give the same picture."),
      JobRow(
          "area", "--projected-area", kCost,
          {KILN_MEMBER(speed.visibility.area), Word{kProjectedAreaNames}, ofQuadtree},
          "Shape whose projection is tested for a node of the octree: its box, the tightest, or its sphere, as by Lee "
          "and Ihm."),
      JobRow("epsilon", "--quadtree-epsilon", kCost,
             {KILN_MEMBER(speed.visibility.epsilon_px), Whole{0, kLargestEpsilon, "pixels"}, ofQuadtree},
             "Enlarge projected areas on every side, for --visibility quadtree."),
      JobRow("samples", "--test-nodes-only", kCost,
             {KILN_MEMBER(speed.visibility.test_samples), WordOfFlag{{kSampleTestNames}, kSampleTestNames[0]}},
             "Test nodes of the octree, and not each sample, as by Lee and Ihm."),
  };
}

Options<RenderJob> exrOptions() {
  return {
      JobRow("type", "--exr-type", kOutput, {KILN_MEMBER(output.exr_float), Word{kExrTypeNames}}, "Numbers of an EXR."),
      JobRow("compression", "--compression", kOutput, {KILN_MEMBER(output.exr_compression), Word{kExrCompressionNames}},
             "Compression of an EXR. dwaa and dwab are lossy."),
      JobRow("owner", "--owner", kOutput, {KILN_MEMBER(output.owner), Text{"a name"}}, "Attribute owner of an EXR."),
      JobRow("comments", "--comments", kOutput, {KILN_MEMBER(output.comments), Text{"a text"}},
             "Attribute comments of an EXR."),
      JobRow("statistics", "--exr-statistics", kOutput, {KILN_MEMBER(output.statistics_in_header), Switch{}},
             "Write the statistics of --stats as attribute kiln:statistics of the EXR."),
      JobRow("deep", "--deep", kOutput, {KILN_MEMBER(output.deep), Switch{}},
             "Write a deep EXR: RGBA, Z and ZBack of each slab, without background, for compositing."),
      JobRow("deepSamples", "--deep-samples", kOutput,
             {KILN_MEMBER(output.deep_bound.samples), Whole{1, DeepBound::kMostSamples, "samples"}},
             "Most deep samples of a pixel; neighbours that differ least are merged."),
      JobRow("deepError", "--deep-error", kOutput, {KILN_MEMBER(output.deep_bound.error), Number{{0, 1}}},
             "Merge neighbouring deep samples while a cut at any depth changes the colour by at most this."),
  };
}

Option<RenderJob> objectRow(std::string_view name, const Options<RenderJob>& inside) {
  return {name, objectValue(name, inside)};
}

// An object with keys that depend on each other.
Option<RenderJob> objectRow(std::string_view name, const Options<RenderJob>& inside,
                            void (*read)(const JobObject& object, RenderJob& job)) {
  Option<RenderJob> out = objectRow(name, inside);
  out.value.read = [read](const JobObject& root, std::string_view key, RenderJob& job) {
    read(*root.object(key), job);
  };
  return out;
}

// A power of two from the least tile's edge on, or 0.
struct TileEdge : WholeChoice {
  TileEdge() : WholeChoice{{0}} {
    for (int edge = kLeastTile_px; edge <= kLargestSide_px; edge *= 2) numbers.push_back(edge);
  }
  OptionForm form() const {
    OptionForm out = WholeChoice::form();
    out.value_name = "PIXELS";
    out.expected = fmt::format("a power of two from {} on, or 0 for the whole frame", kLeastTile_px);
    return out;
  }
  void read(const JobObject& object, std::string_view key, int& out) const {
    out = static_cast<int>(*object.integer(key, 0, kLargestSide_px, "pixels"));
    if (std::ranges::find(numbers, out) == numbers.end()) object.refuse(key, form().expected);
  }
};

// "auto", "auto+N" or the number of a level.
constexpr std::int64_t kMostLevel = 64;

OptionForm levelForm() {
  OptionForm out;
  out.schema = {
      {"anyOf", {{{"type", "string"}, {"pattern", "^auto(\\+[0-9]{1,2})?$"}}, Whole{0, kMostLevel}.form().schema}}};
  out.value_name = "auto|auto+N|N";
  out.expected = fmt::format("auto, auto+N or a whole number from 0 to {}", kMostLevel);
  out.words = {"auto", "auto+1"};
  out.parse = [](const std::string& text) -> json {
    return text.starts_with("auto") ? json(text) : Whole{0, kMostLevel}.form().parse(text);
  };
  return out;
}

void readLevel(const JobObject& root, std::string_view key, PictureOptions& picture) {
  picture.level.reset();
  picture.coarser = 0;
  if (!root.isText(key)) {
    picture.level = static_cast<int>(*root.integer(key, 0, kMostLevel));
    return;
  }
  const std::string expected = levelForm().expected;
  const std::string text = *root.text(key, expected);
  if (text == "auto") return;
  constexpr std::string_view kCoarser = "auto+";
  const std::optional<int> levels =
      text.starts_with(kCoarser) ? numberOf<int>(text.substr(kCoarser.size())) : std::nullopt;
  if (!levels || *levels < 0 || *levels > kMostLevel) root.refuse(key, expected);
  picture.coarser = *levels;
}

ordered_json levelJson(const PictureOptions& picture) {
  if (picture.level) return *picture.level;
  return picture.coarser == 0 ? "auto" : fmt::format("auto+{}", picture.coarser);
}

// Sets the options that a quality stands for.
void readQuality(const JobObject& root, std::string_view key, RenderJob& job) {
  job.quality = static_cast<Quality>(*root.choice(key, kQualityNames));
  setQuality(*job.quality, job.picture);
}

// Sets the options that a look stands for.
void readLook(const JobObject& root, std::string_view key, RenderJob& job) {
  setLook(static_cast<Look>(*root.choice(key, kLookNames)), job.picture);
  job.animation.lights.clear();
}

Options<RenderJob> displayOptions() {
  return {
      JobRow(
          "exposure", "--exposure", kLight,
          {KILN_MEMBER(picture.display.exposure), Number{{-20, 20}, "stops"},
           [](const RenderJob& job) { return job.picture.display.exposure != 0; }},
          "Exposure of the volume's light in PNG and video: 1 doubles the light. The background keeps its colour, and "
          "an EXR its light."),
      JobRow("tone", "--tone", kLight,
             {KILN_MEMBER(picture.display.tone), Word{kToneNames},
              [](const RenderJob& job) { return job.picture.display.tone != Tone::kClip; }},
             "Light beyond white in PNG and video. clip: white, channel by channel. soft: bright colours keep their "
             "hue and stay below white. An EXR keeps its light."),
  };
}

void addVolumes(Options<RenderJob>& out) {
  out.push_back(JobRow("kiln", formatValue<RenderJob>().resolvedIf(kAlways), "Version of the job format.",
                       "add \"kiln\": 2, the version of the job format"));
  out.push_back(JobRow(
      "$schema",
      custom({{"type", "string"}}, [](const JobObject& root, const RenderJob&) { root.text("$schema", "an address"); }),
      "Address of this schema, which editors read; no effect on the picture."));
  OptionValue<RenderJob> volumes = custom(volumeList().form().schema, readVolumes);
  volumes.write = [](const RenderJob& job) {
    ordered_json list = ordered_json::array();
    for (const VolumeOptions& volume : job.volumes) list.push_back(resolvedJson(volumeOptions(), volume));
    return list;
  };
  out.push_back(JobRow("volumes", std::move(volumes).resolvedIf([](const RenderJob& job) { return !ofOneVolume(job); }),
                       "Several volumes in one picture, each placed by its own affine; instead of volume."));
  out.push_back(JobRow("volume", {KILN_MEMBER(volume), FileName{}, ofOneVolume},
                       "A store, or a volume file that is converted to a store beside it first."));
  OptionValue<RenderJob> mask = maskValue<RenderJob>(), color_by = colorByValue<RenderJob>();
  putMaskText(mask.form), putColorByText(color_by.form);
  out.push_back(JobRow("mask", "--mask", kShown, std::move(mask), kMaskHelp));
  out.push_back(JobRow("colorBy", "--color-by", kTransferFunction, std::move(color_by), kColorByHelp));
}

void addFiles(Options<RenderJob>& out) {
  OptionValue<RenderJob> output = {KILN_MEMBER(output.path), FileName{}};
  output.read = [](const JobObject& root, std::string_view key, RenderJob& job) {
    std::filesystem::path path;
    FileName{}.read(root, key, path);
    job.output.path.clear();
    job.output.video.path.clear();
    job.output.files.clear();
    putOutput(path, job.output);
  };
  out.push_back(JobRow(
      "output", "-o,--output", kOutput, std::move(output),
      "Picture to write, .exr, .png, .tif (16 bits) or .jpg, or video, .mp4, .mov, .mkv or .webm (made by ffmpeg). "
      "In the name of a picture a run of # becomes the frame's number. - is a PNG on standard output, and -.exr an "
      "EXR."));
  static const ListOf<OutputFile> kFiles{.options = outputFileOptions(),
                                         .name = "output",
                                         .limit = {kMostOutputs, "files"},
                                         .expected = "a list of files [{path, content}, …]"};
  out.push_back(JobRow("outputs", {KILN_MEMBER(output.files), kFiles}, "More files of each frame."));
  out.push_back(objectRow("video", {JobRow("rate", "--rate", kFrames, {KILN_MEMBER(output.video.rate), Rate{}},
                                           "Frames a second of a video, such as 25, 23.976 or 24000/1001.")}));
  OptionValue<RenderJob> frames = custom(
      {{"type", "string"}, {"pattern", "^ *[0-9]+(-[0-9]+)?(x[0-9]+)?(, *[0-9]+(-[0-9]+)?(x[0-9]+)?)*$"}}, readFrames);
  frames.form.value_name = "FRAMES";
  frames.form.parse = [](const std::string& text) -> json { return text; };
  out.push_back(
      JobRow("frames", "--frames", kFrames, std::move(frames), "Draw these frames: 7, 1-100, 1-100x2 or 1-10,20."));
  out.push_back(objectRow("image", imageOptions()));
}

void addValues(Options<RenderJob>& out) {
  out.push_back(JobRow(
      "mode", "--mode", kQuality,
      {KILN_MEMBER(picture.mode), Word{kModeNames},
       [](const RenderJob& job) { return job.picture.mode != Mode::kComposite; }},
      "Value of a pixel: the light of the volume (composite), or the greatest, least or mean value along the ray, "
      "in the colours of the transfer function (grey without --tf). attenuated-mip: the greatest value, each "
      "weakened by the values in front of it. Several volumes are projected each in its own colour, and added."));
  out.push_back(JobRow(
      "attenuation", "--attenuation", kQuality,
      {KILN_MEMBER(picture.attenuation), Number{{0, 1e6}},
       [](const RenderJob& job) { return job.picture.mode == Mode::kAttenuatedMip; }},
      "With --mode attenuated-mip: the weight of a value falls by exp(-ATTENUATION) behind a voxel of the greatest "
      "value."));
  OptionValue<RenderJob> colors = OptionValue<RenderJob>::custom(
      channelColorsForm(),
      [](const JobObject& root, std::string_view key, RenderJob& job) { readChannelColors(root, key, job.picture); },
      [](const RenderJob& job) -> ordered_json {
        if (job.picture.channel_colors.empty()) return nullptr;
        ordered_json texts = ordered_json::array();
        for (const glm::dvec3& color : job.picture.channel_colors) texts.push_back(hexText(color));
        return texts;
      });
  out.push_back(
      JobRow("channelColors", "--channel-colors", kTransferFunction,
             std::move(colors).resolvedIf([](const RenderJob& job) { return !job.picture.channel_colors.empty(); }),
             "With --mode mip, minip, average or attenuated-mip of several volumes: colours of the volumes without a "
             "transfer function, in their order, separated by colons."));
}

void addCamera(Options<RenderJob>& out) {
  out.push_back(objectRow("camera", cameraObjectOptions(), readCamera));
  out.push_back(objectRow("stereo", stereoObjectOptions(), readStereo));
  out.push_back(objectRow("lens", optionsIn<RenderJob>(lensOptions(), KILN_MEMBER(picture.lens))));
}

// Colours of values, and light.
void addColors(Options<RenderJob>& out) {
  out.push_back(JobRow("transferFunction", "--tf", kTransferFunction,
                       OptionValue<RenderJob>::custom(
                           functionForm(),
                           [](const JobObject& root, std::string_view, RenderJob& job) {
                             readTransferFunction(root, job.picture.transfer_function, job.animation.functions);
                           },
                           [](const RenderJob& job) { return statedJson(job.picture.transfer_function); })
                           .resolvedIf(ofOneVolume),
                       kFunctionHelp));
  out.push_back(
      JobRow("window", "--window", kTransferFunction, {KILN_MEMBER(picture.window), ValueWindow{}}, kWindowHelp));
  out.push_back(JobRow(
      "look", "--look", kLight, OptionValue<RenderJob>::custom(Word{kLookNames}.form(), readLook),
      "Several options in one word; options beside it win. plain: the defaults. studio: three lights that move with "
      "the camera, of which the key casts shadows, ambient occlusion and --tone soft."));
  out.push_back(objectRow("display", displayOptions()));
  out.push_back(objectRow("shading", optionsIn<RenderJob>(shadingOptions(), KILN_MEMBER(picture.shading))));
  OptionValue<RenderJob> lights = {KILN_MEMBER(picture.shading.lights), lightList()};
  lights.form.schema = {{"anyOf", {lights.form.schema, {{"$ref", "lightsKeyframes"}}}}};
  lights.read = [](const JobObject& root, std::string_view, RenderJob& job) { readLights(root, job); };
  out.push_back(
      JobRow("lights", "--light", kLight, std::move(lights).resolvedIf(kAlways),
             "Add a light: headlight (default), dir:x,y,z for the direction towards a far light, cam:x,y,z for a far "
             "light that moves with the camera (right, up, towards the eye), or point:x,y,z; each may "
             "end in :COLOR, r,g,b in linear light, a name, #rgb or #rrggbb. Repeatable."));
}

void addShown(Options<RenderJob>& out) {
  out.push_back(JobRow("region", "--region", kShown, {KILN_MEMBER(picture.clipping.region), VoxelBounds{}, kAlways},
                       kRegionHelp));
  out.push_back(JobRow("worldRegion", "--world-region", kShown, {KILN_MEMBER(picture.clipping), WorldBounds{}},
                       kWorldRegionHelp));
  OptionForm part;
  part.schema["anyOf"] = {{{"type", "string"}, {"pattern", "^[0-9]+/[0-9]+$"}}, VoxelBounds{}.form().schema};
  part.value_name = "I/N|X0,Y0,Z0,X1,Y1,Z1";
  part.expected = "I/N, I from 1 to N, or x0,y0,z0,x1,y1,z1";
  part.parse = [](const std::string& text) {
    return text.find('/') != std::string::npos ? json(text) : numbersOfText(text);
  };
  out.push_back(JobRow(
      "part", "--part", kRanks,
      OptionValue<RenderJob>::custom(
          std::move(part), [](const JobObject& root, std::string_view, RenderJob& job) { readPart(root, job.picture); },
          [](const RenderJob& job) -> ordered_json {
            if (const auto& number = job.picture.part) return fmt::format("{}/{}", number->index, number->count);
            return VoxelBounds{}.write(job.picture.clipping.part);
          })
          .resolvedIf(kAlways),
      "Draw a partial image for kiln composite: part I of N boxes that fill the volume, or a box of voxels. Unlike "
      "--region, a part cuts nothing."));
  OptionValue<RenderJob> clip = {KILN_MEMBER(picture.clipping.planes), clipPlaneList()};
  clip.form.schema = {{"anyOf", {clip.form.schema, {{"$ref", "clipKeyframes"}}}}};
  clip.read = [](const JobObject& root, std::string_view, RenderJob& job) { readClipPlanes(root, job); };
  out.push_back(JobRow("clip", "--clip", kShown, std::move(clip).resolvedIf([](const RenderJob& job) {
    return !job.picture.clipping.planes.empty();
  }),
                       "Show the half-space nx·x + ny·y + nz·z + d >= 0 of the world. Repeatable."));
  out.push_back(JobRow("section", "--section", kShown, sectionValue<RenderJob>(KILN_MEMBER(picture.clipping.section)),
                       kSectionHelp));
  out.push_back(objectRow("annotations", optionsIn<RenderJob>(annotationOptions(), KILN_MEMBER(picture.annotations))));
}

void addQuality(Options<RenderJob>& out) {
  out.push_back(objectRow("visibility", visibilityOptions()));
  out.push_back(
      JobRow("tile", "--tile", kCost, {KILN_MEMBER(speed.tile_px), TileEdge(), ofQuadtree},
             "Least edge of the tiles that threads draw, a power of two from 64 on; 0 draws the frame as one tile."));
  out.push_back(JobRow(
      "lattice", "--lattice", kQuality, {KILN_MEMBER(picture.lattice), Word{kLatticeNames, kLatticeCount}, kAlways},
      "Positions of samples: on the rays of pixels (pixel; ray is another name), or the voxels themselves, as by "
      "Lee and Ihm."));
  out.push_back(
      JobRow("interpolation", "--interpolation", kQuality,
             {KILN_MEMBER(picture.interpolation), Word{kInterpolationNames},
              [](const RenderJob& job) { return job.picture.lattice == Lattice::kPixel; }},
             "Interpolation between voxels. cubic (B-spline) is smooth and blurs a little; catmull-rom is smooth and "
             "keeps the values of voxels. Both take 2 to 3 times as long as linear; surfaces (iso:) 2.5 to 5 times."));
  OptionValue<RenderJob> quality = OptionValue<RenderJob>::custom(Word{kQualityNames}.form(), readQuality);
  out.push_back(JobRow(
      "quality", "--quality", kQuality, std::move(quality),
      "Several options in one word; options beside it win. draft: a preview, of one ray a pixel, samples one voxel "
      "apart and a level coarser. good: the defaults. best: 16 rays a pixel and samples a quarter of a voxel apart."));
  out.push_back(
      JobRow("sampleDistance", "--sample-distance", kQuality,
             {KILN_MEMBER(picture.sample_distance), Number{{kLeastSampleDistance, kMostSampleDistance}, "voxels"},
              [](const RenderJob& job) { return job.picture.lattice != Lattice::kVoxel; }},
             "Distance between samples along a ray, at least half a pixel. More is faster, less is more faithful."));
  out.push_back(JobRow(
      "level", "--level", kQuality,
      OptionValue<RenderJob>::custom(
          levelForm(),
          [](const JobObject& root, std::string_view key, RenderJob& job) { readLevel(root, key, job.picture); },
          [](const RenderJob& job) { return levelJson(job.picture); })
          .resolvedIf(kAlways),
      "Level of the pyramid; 0 is the finest. auto draws each region with voxels of about a pixel, auto+1 a level "
      "coarser."));
  out.push_back(JobRow(
      "samples", "--samples", kQuality,
      {KILN_MEMBER(picture.samples), WholeChoice{.numbers = {1, 2, 4, 16}, .or_auto = true}, kAlways},
      "Rays of a pixel (sub-pixels with --lattice voxel). auto takes more than one where voxels are small or the "
      "camera moves."));
  out.push_back(JobRow(
      "skipDamaged", "--skip-damaged", kShown,
      {KILN_MEMBER(picture.skip_damaged), Switch{}, [](const RenderJob& job) { return job.picture.skip_damaged; }},
      "Draw bricks that are damaged or missing as empty, warn about each, and succeed."));
}

void addCost(Options<RenderJob>& out) {
  out.push_back(JobRow("memory", "--memory", kCost, {KILN_MEMBER(speed.memory_bytes), Bytes{}},
                       "Most memory for image, index and bricks, and for the conversion of INPUT."));
  out.push_back(JobRow("threads", "--threads", kCost, {KILN_MEMBER(speed.threads), Whole{0, kMostThreads}},
                       "Threads; 0 uses all processors."));
  out.push_back(
      JobRow("trace", "--trace", kCost, {KILN_MEMBER(trace), FileName{}},
             "Write the work of each thread over time, in Chrome's trace format, for Perfetto or chrome://tracing."));
  out.push_back(JobRow(
      "distribute", "--distribute", kRanks, {KILN_MEMBER(distribution), Word{kDistributionNames}},
      "Under mpirun, the ranks share tiles of frames, whole frames, or bricks (each rank draws its own bricks of "
      "every frame). auto takes tiles or frames, whichever reads less."));
  out.push_back(JobRow(
      "shareReads", "--share-reads", kRanks, {KILN_MEMBER(share_reads), Switch{.on_off = true}},
      "Under mpirun, with tiles or frames: one rank reads each brick file and sends it to the ranks that need it. "
      "off: each rank reads for itself, for example from a fast local copy of the store."));
}

void addFileFormats(Options<RenderJob>& out) {
  out.push_back(objectRow("exr", exrOptions()));
  out.push_back(objectRow(
      "png", {JobRow("bits", "--png-bits", kOutput, {KILN_MEMBER(output.png_bits), WholeChoice{.numbers = {8, 16}}},
                     "Bits per channel of a PNG.")}));
  out.push_back(objectRow("jpeg", {JobRow("quality", "--jpeg-quality", kOutput,
                                          {KILN_MEMBER(output.jpeg_quality), Whole{1, 100}}, "Quality of a JPEG.")}));
}

// The order is that of the resolved job and of the manual.
Options<RenderJob> rootOptions() {
  Options<RenderJob> out;
  for (const auto add :
       {addVolumes, addFiles, addValues, addCamera, addColors, addShown, addQuality, addCost, addFileFormats})
    add(out);
  return out;
}

// The legal range and the default, in parentheses.
std::string helpOf(const Option<RenderJob>& option) {
  const OptionForm& form = option.value.form;
  std::string notes = form.limits;
  const ordered_json value = option.value.write ? option.value.write(RenderJob()) : ordered_json();
  std::string otherwise;
  if (value.is_boolean() && !form.words.empty())
    otherwise = value.get<bool>() ? "on" : "off";
  else if (value.is_string() && form.arguments != JobFlag::Arguments::kNone)
    otherwise = value.get<std::string>();
  else if (value.is_number())
    otherwise = fmt::format("{}", value.get<double>());
  if (!otherwise.empty()) notes += (notes.empty() ? "default " : "; default ") + otherwise;
  return std::string(option.help) + (notes.empty() ? "" : " (" + notes + ")");
}

json valueOfTexts(const Option<RenderJob>& option, const std::vector<std::string>& texts) {
  const OptionForm& form = option.value.form;
  if (form.arguments == JobFlag::Arguments::kNone) return form.present;
  json out = json::array();
  for (const std::string& text : texts) {
    const json value = valueOfText(form, text, option.flag);
    if (form.arguments == JobFlag::Arguments::kOne) return value;
    out.insert(out.end(), value.begin(), value.end());
  }
  return out;
}

void addFlags(const Options<RenderJob>& options, std::vector<JobFlag>& out) {
  for (const Option<RenderJob>& option : options) {
    addFlags(option.value.inside, out);
    if (option.flag.empty()) continue;
    const OptionForm& form = option.value.form;
    const auto apply = [&option, &options](const std::vector<std::string>& texts, RenderJob& job) {
      const json value = valueOfTexts(option, texts);
      const FlagText flag{std::string(option.flag), quotedWrongText(option.value.form, texts),
                          option.value.form.expected};
      if (option.key.empty())
        readKnown(options, JobObject::ofFlag(value, flag), job);
      else
        option.value.read(JobObject::ofFlag({{std::string(option.key), value}}, flag), option.key, job);
    };
    JobFlag row{std::string(option.flag), option.group, form.arguments, form.value_name, helpOf(option), form.words,
                form.may_be_empty,        nullptr,      apply};
    if (form.number) row.refusal = [&form](const std::string& text) { return refusalOfText(form, text); };
    out.push_back(std::move(row));
  }
}

}  // namespace

const Options<RenderJob>& cameraObjectOptions() {
  static const Options<RenderJob> kOptions = [] {
    Options<RenderJob> out = optionsIn<RenderJob>(cameraOptions(), KILN_MEMBER(picture.camera));
    out.push_back(JobRow("fit", "--fit", kCamera, {KILN_MEMBER(picture.fit), Word{kFitNames}},
                         "What a camera without --eye fits into the picture: what the transfer function shows after "
                         "clipping (visible), the box of the clipped volume (region), or of the whole volume (box). A "
                         "turntable fits all its frames. Default: visible; with --box, region."));
    OptionValue<RenderJob> turntable = custom({{"$ref", "turntable"}}, [](const JobObject& camera, RenderJob& job) {
      job.animation.camera = turntableFrom(*camera.object("turntable"));
    });
    const OptionForm frames = turntableOptions().front().value.form;
    turntable.form.number = frames.number;
    turntable.form.value_name = frames.value_name;
    turntable.form.expected = frames.expected;
    turntable.form.parse = [frames](const std::string& text) -> json {
      const json number = frames.parse(text);
      return number.is_null() ? number : json{{"frames", number}};
    };
    out.push_back(JobRow("turntable", "--turntable", kFrames, std::move(turntable),
                         "Turn the camera once around its target in this many frames."));
    out.push_back(JobRow(
        "keyframes",
        custom(keyframesSchema("cameraKeyframe"),
               [](const JobObject& camera, RenderJob& job) { job.animation.camera = cameraKeyframesFrom(camera); }),
        "Cameras at some frames."));
    out.push_back(JobRow("pivot",
                         OptionValue<RenderJob>::custom(Word{kPivotNames}.form(),
                                                        // Read with the keyframes.
                                                        [](const JobObject&, std::string_view, RenderJob&) {}),
                         "Between keyframes, the point that the orientation turns around."));
    out.push_back(JobRow("matrices",
                         custom(matricesSchema(), [](const JobObject& camera,
                                                     RenderJob& job) { job.animation.camera = matricesFrom(camera); }),
                         "Camera to world, 4 rows of 4 numbers, for frame 1 and the frames after it."));
    return out;
  }();
  return kOptions;
}

ordered_json keyframesSchema(std::string_view key) { return listSchema({{"$ref", key}}, 1, kMostKeys); }

const ListOf<VolumeOptions>& volumeList() {
  static const ListOf<VolumeOptions> kList{
      .options = volumeOptions(),
      .name = "volume",
      .limit = {kMostVolumesOfJob, "volumes"},
      .expected = "a list of at least one volume [{volume, transferFunction, …}, …]",
      .least = 1};
  return kList;
}

const Options<OutputFile>& outputFileOptions() {
  using Row = Option<OutputFile>;
  static const Options<OutputFile> kOptions = {
      Row("path",
          OptionValue<OutputFile>::custom(FileName{}.form(),
                                          [](const JobObject& object, std::string_view key, OutputFile& file) {
                                            FileName{}.read(object, key, file.path);
                                            if (isVideo(file.path))
                                              object.complain(key, "a video is what \"output\" names");
                                          }),
          "File name; a run of # becomes the frame's number.", "an output has the name of its file"),
      Row("content", {KILN_MEMBER(content), Word{kContentNames}}, "Part of the frame that the file holds."),
  };
  return kOptions;
}

const Options<VolumeOptions>& volumeOptions() {
  using Row = Option<VolumeOptions>;
  static const Options<VolumeOptions> kOptions = [] {
    Options<VolumeOptions> out = {
        Row("volume", {KILN_MEMBER(volume), FileName{}, kAlways}, "A store, or a volume file.",
            "each of several volumes names its store or volume file"),
        Row("labels", {KILN_MEMBER(labels), Switch{}}, "The values of a volume file are labels."),
        Row("mask", maskValue<VolumeOptions>(), kMaskHelp),
        Row("colorBy", colorByValue<VolumeOptions>(), kColorByHelp),
        Row("transferFunction",
            OptionValue<VolumeOptions>::custom(
                functionForm(),
                [](const JobObject& object, std::string_view, VolumeOptions& volume) {
                  readTransferFunction(object, volume.transfer_function, volume.functions);
                },
                [](const VolumeOptions& volume) { return statedJson(volume.transfer_function); })
                .resolvedIf(kAlways),
            kFunctionHelp),
        Row("window", {KILN_MEMBER(window), ValueWindow{}}, kWindowHelp)};
    OptionValue<VolumeOptions> shading =
        objectValue("shading", optionsIn<VolumeOptions>(shadingOptions(), KILN_MEMBER(shading)));
    shading.read = [](const JobObject& object, std::string_view key, VolumeOptions& volume) {
      volume.shading = shadingFrom(*object.object(key));
    };
    out.push_back(Row("shading", std::move(shading)));
    out.push_back(Row("region", {KILN_MEMBER(clipping.region), VoxelBounds{}, kAlways}, kRegionHelp));
    out.push_back(Row("worldRegion", {KILN_MEMBER(clipping), WorldBounds{}}, kWorldRegionHelp));
    OptionValue<VolumeOptions> clip = {KILN_MEMBER(clipping.planes), clipPlaneList()};
    clip.read = [](const JobObject& object, std::string_view, VolumeOptions& volume) {
      replaceClipPlanes(object, volume.clipping);
    };
    out.push_back(Row(
        "clip", std::move(clip).resolvedIf([](const VolumeOptions& volume) { return !volume.clipping.planes.empty(); }),
        "Half-spaces that are shown."));
    out.push_back(Row("section", sectionValue<VolumeOptions>(KILN_MEMBER(clipping.section)), kSectionHelp));
    return out;
  }();
  return kOptions;
}

const Options<RenderJob>& jobOptions() {
  static const Options<RenderJob> kOptions = rootOptions();
  return kOptions;
}

const std::vector<JobFlag>& jobFlags() {
  static const std::vector<JobFlag> kFlags = [] {
    std::vector<JobFlag> out;
    addFlags(jobOptions(), out);
    return out;
  }();
  return kFlags;
}

}  // namespace kiln

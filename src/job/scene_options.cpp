// The options of cameras, lights, clip planes, transfer functions and their keyframes.
#include <fmt/format.h>

#include "base/text.h"
#include "job/camera_file.h"
#include "job/frame_list.h"
#include "job/job_names.h"
#include "job/job_options.h"
#include "job/job_parts.h"
#include "job/option_kinds.h"
#include "scene/scene_limits.h"
#include "scene/transfer/label_styles.h"

namespace kiln {
namespace {

namespace fs = std::filesystem;
using enum OptionGroup;

constexpr SharedRange kFraction{"fraction", {0, 1}}, kWeight{"weight", {0, 1000}}, kBrightness{"brightness", {0, 1e6}};
constexpr SharedRange kLength{"length", {-kLongest, kLongest}}, kPositiveLength{"positiveLength", {0, kLongest, true}};
constexpr NumberRange kVoxelValue{-kLargestValue, kLargestValue};

constexpr auto kSame = [](auto& value) -> auto& { return value; };

OptionForm schemaForm(nlohmann::ordered_json schema) {
  OptionForm out;
  out.schema = std::move(schema);
  return out;
}

// The frame and the passing of a key, beside its value.
template <class T>
Options<Key<T>> keyOptions(const Options<T>& value) {
  using Row = Option<Key<T>>;
  Options<Key<T>> out = {Row("frame", {KILN_MEMBER(frame), Number{{0, kLastFrame}, "frames"}},
                             "Number of the key's frame.", "a key has the number of its frame"),
                         Row("ease", {KILN_MEMBER(ease), Word{kEaseNames}},
                             "How the key is passed: without a corner, at constant speed, or with a stop.")};
  for (Option<Key<T>>& option : optionsIn<Key<T>>(value, KILN_MEMBER(value))) out.push_back(std::move(option));
  return out;
}

void requireSorted(const JobObject& object, const std::vector<TransferPoint>& points) {
  if (points.size() > 1 && points[points.size() - 2].value > points.back().value)
    object.refuse("value", "a value not below that of the point before, for points are sorted");
}

void requireSortedGradients(const JobObject& object, const std::vector<GradientPoint>& points) {
  if (points.size() > 1 && points[points.size() - 2].gradient > points.back().gradient)
    object.refuse("gradient", "a gradient not below that of the point before, for points are sorted");
}

void requireSortedSurfaces(const JobObject& object, const std::vector<IsoSurface>& surfaces) {
  if (surfaces.size() > 1 && !(surfaces[surfaces.size() - 2].value < surfaces.back().value))
    object.refuse("value", "a value above that of the surface before, for surfaces are sorted");
}

// "headlight[:COLOR]", "dir:x,y,z[:COLOR]", "cam:x,y,z[:COLOR]" or "point:x,y,z[:COLOR]".
nlohmann::json lightOfText(const std::string& text) {
  const std::vector<std::string_view> parts = splitAt(text, ':');
  nlohmann::json light;
  std::size_t color = 2;
  if (parts[0] == "dir" && parts.size() > 1) {
    light = {{"type", "directional"}, {"direction", numbersOfText(parts[1])}};
  } else if (parts[0] == "cam" && parts.size() > 1) {
    light = {{"type", "camera"}, {"direction", numbersOfText(parts[1])}};
  } else if (parts[0] == "point" && parts.size() > 1) {
    light = {{"type", "point"}, {"position", numbersOfText(parts[1])}};
  } else if (parts[0] == "headlight") {
    light = {{"type", "headlight"}};
    color = 1;
  }
  if (light.is_null() || parts.size() > color + 1) return {};
  if (parts.size() > color) light["color"] = colorOfText(parts[color]);
  return nlohmann::json::array({light});
}

// The part of a light's text that is neither a point nor a colour, in place of either.
std::string wrongPartOfLight(const std::string& text) {
  const std::vector<std::string_view> parts = splitAt(text, ':');
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const bool place = i == 1 && parts[0] != "headlight";
    if ((place ? numbersOfText(parts[i]) : colorOfText(parts[i])).is_null()) return std::string(parts[i]);
  }
  return {};
}

// "nx,ny,nz,d".
nlohmann::json planeOfText(const std::string& text) {
  const nlohmann::json n = numbersOfText(text);
  if (n.size() != 4) return {};
  const nlohmann::json plane = {{"normal", {n[0], n[1], n[2]}}, {"offset", n[3]}};
  return nlohmann::json::array({plane});
}

// A camera file, whose values are those of keys that are not given.
OptionValue<CameraSpec> cameraFileValue() {
  return OptionValue<CameraSpec>::custom(FileName().form(),
                                         [](const JobObject& object, std::string_view key, CameraSpec& camera) {
                                           fs::path file;
                                           FileName().read(object, key, file);
                                           readCameraFile(file, camera);
                                         });
}

// A number, an object, or "STRENGTH[:RADIUS]".
OptionValue<Shading> occlusionValue() {
  const auto read = [](const JobObject& object, std::string_view key, Shading& shading) {
    shading.occlusion = {};
    if (object.isObject(key))
      readOptions(occlusionOptions(), *object.object(key), shading.occlusion);
    else
      Number{kFraction.range}.read(object, key, shading.occlusion.strength);
  };
  const auto write = [](const Shading& shading) {
    return shading.occlusion.strength > 0 ? resolvedJson(occlusionOptions(), shading.occlusion)
                                          : nlohmann::ordered_json();
  };
  OptionForm form = schemaForm({{"anyOf", {Number{kFraction.range}.form().schema, {{"$ref", "ambientOcclusion"}}}}});
  form.value_name = "STRENGTH[:RADIUS]";
  form.expected = "a strength from 0 to 1, and a radius in world units after a colon";
  form.parse = [](const std::string& text) -> nlohmann::json {
    const std::vector<std::string_view> parts = splitAt(text, ':');
    if (parts.size() > 2) return {};
    const nlohmann::json strength = numbersOfText(parts[0]);
    if (strength.size() != 1) return {};
    if (parts.size() == 1) return strength[0];
    const nlohmann::json radius = numbersOfText(parts[1]);
    if (radius.size() != 1) return {};
    return {{"strength", strength[0]}, {"radius", radius[0]}};
  };
  return OptionValue<Shading>::custom(std::move(form), read, write).resolvedIf(kAlways);
}

// true, false or an object.
OptionValue<Light> shadowValue() {
  const auto read = [](const JobObject& object, std::string_view key, Light& light) {
    light.shadow = {};
    light.shadow.casts = true;
    if (object.isObject(key))
      readOptions(shadowOptions(), *object.object(key), light.shadow);
    else
      Switch{}.read(object, key, light.shadow.casts);
  };
  const auto write = [](const Light& light) {
    return light.shadow.casts ? resolvedJson(shadowOptions(), light.shadow) : nlohmann::ordered_json();
  };
  return OptionValue<Light>::custom(schemaForm({{"anyOf", {{{"type", "boolean"}}, {{"$ref", "shadow"}}}}}), read, write)
      .resolvedIf(kAlways);
}

}  // namespace

std::vector<SharedRange> sharedRanges() { return {kFraction, kWeight, kBrightness, kLength, kPositiveLength}; }

const Options<CameraSpec>& cameraOptions() {
  using Row = Option<CameraSpec>;
  static const Options<CameraSpec> kOptions = {
      // First, so that other keys win.
      Row("file", "--camera", kCamera, cameraFileValue(),
          "The camera of a file: ParaView's .pvcc, or the first of a .gltf or .glb. Options beside it win."),
      Row("projection", "--projection", kCamera, {KILN_MEMBER(projection), Word{kProjectionNames}, kAlways},
          "equirectangular: a panorama of all directions around the eye, the view direction in the middle, up at the "
          "top; depths are distances from the eye."),
      Row("fov", "--fov", kCamera, {KILN_MEMBER(fov_deg), Number{{0, 180, true, true}, "degrees"}, kAlways},
          "Vertical field of view of a perspective camera."),
      Row("height", "--height", kCamera,
          {KILN_MEMBER(height), Number{kPositiveLength.range, "world units", kPositiveLength.name}, kAlways},
          "Height of the image of an orthographic camera."),
      Row("eye", "--eye", kCamera, {KILN_MEMBER(eye), WorldVector{}, kAlways}, "Position of the eye in the world."),
      Row("target", "--target", kCamera, {KILN_MEMBER(target), WorldVector{}, kAlways},
          "Point in the world that the camera looks at. Default: the centre of the volume."),
      Row("up", "--up", kCamera, {KILN_MEMBER(up), WorldVector{true}, kAlways}, "Up direction in the world."),
      Row("view", "--view", kCamera, {KILN_MEMBER(side), Word{kSideNames, kSides}},
          "Look at this side of the volume; the picture fits the box of --fit."),
      Row("azimuth", "--azimuth", kCamera, {KILN_MEMBER(azimuth_deg), Number{{-3600, 3600}, "degrees"}},
          "Turn the eye around the up axis."),
      Row("elevation", "--elevation", kCamera, {KILN_MEMBER(elevation_deg), Number{{-90, 90}, "degrees"}},
          "Raise the eye."),
      Row("roll", "--roll", kCamera, {KILN_MEMBER(roll_deg), Number{{-3600, 3600}, "degrees"}},
          "Turn the camera about its line of sight, clockwise as it sees: the picture turns the other way."),
      Row("zoom", "--zoom", kCamera, {KILN_MEMBER(zoom), Number{{1e-6, 1e6}}},
          "Enlarge the picture; 2 is twice as large."),
      Row("pan", "--pan", kCamera, {KILN_MEMBER(pan), PictureShift{}},
          "Move the picture's content by X widths to the right and Y heights up."),
  };
  return kOptions;
}

const Options<Turntable>& turntableOptions() {
  using Row = Option<Turntable>;
  static const Options<Turntable> kOptions = {
      Row("frames", {KILN_MEMBER(frames), Whole{1, kMostFrames, "frames"}}, "Frames of the whole turn.",
          "a turntable has the number of its frames"),
      Row("degrees", {KILN_MEMBER(degrees), Number{{-36000, 36000}, "degrees"}}, "Angle of the whole turn."),
      Row("axis", {KILN_MEMBER(axis), WorldVector{true}},
          "Axis through the target. Default: the up direction of the camera."),
  };
  return kOptions;
}

const Options<Stereo>& stereoOptions() {
  using Row = Option<Stereo>;
  static const Options<Stereo> kOptions = {
      Row("eye", "--stereo", kCamera, {KILN_MEMBER(eye), Word{kStereoEyeNames}, kAlways},
          "Draw the view of one eye of a pair, or both: an EXR with the views left and right, or a PNG with both side "
          "by side. A name with %V gives two files; %V becomes left and right.",
          "a picture shows the view of the left eye, of the right eye, or both"),
      Row("interocular", "--interocular", kCamera,
          {KILN_MEMBER(interocular), Number{kPositiveLength.range, "world units", kPositiveLength.name}, kAlways},
          "Distance between the two eyes."),
      Row("convergence", "--convergence", kCamera,
          {KILN_MEMBER(convergence), Number{kPositiveLength.range, "world units", kPositiveLength.name}, kAlways},
          "Depth at which both views agree. Default: the depth of the target."),
  };
  return kOptions;
}

const Options<Lens>& lensOptions() {
  using Row = Option<Lens>;
  static const auto has_lens = [](const Lens& lens) { return lens.aperture > 0; };
  static const Options<Lens> kOptions = {
      Row("aperture", "--aperture", kCamera, {KILN_MEMBER(aperture), Number{{0, kLongest}, "world units"}, has_lens},
          "Depth of field: the diameter of the lens. The picture is the mean of pictures from points of the lens."),
      Row("focus", "--focus", kCamera,
          {KILN_MEMBER(focus), Number{kPositiveLength.range, "world units", kPositiveLength.name}, has_lens},
          "Depth of what is sharp: Z of --aov depth in the picture. Default: the depth of the target, often inside of "
          "what is seen."),
      Row("eyes", "--aperture-eyes", kCamera, {KILN_MEMBER(eyes), Whole{1, kMostEyes, "points"}, has_lens},
          "Points of the lens; the time of a picture is proportional."),
  };
  return kOptions;
}

const Options<Shading>& shadingOptions() {
  using Row = Option<Shading>;
  static const Options<Shading> kOptions = {
      Row("model", "--shading", kLight, {KILN_MEMBER(phong), Word{kShadingNames}, kAlways},
          "none: draw the colours of the transfer function without light."),
      // An older key for a single headlight.
      Row("light",
          OptionValue<Shading>::custom(schemaForm({{"const", "headlight"}}),
                                       [](const JobObject& object, std::string_view key, Shading&) {
                                         static constexpr std::array<std::string_view, 1> kLights = {"headlight"};
                                         object.choice(key, kLights);
                                       }),
          "Replaced by lights."),
      Row("ambient", "--ambient", kLight, {KILN_MEMBER(ambient), Number{kWeight.range, "", kWeight.name}, kAlways},
          "Weight of light from all directions."),
      Row("diffuse", "--diffuse", kLight, {KILN_MEMBER(diffuse), Number{kWeight.range, "", kWeight.name}, kAlways},
          "Weight of diffuse reflection, in the colour of the material."),
      Row("specular", "--specular", kLight, {KILN_MEMBER(specular), Number{kWeight.range, "", kWeight.name}, kAlways},
          "Weight of highlights, in the colour of the light."),
      Row("power", "--power", kLight, {KILN_MEMBER(power), Number{{0, 1e4}}, kAlways},
          "Exponent of highlights; larger is narrower."),
      Row("shadows", "--shadows", kLight,
          {KILN_MEMBER(shadows), Switch{}, [](const Shading& shading) { return shading.shadows; }},
          "The volumes cast shadows in all lights but headlights, whose shadows the eye does not see."),
      Row("ambientOcclusion", "--ambient-occlusion", kLight, occlusionValue(),
          "Share of the ambient light that near matter keeps away, as STRENGTH or STRENGTH:RADIUS; in a job also an "
          "object with strength, radius and occludes. Default radius: a tenth of the volume's longest edge."),
  };
  return kOptions;
}

const Options<Shadow>& shadowOptions() {
  using Row = Option<Shadow>;
  static const Options<Shadow> kOptions = {
      Row("strength", {KILN_MEMBER(strength), Number{kFraction.range, "", kFraction.name}, kAlways},
          "Share of the light that an opaque object takes away."),
      Row("softness", {KILN_MEMBER(softness), Number{{0, 45}, "degrees"}, kAlways},
          "Angle of the light, seen from the volume: 0 for sharp shadows, 0.5 for the sun."),
      Row("resolution", {KILN_MEMBER(resolution), Whole{0, kMostShadowEdge, "pixels"}, kAlways},
          "Longest edge of the shadow map; 0: the longer side of the picture, from 512 to 1024 pixels, and at most two "
          "pixels a voxel of the volume's longest side; half as much for soft shadows."),
  };
  return kOptions;
}

const Options<AmbientOcclusion>& occlusionOptions() {
  using Row = Option<AmbientOcclusion>;
  static const Options<AmbientOcclusion> kOptions = {
      Row("strength", {KILN_MEMBER(strength), Number{kFraction.range, "", kFraction.name}, kAlways},
          "Share of the light that matter keeps away.", "occlusion has a strength from 0 to 1"),
      Row("radius",
          {KILN_MEMBER(radius), Number{kLength.range, "world units", kLength.name},
           [](const AmbientOcclusion& occlusion) { return occlusion.radius > 0; }},
          "Distance beyond which matter does not occlude. 0: a tenth of the volume's longest edge."),
      Row("occludes", {KILN_MEMBER(diffuse), Word{kOccludesNames}, kAlways},
          "ambient: occludes ambient light; all: diffuse light, too."),
  };
  return kOptions;
}

const Options<Light>& lightOptions() {
  using Row = Option<Light>;
  static const Options<Light> kOptions = {
      Row("type", {KILN_MEMBER(kind), Word{kLightNames}, kAlways}, "",
          "a light is a headlight, directional, point or camera"),
      Row("direction", {KILN_MEMBER(place), WorldVector{true}, [](const Light& light) { return isFar(light.kind); }},
          "Direction towards a light far away: of the world, or of a camera light in the camera's axes (right, up, "
          "towards the eye)."),
      Row("position",
          {KILN_MEMBER(place), WorldVector{}, [](const Light& light) { return light.kind == LightKind::kPoint; }},
          "Position of a point light."),
      Row("color", {KILN_MEMBER(color), ColorValue{kBrightness.range, kBrightness.name}, kAlways},
          "[red, green, blue] in linear light, or a name, #rgb or #rrggbb in sRGB."),
      Row("intensity", {KILN_MEMBER(intensity), Number{kBrightness.range, "", kBrightness.name}, kAlways},
          "Factor of the colour."),
      Row("shadow", shadowValue(),
          "true, or the strength, softness and resolution of the shadow: the volumes cast shadows."),
  };
  return kOptions;
}

const Options<ClipPlane>& clipPlaneOptions() {
  using Row = Option<ClipPlane>;
  static const Options<ClipPlane> kOptions = {
      Row("normal", {KILN_MEMBER(normal), WorldVector{true}, kAlways}, "", "a clip plane has one"),
      Row("offset", {KILN_MEMBER(offset), Number{kLength.range, "", kLength.name}, kAlways},
          "The plane shows the half-space normal·x + offset >= 0.", "a clip plane shows where normal·x + offset >= 0"),
  };
  return kOptions;
}

const ListOf<Light>& lightList() {
  static const ListOf<Light> kList{.options = lightOptions(),
                                   .name = "light",
                                   .limit = {kMostLights, "lights"},
                                   .expected = "a list of lights [{type, …}, …]",
                                   .item_from = &lightFrom,
                                   .value_name = "LIGHT",
                                   .flag_expected =
                                       "headlight[:COLOR], dir:x,y,z[:COLOR], cam:x,y,z[:COLOR] or "
                                       "point:x,y,z[:COLOR], COLOR a name such as orange, "
                                       "#rgb, #rrggbb, or r,g,b from 0 to 1000000",
                                   .parse = &lightOfText,
                                   .wrong_part = &wrongPartOfLight};
  return kList;
}

const ListOf<ClipPlane>& clipPlaneList() {
  static const ListOf<ClipPlane> kList{.options = clipPlaneOptions(),
                                       .name = "clipPlane",
                                       .limit = {kMostClipPlanes, "planes"},
                                       .expected = "a list of planes [{normal, offset}, …]",
                                       .value_name = "NX,NY,NZ,D",
                                       .flag_expected = "four finite numbers NX,NY,NZ,D, the normal not zero",
                                       .parse = &planeOfText};
  return kList;
}

const Options<TransferPoint>& pointOptions() {
  constexpr std::string_view kMissing = "a point has value, color and opacity";
  using Row = Option<TransferPoint>;
  static const Options<TransferPoint> kOptions = {
      Row("value", {KILN_MEMBER(value), Number{kVoxelValue}, kAlways}, "", kMissing),
      Row("color", {KILN_MEMBER(color), ColorValue{kFraction.range, kFraction.name}, kAlways}, "", kMissing),
      Row("opacity", {KILN_MEMBER(opacity), Number{kFraction.range, "", kFraction.name}, kAlways}, "", kMissing),
  };
  return kOptions;
}

const Options<GradientPoint>& gradientPointOptions() {
  constexpr std::string_view kMissing = "a point has gradient and factor";
  using Row = Option<GradientPoint>;
  static const Options<GradientPoint> kOptions = {
      Row("gradient", {KILN_MEMBER(gradient), Number{{0, kVoxelValue.most}}, kAlways}, "Values per world unit.",
          kMissing),
      Row("factor", {KILN_MEMBER(factor), Number{kFraction.range, "", kFraction.name}, kAlways}, "", kMissing),
  };
  return kOptions;
}

const Options<IsoSurface>& surfaceOptions() {
  constexpr std::string_view kMissing = "a surface has a value";
  using Row = Option<IsoSurface>;
  static const Options<IsoSurface> kOptions = {
      Row("value", {KILN_MEMBER(value), Number{kVoxelValue}, kAlways}, "Value at which the surface lies.", kMissing),
      Row("color", {KILN_MEMBER(color), ColorValue{kFraction.range, kFraction.name}, kAlways}),
      Row("opacity", {KILN_MEMBER(opacity), Number{kFraction.range, "", kFraction.name}, kAlways},
          "Opacity of each crossing of the surface."),
  };
  return kOptions;
}

const Options<LabelStyle>& labelOptions() {
  constexpr auto kLast = static_cast<std::int64_t>(kLargestLabel);
  constexpr std::string_view kMissing = "a label has label and color";
  using Row = Option<LabelStyle>;
  static const Options<LabelStyle> kOptions = {
      Row("label", {KILN_MEMBER(label), Whole{-kLast, kLast}, kAlways}, "", kMissing),
      Row("color", {KILN_MEMBER(color), ColorValue{kFraction.range, kFraction.name}, kAlways}, "", kMissing),
      Row("opacity", {KILN_MEMBER(opacity), Number{kFraction.range, "", kFraction.name}, kAlways}),
      Row("name", {KILN_MEMBER(name), Text{"a name"}, [](const LabelStyle& style) { return !style.name.empty(); }}),
  };
  return kOptions;
}

const Options<TransferFunction>& transferFunctionOptions() {
  static const ListOf<TransferPoint> kPoints{.options = pointOptions(),
                                             .name = "point",
                                             .limit = {kMostPoints, "points"},
                                             .expected = "a list of at least one point {value, color, opacity}",
                                             .least = 1,
                                             .check = &requireSorted};
  static const ListOf<GradientPoint> kGradientPoints{.options = gradientPointOptions(),
                                                     .name = "gradientPoint",
                                                     .limit = {kMostPoints, "points"},
                                                     .expected = "a list of points [{gradient, factor}, …]",
                                                     .check = &requireSortedGradients};
  static const ListOf<LabelStyle> kLabels{.options = labelOptions(),
                                          .name = "label",
                                          .limit = {kMostLabelLooks, "labels"},
                                          .expected = "a list of at least one label {label, color, opacity}",
                                          .least = 1};
  static const ListOf<IsoSurface> kSurfaces{.options = surfaceOptions(),
                                            .name = "isoSurface",
                                            .limit = {kMostIsoSurfaces, "surfaces"},
                                            .expected = "a list of at least one surface {value, color, opacity}",
                                            .least = 1,
                                            .check = &requireSortedSurfaces};
  static const ListOf<GradientRegion> kRegions{.options = gradientRegionOptions(),
                                               .name = "gradientRegion",
                                               .limit = {kMostRegions, "regions"},
                                               .expected = "a list of at least one region {values, gradients}",
                                               .least = 1};
  static const auto kHasLabels = [](const TransferFunction& function) { return !function.labels.empty(); };
  static const auto kHasSurfaces = [](const TransferFunction& function) { return !function.surfaces.empty(); };
  using Row = Option<TransferFunction>;
  static const Options<TransferFunction> kOptions = {
      Row("kiln", formatValue<TransferFunction>(), "Version of the format; decides the default of colorSpace."),
      Row("unit", {KILN_MEMBER(unit), Number{{0, kLongest}, "world units"}, kAlways},
          "Length that opacity is per; 0 is the mean spacing of voxels."),
      Row("colorSpace",
          OptionValue<TransferFunction>::custom(
              Word{kColorSpaceNames}.form(),
              [](const JobObject& object, std::string_view key, TransferFunction&) {
                object.choice(key, kColorSpaceNames);
              },
              [](const TransferFunction&) { return kColorSpaceNames[0]; })
              .resolvedIf(kAlways),
          "Space of all colours that are numbers: srgb by default, linear in format 1 and in a file without kiln."),
      Row("labels", {KILN_MEMBER(labels), kLabels, kHasLabels},
          "Styles of the labels of a label volume, instead of points; all other labels are transparent."),
      Row("points",
          {KILN_MEMBER(points), kPoints, [](const TransferFunction& f) { return !kHasLabels(f) && !kHasSurfaces(f); }}),
      Row("surfaces", {KILN_MEMBER(surfaces), kSurfaces, kHasSurfaces},
          "Surfaces at values of the volume, instead of points; nothing else is visible."),
      Row("gradientOpacity",
          {KILN_MEMBER(gradient_opacity), kGradientPoints,
           [](const TransferFunction& f) { return !kHasLabels(f) && !kHasSurfaces(f) && !f.gradient_opacity.empty(); }},
          "Factor of the opacity by the length of the gradient."),
      Row("regions", {KILN_MEMBER(regions), kRegions, [](const TransferFunction& f) { return !f.regions.empty(); }},
          "Visible regions over values and gradients, instead of gradientOpacity."),
      Row("table",
          objectValue("gradientTable", optionsIn<TransferFunction>(gradientTableOptions(), KILN_MEMBER(table))),
          "Factors of the opacity over values and gradients, instead of gradientOpacity."),
      Row("shading", {KILN_MEMBER(shaded), Word{kShadingNames}, [](const TransferFunction& f) { return !f.shaded; }},
          "none: colours without light."),
      Row("scattering",
          objectValue("scattering", optionsIn<TransferFunction>(scatteringOptions(), KILN_MEMBER(scattering))),
          "A cloud: samples send light of the lights and from all around, whatever their gradient."),
  };
  return kOptions;
}

const Options<Key<CameraSpec>>& cameraKeyOptions() {
  static const Options<Key<CameraSpec>> kOptions = keyOptions(cameraOptions());
  return kOptions;
}

const Options<Key<Stereo>>& stereoKeyOptions() {
  static const Options<Key<Stereo>> kOptions = [] {
    Options<Stereo> distances = stereoOptions();
    std::erase_if(distances, [](const Option<Stereo>& option) { return option.key == "eye"; });
    distances.front().missing = kMissingInterocular;
    return keyOptions(distances);
  }();
  return kOptions;
}

const Options<Key<TransferFunctionChoice>>& functionKeyOptions() {
  static const Options<Key<TransferFunctionChoice>> kOptions =
      keyOptions<TransferFunctionChoice>({Option<TransferFunctionChoice>(
          "function",
          OptionValue<TransferFunctionChoice>::custom(
              schemaForm({{"anyOf", {{{"$ref", "text"}}, {{"$ref", "transferFunction"}}}}}),
              [](const JobObject& object, std::string_view key, TransferFunctionChoice& choice) {
                choice = *transferFunctionChoiceFrom(object, key);
              }),
          "", "a key has a preset, a file or a function")});
  return kOptions;
}

const Options<Key<std::vector<Light>>>& lightsKeyOptions() {
  static const Options<Key<std::vector<Light>>> kOptions = keyOptions<std::vector<Light>>(
      {Option<std::vector<Light>>("lights", {kSame, lightList()}, "", "a key has a list of lights")});
  return kOptions;
}

const Options<Key<std::vector<ClipPlane>>>& clipKeyOptions() {
  static const Options<Key<std::vector<ClipPlane>>> kOptions = keyOptions<std::vector<ClipPlane>>(
      {Option<std::vector<ClipPlane>>("planes", {kSame, clipPlaneList()}, "", "a key has a list of planes")});
  return kOptions;
}

}  // namespace kiln

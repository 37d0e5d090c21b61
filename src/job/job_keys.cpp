#include "job/job_keys.h"

#include <array>

namespace kiln::job_keys {
namespace {

constexpr JobKey kRootKeys[] = {
    {"kiln", R"({"const": 1, "description": "the job format"})"},
    {"volume",
     R"({"$ref": "text", "description": "a store, or a volume file that is converted to a store beside it first"})"},
    {"volumes",
     R"({"type": "array", "items": {"$ref": "volume"}, "minItems": 1, "maxItems": 64,
         "description": "several in one picture, each where its affine has it, instead of volume"})"},
    {"output",
     R"({"$ref": "text", "description": "the picture, .exr or .png, or a video, .mp4, .mov, .mkv or .webm; a run of # is the frame's number"})"},
    {"outputs", R"({"type": "array", "items": {"$ref": "output"}, "maxItems": 64,
                    "description": "more files of each frame"})"},
    {"video", R"({"$ref": "video"})"},
    {"frames", R"({"description": "such as \"1-100\", \"1-100x2\" or \"1-10,20\"", "type": "string",
                   "pattern": "^ *[0-9]+(-[0-9]+)?(x[0-9]+)?(, *[0-9]+(-[0-9]+)?(x[0-9]+)?)*$"})"},
    {"image", R"({"$ref": "image"})"},
    {"camera", R"({"$ref": "camera"})"},
    {"stereo", R"({"$ref": "stereo"})"},
    {"transferFunction",
     R"({"description": "a preset, a file, the function itself, or keyframes of these",
         "anyOf": [{"$ref": "text"}, {"$ref": "transferFunction"}, {"$ref": "functionKeyframes"}]})"},
    {"window",
     R"({"$ref": "pair", "description": "[centre, width] of values: the function's first and last points lie at its ends"})"},
    {"shading", R"({"$ref": "shading"})"},
    {"lights",
     R"({"anyOf": [{"type": "array", "items": {"$ref": "light"}, "maxItems": 64}, {"$ref": "lightsKeyframes"}]})"},
    {"region", R"({"description": "voxels [x0, y0, z0, x1, y1, z1], half-open", "type": "array",
                   "items": {"type": "integer", "minimum": -1e15, "maximum": 1e15}, "minItems": 6, "maxItems": 6})"},
    {"worldRegion", R"({"description": "a box of the world [x0, y0, z0, x1, y1, z1]", "type": "array",
                        "items": {"$ref": "length"}, "minItems": 6, "maxItems": 6})"},
    {"part", R"({"description": "draw a partial image: \"I/N\", or voxels [x0, y0, z0, x1, y1, z1], half-open",
                 "anyOf": [{"type": "string", "pattern": "^[0-9]+/[0-9]+$"},
                           {"type": "array", "items": {"type": "integer", "minimum": -1e15, "maximum": 1e15},
                            "minItems": 6, "maxItems": 6}]})"},
    {"clip",
     R"({"anyOf": [{"type": "array", "items": {"$ref": "clipPlane"}, "maxItems": 64}, {"$ref": "clipKeyframes"}]})"},
    {"visibility", R"({"$ref": "visibility"})"},
    {"mode", R"({"enum": "mode"})"},
    {"lattice", R"({"enum": "lattice"})"},
    {"interpolation", R"({"enum": "interpolation"})"},
    {"sampleDistance",
     R"({"type": "number", "minimum": 0.25, "maximum": 1, "description": "voxels between samples; more is faster"})"},
    {"level",
     R"({"description": "0 is finest", "anyOf": [{"const": "auto"}, {"type": "integer", "minimum": 0, "maximum": 64}]})"},
    {"samples", R"({"description": "sub-pixels that a pixel is made of", "enum": ["auto", 1, 2, 4, 16]})"},
    {"skipDamaged", R"({"type": "boolean", "description": "draw bricks that cannot be read as nothing"})"},
    {"memory", R"({"description": "bytes, or an amount such as \"2G\"",
                   "anyOf": [{"type": "string", "pattern": "^[0-9.]+([KMGT](iB|B)?|B)?$"},
                             {"type": "integer", "minimum": 1, "maximum": 4503599627370496}]})"},
    {"threads", R"({"type": "integer", "minimum": 0, "maximum": 4096, "description": "0 takes all"})"},
    {"tile",
     R"({"type": "integer", "minimum": 0, "maximum": 65536, "description": "a power of two from 64 on, or 0"})"},
    {"trace", R"({"$ref": "text", "description": "a file for what each thread did when, in Chrome's trace format"})"},
    {"distribute", R"({"enum": "distribution", "description": "what the ranks of mpirun share"})"},
    {"shareReads", R"({"type": "boolean", "description": "a brick file is read by one rank of mpirun for all"})"},
    {"exr", R"({"$ref": "exr"})"},
    {"png", R"({"$ref": "png"})"},
};

constexpr JobKey kVolumeKeys[] = {
    {"volume", R"({"$ref": "text", "description": "a store, or a volume file"})"},
    {"labels", R"({"type": "boolean", "description": "a volume file's values are labels"})"},
    {"transferFunction",
     R"({"description": "a preset, a file, the function itself, or keyframes of these",
         "anyOf": [{"$ref": "text"}, {"$ref": "transferFunction"}, {"$ref": "functionKeyframes"}]})"},
    {"window", R"({"$ref": "pair", "description": "[centre, width] of values"})"},
    {"shading", R"({"$ref": "shading"})"},
    {"region", R"({"description": "voxels [x0, y0, z0, x1, y1, z1], half-open", "type": "array",
                   "items": {"type": "integer", "minimum": -1e15, "maximum": 1e15}, "minItems": 6, "maxItems": 6})"},
    {"worldRegion", R"({"description": "a box of the world [x0, y0, z0, x1, y1, z1]", "type": "array",
                        "items": {"$ref": "length"}, "minItems": 6, "maxItems": 6})"},
    {"clip", R"({"type": "array", "items": {"$ref": "clipPlane"}, "maxItems": 64})"},
};

constexpr JobKey kImageKeys[] = {
    {"width", R"({"type": "integer", "minimum": 1, "maximum": 65536})"},
    {"height", R"({"type": "integer", "minimum": 1, "maximum": 65536})"},
    {"background", R"({"description": "[red, green, blue, alpha], linear and premultiplied, or a gradient",
                       "anyOf": [{"$ref": "rgba"}, {"$ref": "gradient"}]})"},
    {"crop", R"({"description": "[x, y, width, height] in pixels", "type": "array",
                 "items": {"type": "integer", "minimum": 0, "maximum": 65536}, "minItems": 4, "maxItems": 4})"},
    {"aov", R"({"type": "array", "items": {"enum": "aov"}, "uniqueItems": true})"},
};

constexpr JobKey kCameraKeys[] = {
    {"projection", R"({"enum": "projection"})"},
    {"fov",
     R"({"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 180, "description": "degrees, vertical"})"},
    {"height", R"({"$ref": "positiveLength", "description": "world units the image spans, orthographic"})"},
    {"eye", R"({"$ref": "vector"})"},
    {"target", R"({"$ref": "vector"})"},
    {"up", R"({"$ref": "vector"})"},
    {"view", R"({"enum": "side"})"},
    {"azimuth", R"({"type": "number", "minimum": -3600, "maximum": 3600, "description": "degrees"})"},
    {"elevation", R"({"type": "number", "minimum": -90, "maximum": 90, "description": "degrees"})"},
    {"zoom", R"({"type": "number", "minimum": 0.001, "maximum": 1000000})"},
};

constexpr JobKey kStereoKeys[] = {
    {"eye", R"({"enum": "stereoEye"})"},
    {"interocular", R"({"$ref": "positiveLength", "description": "between both eyes"})"},
    {"convergence",
     R"({"$ref": "positiveLength", "description": "the depth at which both see the same; the target's"})"},
    {"keyframes", R"({"type": "array", "items": {"$ref": "stereoKeyframe"}, "minItems": 1, "maxItems": 10000})"},
};

constexpr JobKey kCameraPathKeys[] = {
    {"turntable", R"({"$ref": "turntable"})"},
    {"keyframes", R"({"type": "array", "items": {"$ref": "cameraKeyframe"}, "minItems": 1, "maxItems": 10000})"},
    {"pivot", R"({"enum": "pivot", "description": "between keyframes, what the orientation turns about"})"},
    {"matrices",
     R"({"description": "camera to world, 4 rows of 4 numbers, for frame 1 and those after it", "minItems": 1,
                     "maxItems": 100000, "type": "array", "items": {"type": "array", "minItems": 4, "maxItems": 4, "items":
                       {"type": "array", "minItems": 4, "maxItems": 4, "items": {"$ref": "length"}}}})"},
};

constexpr JobKey kTurntableKeys[] = {
    {"frames", R"({"type": "integer", "minimum": 1, "maximum": 1000000, "description": "of the whole turn"})"},
    {"degrees", R"({"type": "number", "minimum": -36000, "maximum": 36000})"},
    {"axis", R"({"$ref": "vector", "description": "through the target; the camera's up where it is not given"})"},
};

// Keys that every keyframe has beside its value.
constexpr JobKey kFrameKey = {"frame", R"({"type": "number", "minimum": 0, "maximum": 9999999})"};
constexpr JobKey kEaseKey = {"ease", R"({"enum": "ease", "description": "how the key is passed"})"};

constexpr JobKey kCameraKeyKeys[] = {kFrameKey, kEaseKey};
constexpr JobKey kFunctionKeyKeys[] = {
    kFrameKey,
    kEaseKey,
    {"function", R"({"anyOf": [{"$ref": "text"}, {"$ref": "transferFunction"}]})"},
};
constexpr JobKey kLightsKeyKeys[] = {
    kFrameKey, kEaseKey, {"lights", R"({"type": "array", "items": {"$ref": "light"}, "maxItems": 64})"}};
constexpr JobKey kClipKeyKeys[] = {
    kFrameKey, kEaseKey, {"planes", R"({"type": "array", "items": {"$ref": "clipPlane"}, "maxItems": 64})"}};
constexpr JobKey kStereoKeyKeys[] = {
    kFrameKey,
    kEaseKey,
    {"interocular", R"({"$ref": "positiveLength"})"},
    {"convergence", R"({"$ref": "positiveLength", "description": "in all keys, or in none"})"},
};
constexpr JobKey kFunctionKeysKeys[] = {
    {"keyframes", R"({"type": "array", "items": {"$ref": "functionKeyframe"}, "minItems": 1, "maxItems": 10000})"}};
constexpr JobKey kLightsKeysKeys[] = {
    {"keyframes", R"({"type": "array", "items": {"$ref": "lightsKeyframe"}, "minItems": 1, "maxItems": 10000})"}};
constexpr JobKey kClipKeysKeys[] = {
    {"keyframes", R"({"type": "array", "items": {"$ref": "clipKeyframe"}, "minItems": 1, "maxItems": 10000})"}};

constexpr JobKey kTransferFunctionKeys[] = {
    {"unit",
     R"({"type": "number", "minimum": 0, "description": "the length that opacity is per; 0 is the mean spacing"})"},
    {"colorSpace", R"({"enum": "colorSpace"})"},
    {"points", R"({"type": "array", "items": {"$ref": "point"}, "minItems": 1, "maxItems": 65536})"},
    {"labels", R"({"type": "array", "items": {"$ref": "label"}, "minItems": 1, "maxItems": 262144,
                   "description": "of a label volume, instead of points; the others are transparent"})"},
    {"gradientOpacity", R"({"type": "array", "items": {"$ref": "gradientPoint"}, "maxItems": 65536})"},
};

constexpr JobKey kLabelKeys[] = {
    {"label", R"({"type": "integer", "minimum": -8388608, "maximum": 8388608})"},
    {"name", R"({"$ref": "text"})"},
    {"color", R"({"type": "array", "items": {"$ref": "fraction"}, "minItems": 3, "maxItems": 3})"},
    {"opacity", R"({"$ref": "fraction"})"},
};

constexpr JobKey kPointKeys[] = {
    {"value", R"({"type": "number"})"},
    {"color", R"({"type": "array", "items": {"$ref": "fraction"}, "minItems": 3, "maxItems": 3})"},
    {"opacity", R"({"$ref": "fraction"})"},
};

constexpr JobKey kGradientPointKeys[] = {
    {"gradient", R"({"type": "number", "minimum": 0, "description": "values per world unit"})"},
    {"factor", R"({"$ref": "fraction"})"},
};

constexpr JobKey kShadingKeys[] = {
    {"model", R"({"enum": "shading"})"},
    {"light", R"({"const": "headlight", "description": "what lights says now"})"},
    {"ambient", R"({"$ref": "weight"})"},
    {"diffuse", R"({"$ref": "weight"})"},
    {"specular", R"({"$ref": "weight"})"},
    {"power", R"({"type": "number", "minimum": 0, "maximum": 10000})"},
};

// Keys of every light come last, so that each kind of light is a range of one table.
constexpr std::array<JobKey, 5> kLightKeys = {{
    {"direction", R"({"$ref": "vector", "description": "towards the light, directional"})"},
    {"type", R"({"enum": "light"})"},
    {"color", R"({"type": "array", "items": {"$ref": "brightness"}, "minItems": 3, "maxItems": 3})"},
    {"intensity", R"({"$ref": "brightness"})"},
    {"position", R"({"$ref": "vector", "description": "of a point light"})"},
}};

constexpr JobKey kClipPlaneKeys[] = {
    {"normal", R"({"$ref": "vector"})"},
    {"offset", R"({"$ref": "length", "description": "shown is where normal·x + offset >= 0"})"},
};

constexpr JobKey kGradientKeys[] = {{"top", R"({"$ref": "rgba"})"}, {"bottom", R"({"$ref": "rgba"})"}};

constexpr JobKey kVisibilityKeys[] = {
    {"method", R"({"enum": "visibility"})"},
    {"threshold", R"({"type": "number", "exclusiveMinimum": 0, "maximum": 1})"},
    {"area", R"({"enum": "area"})"},
    {"epsilon", R"({"type": "integer", "minimum": 0, "maximum": 65536, "description": "pixels, of the quadtree"})"},
    {"samples", R"({"enum": ["untested", "tested"]})"},
};

constexpr JobKey kExrKeys[] = {
    {"type", R"({"enum": ["half", "float"]})"},
    {"compression", R"({"enum": "compression", "description": "the last two lose something"})"},
    {"owner", R"({"$ref": "text"})"},
    {"comments", R"({"$ref": "text"})"},
    {"statistics", R"({"type": "boolean", "description": "what drawing has cost, in the header"})"},
    {"deep", R"({"type": "boolean", "description": "of what output names"})"},
    {"deepSamples", R"({"type": "integer", "minimum": 1, "maximum": 1024, "description": "of a pixel, at most"})"},
    {"deepError", R"({"type": "number", "minimum": 0, "maximum": 1,
                      "description": "what a cut may show, by merging neighbours, of 1"})"},
};
constexpr JobKey kPngKeys[] = {{"bits", R"({"enum": [8, 16]})"}};

constexpr JobKey kOutputKeys[] = {
    {"path", R"({"$ref": "text", "description": "a run of # is the frame's number"})"},
    {"content", R"({"enum": "content", "description": "what of the frame the file holds"})"},
};

constexpr JobKey kVideoKeys[] = {
    {"rate",
     R"({"type": ["number", "string"], "minimum": 0.1, "maximum": 1000, "pattern": "^[0-9]+([.][0-9]+|/[0-9]+)?$",
                 "description": "frames a second: 25, 23.976 or \"24000/1001\""})"},
};

}  // namespace

constexpr JobKeys kCameraPath = kCameraPathKeys, kTurntable = kTurntableKeys, kCameraKey = kCameraKeyKeys,
                  kFunctionKeys = kFunctionKeysKeys, kFunctionKey = kFunctionKeyKeys, kLightsKeys = kLightsKeysKeys,
                  kLightsKey = kLightsKeyKeys, kClipKeys = kClipKeysKeys, kClipKey = kClipKeyKeys,
                  kStereoKey = kStereoKeyKeys, kVolume = kVolumeKeys, kLabel = kLabelKeys;
constexpr JobKeys kRoot = kRootKeys, kImage = kImageKeys, kCamera = kCameraKeys,
                  kTransferFunction = kTransferFunctionKeys, kPoint = kPointKeys, kGradientPoint = kGradientPointKeys,
                  kShading = kShadingKeys, kLight = kLightKeys, kHeadlight = kLight.subspan(1, 3),
                  kDirectionalLight = kLight.first(4), kPointLight = kLight.subspan(1), kClipPlane = kClipPlaneKeys,
                  kGradient = kGradientKeys, kVisibility = kVisibilityKeys, kExr = kExrKeys, kPng = kPngKeys,
                  kOutput = kOutputKeys, kVideo = kVideoKeys, kStereo = kStereoKeys;

}  // namespace kiln::job_keys

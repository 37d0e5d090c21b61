// Known answers: an example job with each value in its place; each way to get a key wrong names the key.
#include "job/render_job.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "base/error.h"
#include "image/named_color.h"
#include "job/job_facts.h"
#include "job/json/job_json.h"
#include "job/transfer_function_choice.h"
#include "sequence/frame_requests.h"
#include "sequence/render_job_run.h"
#include "support/system/expect_error.h"

namespace kiln {
namespace {

const char* const kExample = R"({ "kiln": 1, "volume": "head.kiln", "output": "head_####.exr",
  // the picture of the README
  "image": {"width": 640, "height": 480, "background": [0, 0.25, 0, 0.5]},
  "camera": {"projection": "perspective", "fov": 60, "eye": [0, -500, 90], "target": [127, 127, 112], "up": [0, 0, 1]},
  "transferFunction": {"unit": 1.5, "colorSpace": "linear",
                       "points": [{"value": 420, "color": [0.93, 0.74, 0.6], "opacity": 0.0},
                                  {"value": 1150, "color": [1, 1, 1], "opacity": 0.9}]},
  "shading": {"model": "phong", "light": "headlight", "ambient": 0.1, "diffuse": 0.7, "specular": 0.3, "power": 8},
  "visibility": {"method": "none", "threshold": 0.95}, "lattice": "voxel", "level": "auto",
  "memory": "512M", "threads": 3, "exr": {"type": "float"}, "png": {"bits": 16} })";

TEST(RenderJob, ReadsEveryKey) {
  const RenderJob job = parseJob(kExample, "jobs/job.json");
  EXPECT_EQ(job.volume, "jobs/head.kiln");
  EXPECT_EQ(job.output.path, "jobs/head_####.exr");
  EXPECT_EQ(job.picture.size.width, 640);
  EXPECT_EQ(job.picture.size.height, 480);
  EXPECT_EQ(job.picture.background, (Background{{0, 0.25, 0, 0.5}, {0, 0.25, 0, 0.5}}));
  EXPECT_EQ(job.picture.camera.projection, Projection::kPerspective);
  EXPECT_EQ(job.picture.camera.fov_deg, 60);
  EXPECT_EQ(job.picture.camera.eye, glm::dvec3(0, -500, 90));
  EXPECT_EQ(job.picture.camera.target, glm::dvec3(127, 127, 112));
  EXPECT_EQ(job.picture.camera.up, glm::dvec3(0, 0, 1));
  EXPECT_FALSE(job.picture.camera.side);
  const auto& function = std::get<TransferFunction>(job.picture.transfer_function);
  EXPECT_EQ(function.unit, 1.5);
  ASSERT_EQ(function.points.size(), 2u);
  EXPECT_EQ(function.points[0].color, glm::dvec3(0.93, 0.74, 0.6));
  EXPECT_EQ(function.points[1].value, 1150);
  EXPECT_EQ(function.points[1].opacity, 0.9);
  EXPECT_TRUE(job.picture.shading.phong);
  EXPECT_EQ(job.picture.shading.diffuse, 0.7);
  EXPECT_EQ(job.picture.shading.power, 8);
  EXPECT_EQ(job.picture.level, std::nullopt);
  EXPECT_EQ(job.speed.visibility.method, VisibilityMethod::kNone);
  EXPECT_EQ(job.picture.opacity_threshold, 0.95);
  EXPECT_EQ(job.speed.memory_bytes, 512u << 20);
  EXPECT_EQ(job.speed.threads, 3u);
  EXPECT_TRUE(job.output.exr_float);
  EXPECT_EQ(job.output.png_bits, 16);
  EXPECT_FALSE(job.picture.skip_damaged);
  EXPECT_TRUE(parseJob(R"({"kiln": 2, "volume": "a.kiln", "skipDamaged": true})", "job.json").picture.skip_damaged);
  EXPECT_TRUE(job.share_reads);
  EXPECT_FALSE(parseJob(R"({"kiln": 2, "volume": "a.kiln", "shareReads": false})", "job.json").share_reads);
}

TEST(RenderJob, ComputedVolumes_areInNoFolder) {
  const RenderJob job = parseJob(R"({"kiln": 2, "volumes": [{"volume": "phantom:head:32x32x32"}, {"volume": "a.kiln",
      "mask": {"volume": "phantom:body:32x32x32", "labels": [1]}}]})",
                                 "jobs/job.json");
  EXPECT_EQ(job.volume, "phantom:head:32x32x32");
  EXPECT_EQ(job.volumes[1].volume, "jobs/a.kiln");
  EXPECT_EQ(job.volumes[1].companions.mask->volume, "phantom:body:32x32x32");
}

TEST(RenderJob, WhatIsNotSaidKeepsItsDefault) {
  const RenderJob job = parseJob(R"({"kiln": 2, "volume": "/data/a.kiln"})", "jobs/job.json");
  EXPECT_EQ(job.volume, "/data/a.kiln");
  EXPECT_TRUE(job.output.path.empty());
  EXPECT_EQ(job.picture.size.width, 1024);
  EXPECT_EQ(std::get<std::string>(job.picture.transfer_function), "auto");
  EXPECT_EQ(job.picture.opacity_threshold, 0.998);
  EXPECT_EQ(job.speed.visibility, VisibilityOptions());
  EXPECT_EQ(job.speed.memory_bytes, std::uint64_t{2} << 30);
}

TEST(RenderJob, FramingKeysAndNamedTransferFunctions) {
  RenderJob job = parseJob(
      R"({"kiln": 2, "volume": "a", "camera": {"view": "left", "azimuth": 10, "elevation": -5, "zoom": 2, "height": 7,
          "projection": "orthographic"}, "transferFunction": "ct-bone", "memory": 1000000})",
      "job.json");
  EXPECT_EQ(job.picture.camera.side, Side::kLeft);
  EXPECT_EQ(job.picture.camera.azimuth_deg, 10);
  EXPECT_EQ(job.picture.camera.elevation_deg, -5);
  EXPECT_EQ(job.picture.camera.zoom, 2);
  EXPECT_EQ(job.picture.camera.height, 7);
  EXPECT_EQ(job.picture.camera.projection, Projection::kOrthographic);
  EXPECT_EQ(std::get<std::string>(job.picture.transfer_function), "ct-bone");
  EXPECT_EQ(job.speed.memory_bytes, 1000000u);
  job = parseJob(R"({"kiln": 2, "volume": "a", "transferFunction": "bone.json"})", "jobs/job.json");
  EXPECT_EQ(std::get<std::filesystem::path>(job.picture.transfer_function), "jobs/bone.json");
}

TEST(RenderJob, LightsAndClipping) {
  const RenderJob job =
      parseJob(R"({"kiln": 2, "volume": "a", "image": {"background": {"top": [1, 0, 0, 1], "bottom": [0, 0, 0, 0]}},
      "lights": [{"type": "directional", "direction": [0, 2, 0], "color": [1, 0.5, 0], "intensity": 3}, {"type": "headlight"}],
      "region": [1, 2, 3, 4, 5, 6], "worldRegion": [0, 0, 0, 9, 9, 9], "clip": [{"normal": [0, 0, -1], "offset": 7}]})",
               "job.json");
  EXPECT_EQ(job.picture.background, (Background{{1, 0, 0, 1}, {0, 0, 0, 0}}));
  EXPECT_EQ(job.picture.shading.lights,
            (std::vector<Light>{{LightKind::kDirectional, {0, 2, 0}, {1, 0.5, 0}, 3}, Light{}}));
  EXPECT_EQ(job.picture.clipping.region, (VoxelBox{{1, 2, 3}, {4, 5, 6}}));
  ASSERT_EQ(job.picture.clipping.planes.size(), 7u);
  EXPECT_EQ(job.picture.clipping.planes[1], (ClipPlane{{-1, 0, 0}, 9}));
  EXPECT_EQ(job.picture.clipping.planes[6], (ClipPlane{{0, 0, -1}, 7}));
}

// sRGB 0.5 is 21.4 % light.
TEST(RenderJob, SrgbColoursAreDecoded) {
  const RenderJob job = parseJob(R"({"kiln": 2, "volume": "a", "transferFunction": {"colorSpace": "srgb",
      "points": [{"value": 0, "color": [0.5, 1, 0], "opacity": 1}]}})",
                                 "job.json");
  const auto& function = std::get<TransferFunction>(job.picture.transfer_function);
  EXPECT_NEAR(function.points[0].color.x, 0.21404, 1e-5);
  EXPECT_NEAR(function.points[0].color.y, 1, 1e-12);
  EXPECT_EQ(function.unit, 0);
}

struct WrongJob {
  const char* body;  // keys beside `volume`
  ErrorCode code;
  const char* message;  // part of the message
};

const WrongJob kWrongJobs[] = {
    {R"("camera": {"fvo": 60})", ErrorCode::kUsage, "job.json: line 1, camera.fvo: unknown key; did you mean 'fov'?"},
    {R"("camera": {"fov": "wide"})", ErrorCode::kUsage,
     "job.json: line 1, camera.fov: expected a number of degrees above 0 and below 180, found \"wide\""},
    {R"("camera": {"fov": 180})", ErrorCode::kUsage,
     "camera.fov: expected a number of degrees above 0 and below 180, found 180"},
    {R"("camera": {"eye": [1, 2]})", ErrorCode::kUsage, "camera.eye: expected [x, y, z]"},
    {R"("camera": {"eye": [1, 2, 1e31]})", ErrorCode::kUsage, "camera.eye"},
    {R"("camera": {"up": [1, null, 2]})", ErrorCode::kUsage, "camera.up"},
    {R"("camera": {"target": 3})", ErrorCode::kUsage, "camera.target"},
    {R"("camera": {"height": 0})", ErrorCode::kUsage, "camera.height"},
    {R"("camera": {"view": "face"})", ErrorCode::kUsage, "camera.view: expected \"front\", "},
    {R"("camera": {"projection": "fisheye"})", ErrorCode::kUsage, "camera.projection"},
    {R"("lens": {"aperture": -1})", ErrorCode::kUsage, "lens.aperture"},
    {R"("lens": {"aperture": 1, "focus": 0})", ErrorCode::kUsage, "lens.focus"},
    {R"("lens": {"eyes": 0})", ErrorCode::kUsage, "lens.eyes"},
    {R"("stereo": {"eye": "left"})", ErrorCode::kUsage, "stereo.interocular: is missing"},
    {R"("stereo": {"eye": "both", "interocular": 3, "keyframes": [{"frame": 1, "interocular": 3}]})", ErrorCode::kUsage,
     "stereo.interocular: is each keyframe's"},
    {R"("stereo": {"eye": "both", "keyframes": [{"frame": 1, "convergence": 3}]})", ErrorCode::kUsage,
     "stereo.keyframes[0].interocular: is missing"},
    {R"("stereo": {"eye": "both", "keyframes": [{"frame": 1, "interocular": 3}, {"frame": 2, "interocular": 3, "convergence": 5}]})",
     ErrorCode::kUsage, "a convergence in all keys or in none; that at frame 2 differs"},
    {R"("mode": "max")", ErrorCode::kUsage, "mode: expected \"composite\", "},
    {R"("part": "8/2")", ErrorCode::kUsage, "part: expected \"I/N\""},
    {R"("exr": {"compression": "gzip"})", ErrorCode::kUsage, "exr.compression: expected \"none\", "},
    {R"("skipDamaged": "yes")", ErrorCode::kUsage, "job.json: line 1, skipDamaged: expected"},
    {R"("camera": {"azimuth": true})", ErrorCode::kUsage, "camera.azimuth"},
    {R"("camera": {"elevation": 91})", ErrorCode::kUsage, "camera.elevation"},
    {R"("camera": {"zoom": 0})", ErrorCode::kUsage, "camera.zoom"},
    {R"("camera": [])", ErrorCode::kUsage, "camera: expected an object"},
    {R"("imgae": {})", ErrorCode::kUsage, "imgae: unknown key; did you mean 'image'?"},
    {R"("image": {"width": 0})", ErrorCode::kUsage,
     "image.width: expected a whole number of pixels from 1 to 65536, found 0"},
    {R"("image": {"height": 65537})", ErrorCode::kUsage, "image.height"},
    {R"("image": {"width": 10.5})", ErrorCode::kUsage, "image.width"},
    {R"("image": {"width": 1e300})", ErrorCode::kUsage, "image.width"},
    {R"("image": {"background": [0, 0, 0]})", ErrorCode::kUsage, "image.background"},
    {R"("image": {"background": [0, 0, 0, 2]})", ErrorCode::kUsage, "image.background"},
    {R"("transferFunction": "ct-bon")", ErrorCode::kUsage, "did you mean 'ct-bone'"},
    {R"("transferFunction": 3)", ErrorCode::kUsage, "transferFunction"},
    {R"("transferFunction": {})", ErrorCode::kUsage, "transferFunction.points"},
    {R"("transferFunction": {"points": []})", ErrorCode::kUsage, "transferFunction.points"},
    {R"("transferFunction": {"points": [3]})", ErrorCode::kUsage, "transferFunction.points[0]"},
    {R"("transferFunction": {"points": [{"value": 1, "opacity": 1}]})", ErrorCode::kUsage,
     "points[0].color: is missing"},
    {R"("transferFunction": {"points": [{"value": 1, "color": [0, 0, 2], "opacity": 1}]})", ErrorCode::kUsage,
     "points[0].color"},
    {R"("transferFunction": {"points": [{"value": 1, "color": [0, 0, 0], "opacity": 1.1}]})", ErrorCode::kUsage,
     "points[0].opacity"},
    {R"("transferFunction": {"points": [{"value": 2, "color": [0, 0, 0], "opacity": 1},
                                        {"value": 1, "color": [0, 0, 0], "opacity": 1}]})",
     ErrorCode::kUsage, "transferFunction.points[1].value"},
    {R"("transferFunction": {"colorSpace": "rec709", "points": []})", ErrorCode::kUsage, "transferFunction.colorSpace"},
    {R"("transferFunction": {"unit": -1, "points": []})", ErrorCode::kUsage, "transferFunction.unit"},
    {R"("shading": {"model": "toon"})", ErrorCode::kUsage, "shading.model"},
    {R"("shading": {"light": "sun"})", ErrorCode::kUsage, "shading.light"},
    {R"("shading": {"ambient": -1})", ErrorCode::kUsage, "shading.ambient"},
    {R"("shading": {"power": "16"})", ErrorCode::kUsage, "shading.power"},
    {R"("lights": {})", ErrorCode::kUsage, "lights.keyframes: expected a list"},
    {R"("lights": 3)", ErrorCode::kUsage, "lights: expected a list"},
    {R"("lights": [{}])", ErrorCode::kUsage, "lights[0].type: is missing"},
    {R"("lights": [{"type": "sun"}])", ErrorCode::kUsage, "lights[0].type: expected"},
    {R"("lights": [{"type": "directional"}])", ErrorCode::kUsage, "lights[0].direction: is missing"},
    {R"("lights": [{"type": "directional", "direction": [0, 0, 0]}])", ErrorCode::kUsage, "lights[0].direction"},
    {R"("lights": [{"type": "point", "direction": [0, 0, 1]}])", ErrorCode::kUsage, "lights[0].direction: unknown"},
    {R"("lights": [{"type": "headlight", "color": [1, 1, -1]}])", ErrorCode::kUsage, "lights[0].color"},
    {R"("lights": [{"type": "headlight", "color": "sun"}])", ErrorCode::kUsage, "lights[0].color: expected [red"},
    {R"("image": {"background": "#12345"})", ErrorCode::kUsage, "image.background: expected [red, green, blue, alpha]"},
    {R"("image": {"background": {"top": "sky", "bottom": "navy"}})", ErrorCode::kUsage,
     "image.background.top: expected"},
    {R"("lights": [{"type": "headlight", "intensity": -1}])", ErrorCode::kUsage, "lights[0].intensity"},
    {R"("region": [0, 0, 0, 1, 1])", ErrorCode::kUsage, "region: expected six whole numbers"},
    {R"("region": [0, 0, 0, 1, 0, 1])", ErrorCode::kUsage, "region"},
    {R"("region": [0, 0, 0, 1, 1, 1.5])", ErrorCode::kUsage, "region"},
    {R"("worldRegion": [0, 0, 0, 1, 0, 1])", ErrorCode::kUsage, "worldRegion"},
    {R"("clip": [{"normal": [0, 0, 0], "offset": 1}])", ErrorCode::kUsage, "clip[0].normal"},
    {R"("clip": [{"normal": [0, 0, 1]}])", ErrorCode::kUsage, "clip[0].offset: is missing"},
    {R"("window": [1, 0])", ErrorCode::kUsage, "window: expected [centre, width]"},
    {R"("image": {"background": {"top": [0, 0, 0, 1]}})", ErrorCode::kUsage, "image.background.bottom: is missing"},
    {R"("transferFunction": {"points": [{"value": 1, "color": [0, 0, 0], "opacity": 1}],
                             "gradientOpacity": [{"gradient": 2, "factor": 1}, {"gradient": 1, "factor": 1}]})",
     ErrorCode::kUsage, "gradientOpacity[1].gradient"},
    {R"("transferFunction": {"regions": [{"values": [1, 2]}]})", ErrorCode::kUsage,
     "regions[0].gradients: is missing; a region has values and gradients"},
    {R"("transferFunction": {"regions": [{"values": [2, 1], "gradients": [0, 1]}]})", ErrorCode::kUsage,
     "regions[0].values: expected [least, greatest]"},
    {R"("transferFunction": {"regions": [{"values": [1, 2], "gradients": [-1, 1]}]})", ErrorCode::kUsage,
     "regions[0].gradients: expected [least, greatest], the least 0 or above"},
    {R"("transferFunction": {"regions": [{"values": [1, 2], "gradients": [0, 1]}], "gradientOpacity": []})",
     ErrorCode::kUsage, "regions: contradicts gradientOpacity; leave one of them out"},
    {R"("transferFunction": {"table": {"values": [1, 2], "gradients": [0, 1], "opacity": [1, 1]}})", ErrorCode::kUsage,
     "table.columns: is missing; it is the number of factors of a row"},
    {R"("transferFunction": {"table": {"values": [1, 2], "gradients": [0, 1], "columns": 2, "opacity": [1, 1, 1]}})",
     ErrorCode::kUsage, "table.opacity: expected the name of a PNG file, or the numbers from 0 to 1 of all rows of 2"},
    {R"("transferFunction": {"table": {"values": [1, 2], "gradients": [0, 1], "columns": 2, "opacity": "x.png"}})",
     ErrorCode::kUsage, "table.columns: contradicts a picture"},
    {R"("transferFunction": {"surfaces": [{"value": 2}], "scattering": {}})", ErrorCode::kUsage,
     "scattering: contradicts surfaces"},
    {R"("transferFunction": {"points": [{"value": 1, "color": "red", "opacity": 1}], "shading": "none", "scattering": {}})",
     ErrorCode::kUsage, "transferFunction.shading: is none, which contradicts scattering"},
    {R"("section": {"window": [1, 0]})", ErrorCode::kUsage, "section.window: expected [centre, width]"},
    {R"("section": {"colormap": "teal"})", ErrorCode::kUsage, "section.colormap"},
    {R"("section": {"opacity": 2})", ErrorCode::kUsage, "section.opacity"},
    {R"("section": "tf")", ErrorCode::kUsage, "section: expected"},
    {R"("transferFunction": {"points": [{"value": 1, "color": "red", "opacity": 1}], "scattering": {"anisotropy": 1}})",
     ErrorCode::kUsage, "scattering.anisotropy"},
    {R"("transferFunction": {"surfaces": [{"value": 2}, {"value": 2}]})", ErrorCode::kUsage,
     "surfaces[1].value: expected a value above"},
    {R"("transferFunction": {"surfaces": [{"color": "red"}]})", ErrorCode::kUsage, "surfaces[0].value: is missing"},
    {R"("transferFunction": {"surfaces": []})", ErrorCode::kUsage, "surfaces: expected a list of at least one"},
    {R"("transferFunction": {"surfaces": [{"value": 2}], "points": []})", ErrorCode::kUsage,
     "points: contradicts surfaces"},
    {R"("transferFunction": {"points": [{"value": 1, "color": [0, 0, 0], "opacity": 1}],
                             "gradientOpacity": [{"gradient": 2, "factor": 2}]})",
     ErrorCode::kUsage, "gradientOpacity[0].factor"},
    {R"("visibility": {"method": "magic"})", ErrorCode::kUsage, "visibility.method"},
    {R"("visibility": {"area": "hexagon"})", ErrorCode::kUsage, "visibility.area"},
    {R"("visibility": {"samples": true})", ErrorCode::kUsage, "visibility.samples"},
    {R"("visibility": {"epsilon": -1})", ErrorCode::kUsage, "visibility.epsilon"},
    {R"("tile": -64)", ErrorCode::kUsage, "tile"},
    {R"("visibility": {"threshold": 0})", ErrorCode::kUsage, "visibility.threshold"},
    {R"("lattice": "hex")", ErrorCode::kUsage, "lattice"},
    {R"("interpolation": "nearest")", ErrorCode::kUsage, "interpolation"},
    {R"("sampleDistance": 0.2)", ErrorCode::kUsage, "sampleDistance"},
    {R"("sampleDistance": 1.5)", ErrorCode::kUsage, "sampleDistance"},
    {R"("sampleDistance": "far")", ErrorCode::kUsage, "sampleDistance"},
    {R"("level": 1.5)", ErrorCode::kUsage, "level"},
    {R"("level": "best")", ErrorCode::kUsage, "level"},
    {R"("level": -1)", ErrorCode::kUsage, "level"},
    {R"("memory": "lots")", ErrorCode::kUsage, "memory"},
    {R"("memory": [])", ErrorCode::kUsage, "memory"},
    {R"("threads": -1)", ErrorCode::kUsage, "threads"},
    {R"("exr": {"type": "double"})", ErrorCode::kUsage, "exr.type"},
    {R"("png": {"bits": 12})", ErrorCode::kUsage, "png.bits"},
    {R"("output": 3)", ErrorCode::kUsage, "output"},
    {R"("output": "")", ErrorCode::kUsage, "output"},
    {R"("output": "thesis.tex\u0000.png")", ErrorCode::kUsage, "line 1, output: expected a file name without a NUL"},
    {"\n\"trace\": \"t.json\\u0000\"", ErrorCode::kUsage, "line 2, trace: expected a file name without a NUL"},
    {R"("outputs": [{"path": "a\u0000.png"}])", ErrorCode::kUsage,
     "outputs[0].path: expected a file name without a NUL"},
    {R"("exr": {"owner": "\u0000"})", ErrorCode::kUsage, "exr.owner: expected a name without a NUL"},
    {R"("transferFunction": "f\u0000.json")", ErrorCode::kUsage, "transferFunction: expected a preset"},
    {R"("transferFunction": "iso:high")", ErrorCode::kUsage, "transferFunction: 'iso:high': expected surfaces"},
    {R"("threads": 1, "threads": 2)", ErrorCode::kFormat, "'threads' is given twice"},
    {"\"threads\": 1,\n\"level\" 0", ErrorCode::kFormat, "job.json: line 2, column 9"},
    {"\"memory\": 1e999", ErrorCode::kFormat, "line 1"},
    {R"("memory": NaN)", ErrorCode::kFormat, "line 1"},
    {"\"memory\": \"\xff\"", ErrorCode::kFormat, "line 1"},
};

TEST(RenderJob, EachMistakeNamesItsKey) {
  for (const WrongJob& wrong : kWrongJobs) {
    try {
      parseJob(std::string(R"({"kiln": 2, "volume": "a.kiln", )") + wrong.body + "}", "job.json");
      ADD_FAILURE() << "not refused: " << wrong.body;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), wrong.code) << wrong.body << "\n" << error.what();
      EXPECT_NE(std::string(error.what()).find(wrong.message), std::string::npos) << wrong.body << "\n" << error.what();
    }
  }
}

TEST(RenderJob, AJob_namesItsFormat) {
  const auto refusal = [](const char* text) -> std::string {
    try {
      parseJob(text, "job.json");
      return "";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      return error.what();
    }
  };
  EXPECT_EQ(refusal(R"({"volume": "a.kiln"})"),
            "job.json: line 1, kiln: is missing; add \"kiln\": 2, the version of the job format");
  EXPECT_EQ(refusal(R"({"kiln": 3, "volume": "a.kiln"})"),
            "job.json: line 1, kiln: expected a whole number from 1 to 2, found 3");
  for (const char* wrong :
       {R"({"kiln": 0, "volume": "a"})", R"({"kiln": "2", "volume": "a"})", R"({"kiln": 1.5, "volume": "a"})"})
    EXPECT_NE(refusal(wrong).find("kiln: expected "), std::string::npos) << wrong;
  for (const char* right : {R"({"kiln": 1, "volume": "a"})", R"({"kiln": 2, "volume": "a"})"})
    EXPECT_EQ(refusal(right), "");
}

// Colours by name are sRGB; numbers of lights and backgrounds are linear in both formats.
TEST(RenderJob, LightsAndBackgrounds_haveColoursByName) {
  for (const std::string format : {"1", "2"}) {
    const auto picture = [&](const std::string& keys) {
      return parseJob(R"({"kiln": )" + format + R"(, "volume": "a", )" + keys + "}", "job.json").picture;
    };
    const glm::dvec3 orange = *colorNamed("orange");
    const std::array<double, 4> opaque = {orange.r, orange.g, orange.b, 1};
    EXPECT_EQ(picture(R"("image": {"background": "orange"})").background, (Background{opaque, opaque}));
    EXPECT_EQ(picture(R"("image": {"background": {"top": "#ffa500", "bottom": "transparent"}})").background,
              (Background{opaque, {}}));
    EXPECT_EQ(picture(R"("image": {"background": [0.5, 0.5, 0.5, 1]})").background->top[0], 0.5);
    const auto lights = picture(R"("lights": [{"type": "headlight", "color": "Orange"},
                                              {"type": "headlight", "color": [0.5, 2, 3]}])")
                            .shading.lights;
    EXPECT_EQ(lights[0].color, orange);
    EXPECT_EQ(lights[1].color, glm::dvec3(0.5, 2, 3));
  }
}

// Truncated at any length, the example is no job, and the exception is always kiln::Error.
TEST(RenderJob, BackgroundOfProjectedValues_isTheColourOfTheLowEnd) {
  PictureOptions picture;
  picture.mode = Mode::kMip;
  TransferFunction function;
  function.points = {{0, {0.25, 0.5, 0.75}, 0}, {1, {1, 1, 1}, 1}};
  const Background low{{0.25, 0.5, 0.75, 1}, {0.25, 0.5, 0.75, 1}};
  EXPECT_EQ(backgroundOf(picture, function), low);
  EXPECT_EQ(frameRequest(picture, {}, Camera(), function).background, low);
  picture.background = Background{{1, 0, 0, 1}, {0, 0, 0, 0}};
  EXPECT_EQ(frameRequest(picture, {}, Camera(), function).background, *picture.background);
  picture = {};
  EXPECT_EQ(frameRequest(picture, {}, Camera(), function).background, Background());
}

TEST(RenderJob, TruncatedTextIsMalformed) {
  const std::string whole = kExample;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    test::expectError([&] { parseJob(whole.substr(0, length), "job.json"); }, ErrorCode::kFormat, "");
  }
  EXPECT_THROW(parseJob("[]", "job.json"), Error);
  EXPECT_THROW(parseJob("{}", "job.json"), Error);
  EXPECT_THROW(parseJob(std::string(100000, '['), "job.json"), Error);
}

// The JSON library takes a NUL for the end of the text, and would pass over everything behind it.
TEST(RenderJob, ANulByteAnywhereIsMalformed) {
  const std::string whole = kExample;
  for (const std::size_t place : {std::size_t{0}, whole.find("//") + 3, whole.find("head"), whole.size()}) {
    std::string text = whole;
    text.insert(place, 1, '\0');
    test::expectError([&] { parseJob(text, "job.json"); }, ErrorCode::kFormat, "NUL byte");
  }
}

TEST(RenderJob, ErrorsOfTheJsonLibraryLoseTheirCodes) {
  EXPECT_EQ(readableJsonError("[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while x"),
            "syntax error while x");
  EXPECT_EQ(readableJsonError("[json.exception.out_of_range.403] key 'dims' not found"), "key 'dims' not found");
}

void expectSamePicture(const RenderJob& a, const RenderJob& b) {
  EXPECT_EQ(a.volume, b.volume);
  EXPECT_EQ(a.picture.size.width, b.picture.size.width);
  EXPECT_EQ(a.picture.size.height, b.picture.size.height);
  EXPECT_EQ(a.picture.background, b.picture.background);
  EXPECT_EQ(a.picture.opacity_threshold, b.picture.opacity_threshold);
  EXPECT_EQ(a.picture.shading, b.picture.shading);
  EXPECT_EQ(a.picture.display, b.picture.display);
  EXPECT_EQ(a.picture.annotations, b.picture.annotations);
  EXPECT_EQ(a.picture.clipping, b.picture.clipping);
  EXPECT_EQ(a.picture.clipping.section, b.picture.clipping.section);
  EXPECT_EQ(a.picture.lattice, b.picture.lattice);
  EXPECT_EQ(a.picture.interpolation, b.picture.interpolation);
  EXPECT_EQ(a.picture.sample_distance, b.picture.sample_distance);
  EXPECT_EQ(a.picture.level, b.picture.level);
  EXPECT_EQ(a.picture.crop, b.picture.crop);
  EXPECT_EQ(a.picture.samples, b.picture.samples);
  EXPECT_EQ(a.picture.aovs, b.picture.aovs);
  EXPECT_EQ(a.picture.mode, b.picture.mode);
  EXPECT_EQ(a.picture.stereo, b.picture.stereo);
  EXPECT_EQ(a.picture.lens, b.picture.lens);
  EXPECT_EQ(a.picture.part, b.picture.part);
  EXPECT_EQ(a.picture.skip_damaged, b.picture.skip_damaged);
}

TEST(RenderJob, ALevelIsANumberOrAuto) {
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a.kiln", "level": 3})", "job.json").picture.level, 3);
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a.kiln", "level": 0})", "job.json").picture.level, 0);
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a.kiln", "level": "auto"})", "job.json").picture.level, std::nullopt);
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a.kiln"})", "job.json").picture.level, std::nullopt);
}

TEST(RenderJob, Interpolation_inTheVoxelLattice_isRefused) {
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a.kiln"})", "job.json").picture.interpolation, Interpolation::kLinear);
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a.kiln", "interpolation": "cubic"})", "job.json").picture.interpolation,
            Interpolation::kCubic);
  PictureOptions picture;
  picture.interpolation = Interpolation::kCatmullRom;
  EXPECT_NO_THROW(requireEngineOptions(picture));
  picture.lattice = Lattice::kVoxel;
  picture.interpolation = Interpolation::kLinear;
  EXPECT_NO_THROW(requireEngineOptions(picture));
  picture.interpolation = Interpolation::kCatmullRom;
  test::expectError([&] { requireEngineOptions(picture); }, ErrorCode::kUsage, "--interpolation catmull-rom: needs");
}

TEST(RenderJob, RayIsAnotherNameOfThePixelLattice) {
  const RenderJob job =
      parseJob(R"({"kiln": 2, "volume": "a.kiln", "lattice": "ray", "sampleDistance": 0.75})", "job.json");
  EXPECT_EQ(job.picture.lattice, Lattice::kPixel);
  EXPECT_EQ(job.picture.sample_distance, 0.75);
  PictureOptions picture = job.picture;
  EXPECT_NO_THROW(requireEngineOptions(picture));
  picture.lattice = Lattice::kVoxel;
  EXPECT_THROW(requireEngineOptions(picture), Error);
  picture.sample_distance = kSampleDistance;
  EXPECT_NO_THROW(requireEngineOptions(picture));
  picture.mode = Mode::kMip;
  EXPECT_THROW(requireEngineOptions(picture), Error);
}

TEST(RenderJob, ModesPartsAndWhatAnExrHolds) {
  const RenderJob job =
      parseJob(R"({"kiln": 2, "volume": "a", "mode": "minip", "image": {"aov": ["value"]}, "part": "2/8",
      "stereo": {"eye": "right", "interocular": 6.5, "convergence": 90},
      "exr": {"compression": "piz", "owner": "we", "comments": "take 3", "statistics": true}})",
               "job.json");
  EXPECT_EQ(job.picture.mode, Mode::kMinip);
  EXPECT_EQ(job.picture.aovs, (Aovs{false, false, true}));
  EXPECT_EQ(job.picture.part, (PartNumber{2, 8}));
  EXPECT_EQ(job.picture.stereo, (Stereo{StereoEye::kRight, 6.5, 90.0}));
  EXPECT_EQ(job.output.exr_compression, "piz");
  EXPECT_EQ(job.output.owner, "we");
  EXPECT_EQ(job.output.comments, "take 3");
  EXPECT_TRUE(job.output.statistics_in_header);
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a", "part": [0, 1, 2, 3, 4, 5]})", "job.json").picture.clipping.part,
            (VoxelBox{{0, 1, 2}, {3, 4, 5}}));
}

TEST(RenderJob, ACropIsFourWholeNumbers) {
  const RenderJob job =
      parseJob(R"({"kiln": 2, "volume": "a.kiln", "image": {"width": 64, "crop": [5, 6, 20, 30]}})", "job.json");
  EXPECT_EQ(job.picture.crop, (PixelRect{5, 6, 25, 36}));
  for (const char* wrong : {"[5, 6, 20]", "[5, 6, 20, -1]", "[5, 6.5, 20, 1]", "\"all\""}) {
    test::expectError(
        [&] {
          parseJob(std::string(R"({"kiln": 2, "volume": "a.kiln", "image": {"crop": )") + wrong + "}}", "job.json");
        },
        ErrorCode::kUsage, "image.crop");
  }
}

TEST(RenderJob, AovsAreAList) {
  const auto aovs = [](const std::string& list) {
    return parseJob(R"({"kiln": 2, "volume": "a.kiln", "image": {"aov": )" + list + "}}", "job.json").picture.aovs;
  };
  EXPECT_EQ(aovs("[]"), Aovs());
  EXPECT_EQ(aovs(R"(["normal"])"), (Aovs{false, true}));
  EXPECT_EQ(aovs(R"(["normal", "depth"])"), (Aovs{true, true}));
  for (const char* wrong : {R"("depth")", R"(["alpha"])", R"(["depth", "depth"])"}) {
    test::expectError([&] { aovs(wrong); }, ErrorCode::kUsage, "image.aov");
  }
}

TEST(RenderJob, SamplesAreOneTwoFourSixteenOrAuto) {
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a.kiln"})", "job.json").picture.samples, std::nullopt);
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a.kiln", "samples": "auto"})", "job.json").picture.samples,
            std::nullopt);
  EXPECT_EQ(parseJob(R"({"kiln": 2, "volume": "a.kiln", "samples": 16})", "job.json").picture.samples, 16);
  EXPECT_EQ(subPixelsAlongEdge(16), 4);
  EXPECT_EQ(subPixelsAlongEdge(2), 2);
  PictureOptions picture;
  for (const int samples : {2, 4}) {
    picture.samples = samples;
    EXPECT_NO_THROW(requireEngineOptions(picture));
  }
  picture.lattice = Lattice::kVoxel;
  EXPECT_NO_THROW(requireEngineOptions(picture));
  picture.samples = 2;
  EXPECT_THROW(requireEngineOptions(picture), Error);
  for (const char* wrong : {"0", "3", "9", "64", "\"4\""}) {
    test::expectError(
        [&] { parseJob(std::string(R"({"kiln": 2, "volume": "a.kiln", "samples": )") + wrong + "}", "job.json"); },
        ErrorCode::kUsage, "samples");
  }
}

// Values without a short decimal form, so that rounding would be visible.
TEST(RenderJob, ResolvedTextIsTheSamePicture) {
  RenderJob job = parseJob(kExample, "job.json");
  job.picture.shading.phong = false;
  job.picture.opacity_threshold = 1 / 1.1;
  job.picture.skip_damaged = true;
  job.picture.samples = 4;
  job.picture.crop = PixelRect{3, 4, 50, 61};
  job.picture.background = Background{{0, 0.25, 0, 0.5}, {1 / 3.0, 0, 1 / 7.0, 1}};
  job.picture.shading.lights = {{LightKind::kPoint, {1 / 3.0, 2, -1 / 7.0}, {1 / 9.0, 2, 3}, 1 / 1.1},
                                {LightKind::kDirectional, {1 / 3.0, 2, -1 / 7.0}},
                                {LightKind::kHeadlight, {0, 0, 1}, {1, 0, 1 / 3.0}}};
  job.picture.clipping = {VoxelBox{{1, -2, 3}, {40, 50, 60}},
                          {{{1 / 3.0, 0, -1 / 7.0}, 1 / 9.0}, {{0, 0, 1}, -3}},
                          VoxelBox{{5, 0, 0}, {9, 8, 7}}};
  job.picture.clipping.section = Section{"viridis", glm::dvec2{1 / 3.0, 1 / 7.0}, 1 / 9.0};
  const TransferFunction function{
      1 / 3.0, {{-1 / 7.0, {0.1, 1 / 3.0, 0}, 0}, {1e30, {1, 0, 0.7}, 1 / 9.0}}, {{1 / 7.0, 0}, {3, 1 / 3.0}}};
  Camera camera;
  camera.eye = {1 / 3.0, -1e5 / 7, 2};
  camera.fov_deg = 100 / 3.0;
  camera.height = 10 / 3.0;
  for (const Projection projection : {Projection::kPerspective, Projection::kOrthographic}) {
    camera.projection = projection;
    if (projection == Projection::kOrthographic) job.picture.level = 2;
    job.picture.lattice = projection == Projection::kOrthographic ? Lattice::kPixel : Lattice::kVoxel;
    if (job.picture.lattice == Lattice::kPixel) job.picture.interpolation = Interpolation::kCatmullRom;
    if (job.picture.lattice == Lattice::kPixel) job.picture.sample_distance = 2 / 3.0;
    if (projection == Projection::kOrthographic) job.picture.mode = Mode::kAverage;
    job.picture.stereo = Stereo{StereoEye::kLeft, 1 / 3.0, {}};
    job.picture.aovs = {true, projection == Projection::kOrthographic};
    job.picture.display = {-1 / 3.0, Tone::kSoft};
    const std::string text = resolvedJobText(job, camera, function);
    const RenderJob again = parseJob(text, "job.json");
    expectSamePicture(job, again);
    const Camera seen = again.picture.camera.resolve(VolumeGeometry{}, {64, 64});
    EXPECT_EQ(seen.projection, projection);
    EXPECT_EQ(seen.eye, camera.eye);
    EXPECT_EQ(seen.target, camera.target);
    EXPECT_EQ(seen.up, camera.up);
    if (projection == Projection::kPerspective)
      EXPECT_EQ(seen.fov_deg, camera.fov_deg);
    else
      EXPECT_EQ(seen.height, camera.height);
    const auto& points = std::get<TransferFunction>(again.picture.transfer_function).points;
    ASSERT_EQ(points.size(), 2u);
    EXPECT_EQ(points[0].value, -1 / 7.0);
    EXPECT_EQ(points[0].color, glm::dvec3(0.1, 1 / 3.0, 0));
    EXPECT_EQ(points[1].opacity, 1 / 9.0);
    EXPECT_EQ(std::get<TransferFunction>(again.picture.transfer_function).gradientFactor(0, 2),
              function.gradientFactor(0, 2));
    EXPECT_EQ(std::get<TransferFunction>(again.picture.transfer_function).unit, 1 / 3.0);
    EXPECT_EQ(text, resolvedJobText(again, seen, std::get<TransferFunction>(again.picture.transfer_function)));
  }
}

// Equal pictures have equal headers: options for speed and output paths are not in the text.
TEST(RenderJob, ResolvedTextLeavesOutHowFastAndWhereTo) {
  RenderJob job = parseJob(kExample, "job.json");
  const std::string text = resolvedJobText(job, Camera{}, {});
  job.speed = SpeedOptions{};
  job.output = OutputOptions{};
  EXPECT_EQ(text, resolvedJobText(job, Camera{}, {}));
}

// Keys of another format say nothing about the picture.
TEST(RenderJob, ADifferenceOfFormatsIsOfKilns) {
  const std::string first = R"({"kiln": 1, "shading": {"ambient": 0.2}})",
                    second = R"({"kiln": 2, "shading": {"ambient": 0.3}})";
  EXPECT_EQ(jobDifference(first, second), "it was drawn by an earlier Kiln, whose jobs have format 1 instead of 2");
  EXPECT_EQ(jobDifference(second, first), "it was drawn by a later Kiln, whose jobs have format 2 instead of 1");
  EXPECT_EQ(jobDifference(second, R"({"kiln": 2, "shading": {"ambient": 0.5}})"),
            "shading.ambient is 0.3 there and 0.5 here");
}

// Known because each key is written by hand.
TEST(RenderJob, DifferencesOfTheCameraComeLast_andAListIsOneDifference) {
  const auto job = [](const char* eye, const char* points) {
    return fmt::format(R"({{"kiln": 2, "camera": {{"eye": {}, "target": [0, 0, 0]}},
                            "transferFunction": {{"points": {}}}}})",
                       eye, points);
  };
  const std::string a = job("[0, -1000.25, 3]", R"([{"value": 1, "opacity": 0}, {"value": 2, "opacity": 1}])"),
                    b = job("[1, -900, 4]", R"([{"value": 3, "opacity": 0.5}, {"value": 4, "opacity": 1}])"),
                    c = job("[0, -1000.25, 3]", R"([{"value": 1, "opacity": 0}, {"value": 5, "opacity": 1}])");
  EXPECT_EQ(jobDifference(a, b),
            "transferFunction.points differs in 2 of 2 entries, camera.eye is [0, -1000.25, 3] there and "
            "[1, -900, 4] here");
  EXPECT_EQ(jobDifference(a, c), "transferFunction.points[1].value is 2 there and 5 here");
  EXPECT_EQ(jobDifference(a, a), "");
}

TEST(RenderJob, FilesAreReadAndMissingOnesNamed) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("kiln_render_job_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "job.json") << kExample;
  std::ofstream(folder / "tf.json") << R"({"points": [{"value": 3, "color": [1, 1, 1], "opacity": 0.5}]})";
  std::ofstream(folder / "bad.json") << R"({"points": [{"value": 3, "color": [1, 1, 1], "opacity": 5}]})";
  EXPECT_EQ(readJob(folder / "job.json").volume, folder / "head.kiln");
  EXPECT_EQ(readTransferFunction(folder / "tf.json", Manifest{}).at(3).opacity, 0.5);
  try {
    readTransferFunction(folder / "bad.json", Manifest{});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("bad.json: line 1, points[0].opacity"), std::string::npos) << error.what();
  }
  test::expectError([&] { readJob(folder / "none.json"); }, ErrorCode::kNotFound, "");
  std::filesystem::remove_all(folder);
}

TEST(RenderJobRun, NoRepetition_isRefused) {
  Progress silent;
  for (const int repeat : {0, -1})
    test::expectError([&] { runRenderJob(RenderJob(), repeat, silent); }, ErrorCode::kUsage, "repeat");
}

}  // namespace
}  // namespace kiln

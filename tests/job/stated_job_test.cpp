// Known: a stated job, read again, states and resolves to the same; options that are given for a job make that job.
#include "job/stated_job.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "job/command/job_command.h"
#include "job/job_facts.h"

namespace kiln {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

RenderJob jobOf(json keys) {
  keys["kiln"] = 2;
  if (!keys.contains("volumes")) keys["volume"] = "v.kiln";
  return parseJob(keys.dump(), "job.json");
}

const std::vector<json>& jobs() {
  static const std::vector<json> all = {
      json::object(),
      {{"camera", {{"view", "left"}, {"zoom", 2}, {"pan", {0.1, -0.2}}, {"fit", "box"}}}},
      {{"camera",
        {{"projection", "orthographic"},
         {"eye", {1, 2, 3}},
         {"target", {0, 0, 0.1}},
         {"up", {0, 0, 1}},
         {"height", 5}}}},
      {{"transferFunction", "ct-bone"}, {"window", {100, 20.5}}, {"mode", "mip"}},
      {{"transferFunction", "300:0,500:0.5:#ff8000"}},
      {{"transferFunction", {{"unit", 1.5}, {"points", {{{"value", 1}, {"color", {1, 0.5, 0}}, {"opacity", 0.2}}}}}}},
      {{"transferFunction",
        {{"keyframes", {{{"frame", 1}, {"function", "fog"}}, {{"frame", 9}, {"function", "1:0,2:1"}}}}}}},
      {{"look", "studio"}, {"samples", 4}, {"sampleDistance", 0.25}},
      {{"lights", {{{"type", "camera"}, {"direction", {1, 1, 1}}, {"intensity", 2}, {"shadow", {{"softness", 3}}}}}},
       {"shading", {{"ambient", 0.5}, {"ambientOcclusion", {{"strength", 0.5}, {"radius", 7}, {"occludes", "all"}}}}}},
      {{"lights",
        {{"keyframes", {{{"frame", 1}, {"lights", json::array()}}, {{"frame", 5}, {"lights", json::array()}}}}}}},
      {{"clip", {{{"normal", {1, 0, 0}}, {"offset", 4}}}},
       {"worldRegion", {0, 1, 2, 3, 4, 5}},
       {"region", {1, 2, 3, 9, 9, 9}}},
      {{"clip", {{"keyframes", {{{"frame", 1}, {"planes", {{{"normal", {1, 0, 0}}, {"offset", 4}}}}}}}}}},
      {{"camera", {{"turntable", {{"frames", 12}, {"degrees", 90}, {"axis", {0, 1, 0}}}}}}},
      {{"camera",
        {{"keyframes", {{{"frame", 1}, {"view", "front"}}, {{"frame", 5.5}, {"ease", "stop"}, {"azimuth", 20}}}},
         {"pivot", "target"}}}},
      {{"camera", {{"matrices", {{{1, 0, 0, 5}, {0, 0, -1, 6}, {0, 1, 0, 7}, {0, 0, 0, 1}}}}}}},
      {{"stereo", {{"eye", "both"}, {"interocular", 6.5}, {"convergence", 300}}}},
      {{"stereo",
        {{"eye", "left"}, {"keyframes", {{{"frame", 1}, {"interocular", 6}}, {{"frame", 4}, {"interocular", 7}}}}}}},
      {{"image", {{"width", 640}, {"background", "navy"}, {"crop", {1, 2, 3, 4}}, {"aov", {"depth"}}}},
       {"level", "auto+1"}},
      {{"visibility", {{"method", "quadtree"}, {"threshold", 0.9}}},
       {"lattice", "voxel"},
       {"display", {{"exposure", 1}, {"tone", "soft"}}}},
      {{"volumes",
        {{{"volume", "a"}, {"transferFunction", "ct-bone"}, {"window", {1, 2}}},
         {{"volume", "b"},
          {"labels", true},
          {"shading", {{"ambient", 0.7}}},
          {"clip", {{{"normal", {0, 1, 0}}, {"offset", 1}}}},
          {"region", {0, 0, 0, 4, 4, 4}},
          {"worldRegion", {0, 0, 0, 9, 9, 9}}}}}},
  };
  return all;
}

TEST(StatedJob, ReadAgain_isTheJob) {
  for (const json& keys : jobs()) {
    const RenderJob job = jobOf(keys);
    const ordered_json stated = statedJson(job);
    json with_files = json::parse(stated.dump());
    for (std::size_t i = 0; i < job.volumes.size(); ++i) with_files["volumes"][i]["volume"] = job.volumes[i].volume;
    const RenderJob again = jobOf(with_files);
    EXPECT_EQ(statedJson(again), stated) << keys;
    EXPECT_EQ(resolvedJobText(again, {}, {}), resolvedJobText(job, {}, {})) << keys;
    EXPECT_EQ(framesOf(again), framesOf(job)) << keys;
    EXPECT_EQ(again.animation.camera.index(), job.animation.camera.index()) << keys;
    EXPECT_EQ(again.picture.clipping.box_faces, job.picture.clipping.box_faces) << keys;
  }
}

TEST(StatedJob, DefaultsAreLeftOut) {
  EXPECT_EQ(statedJson(RenderJob()), (ordered_json{{"kiln", 2}}));
  EXPECT_EQ(statedJson(jobOf({{"camera", {{"view", "left"}}}, {"samples", "auto"}, {"output", "x.png"}})),
            (ordered_json{{"kiln", 2}, {"camera", {{"view", "left"}}}}));
}

TEST(JobCommand, Options_stateSimpleJobs) {
  const auto text = [](const json& keys) {
    std::string out;
    const auto options = optionsOf(jobOf(keys));
    if (!options) return std::string("none");
    for (const std::string& option : *options) out += (out.empty() ? "" : " ") + option;
    return out;
  };
  EXPECT_EQ(text(json::object()), "");
  EXPECT_EQ(text({{"visibility", {{"method", "quadtree"}}}}), "--visibility quadtree");
  EXPECT_EQ(text({{"transferFunction", "ct-bone"}, {"camera", {{"view", "left"}, {"zoom", 1.5}}}}),
            "--view left --zoom 1.5 --tf ct-bone");
  EXPECT_EQ(text({{"look", "studio"}, {"image", {{"background", {0, 0.5, 0, 1}}}}}),
            "--background 0,0.5,0 --look studio");
  EXPECT_EQ(text({{"transferFunction", "300:0,500:0.5:#ff8000"}, {"window", {100, 20}}}),
            "--tf 300:0:#ff8000,500:0.5:#ff8000 --window 100,20");
  EXPECT_EQ(
      text({{"lights",
             {{{"type", "directional"}, {"direction", {1, -1, 0.5}}}, {{"type", "headlight"}, {"color", {1, 0, 0}}}}},
            {"clip", {{{"normal", {1, 0, 0}}, {"offset", 4}}}},
            {"worldRegion", {0, 1, 2, 3, 4, 5}}}),
      "--light dir:1,-1,0.5 --light headlight:1,0,0 --world-region 0,1,2,3,4,5 --clip 1,0,0,4");
  EXPECT_EQ(text({{"camera", {{"turntable", {{"frames", 12}}}}}}), "--turntable 12");
  // Options cannot state these.
  EXPECT_EQ(
      text({{"transferFunction", {{"unit", 1.5}, {"points", {{{"value", 1}, {"color", "red"}, {"opacity", 0.2}}}}}}}),
      "none");
  EXPECT_EQ(text({{"camera", {{"turntable", {{"frames", 12}, {"degrees", 90}}}}}}), "none");
  EXPECT_EQ(text({{"lights", {{{"type", "headlight"}, {"intensity", 2}}}}}), "none");
  EXPECT_EQ(text({{"lights", json::array()}}), "none");
  EXPECT_EQ(text({{"volumes", {{{"volume", "a"}}}}}), "none");
}

}  // namespace
}  // namespace kiln

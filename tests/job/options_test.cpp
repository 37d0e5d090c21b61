// A flag is another spelling of a key of a job. Known: both give the same job, and refuse the same values.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>

#include "base/error.h"
#include "job/command/given_flags.h"
#include "job/job_flags.h"
#include "job/job_options.h"
#include "job/render_job.h"
#include "scene/sampling.h"
#include "support/volumes/test_store.h"

namespace kiln {
namespace {

const JobFlag& flagNamed(const std::string& name) {
  for (const JobFlag& flag : jobFlags()) {
    if (flag.flag == name || flag.flag.ends_with("," + name)) return flag;
  }
  throw std::out_of_range(name);
}

RenderJob jobOfFlag(const std::string& name, const std::vector<std::string>& texts) {
  RenderJob job = parseJob(R"({"kiln": 2, "volume": "a.kiln"})", "job.json");
  flagNamed(name).apply(texts, job);
  return job;
}

// The value of every option, whether the resolved job has it or not.
nlohmann::ordered_json allValues(const Options<RenderJob>& options, const RenderJob& job) {
  nlohmann::ordered_json out;
  for (const Option<RenderJob>& option : options) {
    if (!option.value.inside.empty())
      out[std::string(option.key)] = allValues(option.value.inside, job);
    else if (option.value.write)
      out[std::string(option.key)] = option.value.write(job);
  }
  return out;
}

struct Pair {
  const char* flag;
  std::vector<std::string> texts;
  const char* json;
};

const Pair kPairs[] = {
    {"--size", {"640x480"}, R"("image": {"width": 640, "height": 480})"},
    {"--crop", {"1,2,3,4"}, R"("image": {"crop": [1, 2, 3, 4]})"},
    {"--background",
     {"0.1,0.2,0.3:1,1,1"},
     R"("image": {"background": {"top": [0.1, 0.2, 0.3, 1], "bottom": [1, 1, 1, 1]}})"},
    {"--background", {"navy"}, R"("image": {"background": "navy"})"},
    {"--background", {"#abc:transparent"}, R"("image": {"background": {"top": "#aabbcc", "bottom": [0, 0, 0, 0]}})"},
    {"--background",
     {"0.5,0.5,0.5:white"},
     R"("image": {"background": {"top": [0.5, 0.5, 0.5, 1], "bottom": "white"}})"},
    {"--aov", {"normal", "depth", "depth"}, R"("image": {"aov": ["depth", "normal"]})"},
    {"--mask", {"organs.kiln:3,7"}, R"("mask": {"volume": "organs.kiln", "labels": [3, 7]})"},
    {"--mask", {"organs.kiln:-4--3,7-9"}, R"("mask": {"volume": "organs.kiln", "labels": [-4, -3, 7, 8, 9]})"},
    {"--mask", {"phantom:head:40:-2"}, R"("mask": {"volume": "phantom:head:40", "labels": [-2]})"},
    {"--color-by", {"pet.kiln"}, R"("colorBy": {"volume": "pet.kiln"})"},
    {"--color-by", {"pet.kiln:fire"}, R"("colorBy": {"volume": "pet.kiln", "transferFunction": "fire"})"},
    {"--color-by",
     {"pet.kiln:0:0,9:0.5:#f80"},
     R"("colorBy": {"volume": "pet.kiln", "transferFunction": "0:0,9:0.5:#f80"})"},
    {"--section", {"tf"}, R"("section": true)"},
    {"--section", {"on"}, R"("section": true)"},
    {"--section", {"off"}, R"("section": false)"},
    {"--section", {"40,400"}, R"("section": {"window": [40, 400]})"},
    {"--section", {"40,400:viridis"}, R"("section": {"window": [40, 400], "colormap": "viridis"})"},
    {"--section", {"fire"}, R"("section": {"colormap": "fire"})"},
    {"--mode", {"attenuated-mip"}, R"("mode": "attenuated-mip")"},
    {"--attenuation", {"0.25"}, R"("attenuation": 0.25)"},
    {"--channel-colors", {"magenta:#0f0"}, R"("channelColors": ["magenta", "#00ff00"])"},
    {"--fov", {"33.5"}, R"("camera": {"fov": 33.5})"},
    {"--aperture", {"2.5"}, R"("lens": {"aperture": 2.5})"},
    {"--focus", {"300"}, R"("lens": {"focus": 300})"},
    {"--aperture-eyes", {"20"}, R"("lens": {"eyes": 20})"},
    {"--eye", {"1,-2,3e2"}, R"("camera": {"eye": [1, -2, 300]})"},
    {"--view", {"left"}, R"("camera": {"view": "left"})"},
    {"--view", {"anterior"}, R"("camera": {"view": "front"})"},
    {"--view", {"posterior"}, R"("camera": {"view": "back"})"},
    {"--view", {"superior"}, R"("camera": {"view": "top"})"},
    {"--view", {"inferior"}, R"("camera": {"view": "bottom"})"},
    {"--roll", {"-12.5"}, R"("camera": {"roll": -12.5})"},
    {"--legend-position", {"bottom-left"}, R"("annotations": {"legendPosition": "bottom-left"})"},
    {"--scale-bar-length", {"12.5"}, R"("annotations": {"scaleBarLength": 12.5})"},
    {"--fit", {"box"}, R"("camera": {"fit": "box"})"},
    {"--pan", {"0.25,-0.5"}, R"("camera": {"pan": [0.25, -0.5]})"},
    {"--turntable", {"36"}, R"("camera": {"turntable": {"frames": 36}})"},
    {"--tf", {"ct-bone"}, R"("transferFunction": "ct-bone")"},
    {"--tf", {"300:0,500:0.5:#f80"}, R"("transferFunction": "300:0,500:0.5:#f80")"},
    {"--tf",
     {"300:0,500:0.5:#f80"},
     R"("transferFunction": {"points": [{"value": 300, "color": "#f80", "opacity": 0},
                                        {"value": 500, "color": "#f80", "opacity": 0.5}]})"},
    {"--tf", {"iso:300:0.5:#f80,1200"}, R"("transferFunction": "iso:300:0.5:#f80,1200")"},
    {"--window", {"40,400"}, R"("window": [40, 400])"},
    {"--shading", {"none"}, R"("shading": {"model": "none"})"},
    {"--power", {"3"}, R"("shading": {"power": 3})"},
    {"--shadows", {}, R"("shading": {"shadows": true})"},
    {"--ambient-occlusion", {"0.5"}, R"("shading": {"ambientOcclusion": 0.5})"},
    {"--ambient-occlusion",
     {"0.5:20"},
     R"("shading": {"ambientOcclusion": {"strength": 0.5, "radius": 20, "occludes": "ambient"}})"},
    {"--light",
     {"point:1,2,3:1,0.5,0", "headlight", "dir:0,0,1"},
     R"("lights": [{"type": "point", "position": [1, 2, 3], "color": [1, 0.5, 0]}, {"type": "headlight"},
        {"type": "directional", "direction": [0, 0, 1]}])"},
    {"--light",
     {"headlight:orange", "dir:0,0,1:#fff"},
     R"("lights": [{"type": "headlight", "color": "#ffa500"},
                   {"type": "directional", "direction": [0, 0, 1], "color": [1, 1, 1]}])"},
    {"--light", {"cam:1,2,3"}, R"("lights": [{"type": "camera", "direction": [1, 2, 3]}])"},
    {"--look", {"studio"}, R"("look": "studio")"},
    {"--exposure", {"-1.5"}, R"("display": {"exposure": -1.5})"},
    {"--tone", {"soft"}, R"("display": {"tone": "soft"})"},
    {"--region", {"0,1,2,3,4,5"}, R"("region": [0, 1, 2, 3, 4, 5])"},
    {"--world-region", {"0,0,0,1,1,1.5"}, R"("worldRegion": [0, 0, 0, 1, 1, 1.5])"},
    {"--clip",
     {"1,0,0,-8", "0,0,-1,9"},
     R"("clip": [{"normal": [1, 0, 0], "offset": -8}, {"normal": [0, 0, -1], "offset": 9}])"},
    {"--scale-bar", {}, R"("annotations": {"scaleBar": true})"},
    {"--box", {}, R"("annotations": {"box": true})"},
    {"--legend", {}, R"("annotations": {"legend": true})"},
    {"--legend-title", {"HU"}, R"("annotations": {"legendTitle": "HU"})"},
    {"--axes", {}, R"("annotations": {"axes": true})"},
    {"--text", {"{volume}, {{}}"}, R"("annotations": {"text": "{volume}, {{}}"})"},
    {"--annotation-color", {"#ff0000"}, R"("annotations": {"color": [1, 0, 0]})"},
    {"--annotation-size", {"1.5"}, R"("annotations": {"size": 1.5})"},
    {"--part", {"2/8"}, R"("part": "2/8")"},
    {"--part", {"0,1,2,3,4,5"}, R"("part": [0, 1, 2, 3, 4, 5])"},
    {"--opacity-threshold", {"0.9"}, R"("visibility": {"threshold": 0.9})"},
    {"--visibility", {"quadtree"}, R"("visibility": {"method": "quadtree"})"},
    {"--test-nodes-only", {}, R"("visibility": {"samples": "untested"})"},
    {"--tile", {"128"}, R"("tile": 128)"},
    {"--lattice", {"ray"}, R"("lattice": "ray")"},
    {"--sample-distance", {"0.75"}, R"("sampleDistance": 0.75)"},
    {"--level", {"auto"}, R"("level": "auto")"},
    {"--level", {"auto+2"}, R"("level": "auto+2")"},
    {"--quality", {"draft"}, R"("quality": "draft")"},
    {"--quality", {"best"}, R"("samples": 16, "sampleDistance": 0.25)"},
    {"--level", {"3"}, R"("level": 3)"},
    {"--samples", {"16"}, R"("samples": 16)"},
    {"--skip-damaged", {}, R"("skipDamaged": true)"},
    {"--memory", {"512M"}, R"("memory": "512M")"},
    {"--share-reads", {"off"}, R"("shareReads": false)"},
    {"--rate", {"23.976"}, R"("video": {"rate": 23.976})"},
    {"--exr-type", {"float"}, R"("exr": {"type": "float"})"},
    {"--compression", {"dwab"}, R"("exr": {"compression": "dwab"})"},
    {"--deep-error", {"0.25"}, R"("exr": {"deepError": 0.25})"},
    {"--png-bits", {"16"}, R"("png": {"bits": 16})"},
    {"--jpeg-quality", {"80"}, R"("jpeg": {"quality": 80})"},
};

TEST(Options, FlagAndKey_giveTheSameJob) {
  const nlohmann::ordered_json plain =
      allValues(jobOptions(), parseJob(R"({"kiln": 2, "volume": "a.kiln"})", "job.json"));
  for (const Pair& pair : kPairs) {
    const RenderJob by_key = parseJob(fmt::format(R"({{"kiln": 2, "volume": "a.kiln", {}}})", pair.json), "job.json");
    const RenderJob by_flag = jobOfFlag(pair.flag, pair.texts);
    EXPECT_EQ(allValues(jobOptions(), by_flag), allValues(jobOptions(), by_key)) << pair.flag;
    EXPECT_EQ(by_flag.animation.any(), by_key.animation.any()) << pair.flag;
    EXPECT_EQ(by_flag.picture.clipping, by_key.picture.clipping) << pair.flag;
  }
  EXPECT_EQ(allValues(jobOptions(), jobOfFlag("--output", {"a.mp4"})), plain);  // a video, which is no picture
}

RenderJob jobWithFlags(const std::string& body, const std::vector<std::pair<std::string, std::string>>& texts) {
  GivenFlags given;
  for (const JobFlag& flag : jobFlags()) {
    for (const auto& [name, text] : texts) {
      if (nameOfFlag(flag.flag) == name) given.add(flag, {text});
    }
  }
  RenderJob job = parseJob(R"({"kiln": 2, "volume": "a.kiln")" + body + "}", "job.json");
  applyGiven(given, job);
  return job;
}

// A quality stands for the options that the drawing engine has; the user's own values stay and are tested.
TEST(Options, QualityOfAJob_isThatOfTheEngineOfTheFlags) {
  const std::string best = R"(, "quality": "best")";
  EXPECT_EQ(jobWithFlags(best, {{"--mode", "mip"}}).picture.sample_distance, kSampleDistance);
  EXPECT_EQ(jobWithFlags(best, {{"--lattice", "voxel"}}).picture.samples, 16);
  EXPECT_EQ(jobWithFlags(best + R"(, "mode": "mip")", {{"--mode", "composite"}}).picture.sample_distance,
            kLeastSampleDistance);
  EXPECT_EQ(jobWithFlags(R"(, "quality": "draft", "mode": "mip")", {{"--mode", "composite"}}).picture.coarser, 1);
  EXPECT_THROW(jobWithFlags(best + R"(, "sampleDistance": 0.75)", {{"--mode", "mip"}}), Error);
  EXPECT_THROW(jobWithFlags(best, {{"--mode", "mip"}, {"--sample-distance", "0.25"}}), Error);
}

// The default size follows from the projection, wherever the job or a flag states it.
TEST(Options, DefaultSizeOfAPanorama_isTwiceAsWide) {
  const std::string panorama = R"("projection": "equirectangular")";
  const auto sizeOf = [](const std::string& body, const std::vector<std::pair<std::string, std::string>>& texts) {
    return jobWithFlags(body, texts).picture.size;
  };
  EXPECT_EQ(sizeOf("", {}), ImageSize());
  EXPECT_EQ(sizeOf("", {{"--projection", "equirectangular"}}), kPanoramaSize);
  EXPECT_EQ(sizeOf(R"(, "camera": {)" + panorama + "}", {}), kPanoramaSize);
  EXPECT_EQ(sizeOf(R"(, "camera": {"keyframes": [{"frame": 1, )" + panorama + "}]}", {}), kPanoramaSize);
  EXPECT_EQ(sizeOf(R"(, "camera": {)" + panorama + "}", {{"--projection", "perspective"}}), ImageSize());
  EXPECT_EQ(sizeOf(R"(, "image": {"height": 1024})", {{"--projection", "equirectangular"}}), ImageSize());
}

// Known: the disk and the scheme of computed volumes tell where a file's name ends.
TEST(Options, NamesWithColons_areThoseOfColors) {
  const auto colorsOf = [](const std::string& text) { return *jobOfFlag("--color-by", {text}).companions.color_by; };
  const std::filesystem::path folder = test::freshDirectory("colons");
  const std::string file = (folder / "a:b.kiln").string();
  std::filesystem::create_directory(file);
  EXPECT_EQ(colorsOf(file), (ColorByChoice{file}));
  EXPECT_EQ(colorsOf(file + ":fire"), (ColorByChoice{file, std::string("fire")}));
  EXPECT_EQ(colorsOf("none.kiln:1:0,2:1").volume, "none.kiln");
  EXPECT_EQ(colorsOf("phantom:brain:64x64x64"), ColorByChoice{"phantom:brain:64x64x64"});
  EXPECT_EQ(colorsOf("phantom:brain:64x64x64:fire"), (ColorByChoice{"phantom:brain:64x64x64", std::string("fire")}));
}

// Keys and flags beside a look win, wherever they stand.
TEST(Options, ALook_setsOptionsThatAreNotGiven) {
  const RenderJob studio = parseJob(
      R"({"kiln": 2, "volume": "a.kiln", "shading": {"ambient": 0.125}, "display": {"exposure": 1}, "look": "studio"})",
      "job.json");
  Shading expected = studioShading();
  expected.ambient = 0.125;
  EXPECT_EQ(studio.picture.shading, expected);
  EXPECT_EQ(studio.picture.display, (Display{1, Tone::kSoft}));
  RenderJob plain = studio;
  flagNamed("--look").apply({"plain"}, plain);
  EXPECT_EQ(plain.picture.shading, Shading());
  EXPECT_EQ(plain.picture.display, (Display{1, Tone::kClip}));
}

TEST(Options, Flag_withAWrongText_isRefusedByItsName) {
  const Pair wrong[] = {{"--fov", {"180"}, ""},
                        {"--fov", {"6o"}, ""},
                        {"--fov", {"nan"}, ""},
                        {"--threads", {"4097"}, ""},
                        {"--threads", {"010"}, ""},
                        {"--threads", {"1e3"}, ""},
                        {"--size", {"0x5"}, ""},
                        {"--size", {"5"}, ""},
                        {"--up", {"0,0,0"}, ""},
                        {"--up", {"0,0"}, ""},
                        {"--light", {"sun"}, ""},
                        {"--light", {"dir:0,0,0"}, ""},
                        {"--clip", {"0,0,0,1"}, ""},
                        {"--mask", {"organs.kiln"}, ""},
                        {"--mask", {"organs.kiln:"}, ""},
                        {"--mask", {"organs.kiln:7-3"}, ""},
                        {"--mask", {"organs.kiln:3-"}, ""},
                        {"--mask", {"organs.kiln:0-70000"}, ""},
                        {"--mask", {":3"}, ""},
                        {"--mask", {"organs.kiln:1.5"}, ""},
                        {"--mask", {"organs.kiln:liver"}, ""},
                        {"--color-by", {":fire"}, ""},
                        {"--attenuation", {"-1"}, ""},
                        {"--section", {"teal"}, ""},
                        {"--section", {"40"}, ""},
                        {"--section", {"40,0"}, ""},
                        {"--section", {"40,400:teal"}, ""},
                        {"--section", {"tf:gray"}, ""},
                        {"--channel-colors", {"magenta:"}, ""},
                        {"--channel-colors", {"0,1,0"}, ""},
                        {"--samples", {"8"}, ""},
                        {"--level", {"fine"}, ""},
                        {"--level", {"auto+x"}, ""},
                        {"--quality", {"ok"}, ""},
                        {"--lattice", {"hex"}, ""},
                        {"--aov", {"depth,hue"}, ""},
                        {"--memory", {"lots"}, ""},
                        {"--share-reads", {"true"}, ""},
                        {"--background", {"0,0,2"}, ""},
                        {"--part", {"4/3"}, ""},
                        {"--window", {"3,0"}, ""},
                        {"--background", {"blak"}, ""},
                        {"--background", {"navy:"}, ""},
                        {"--background", {"#ff"}, ""},
                        {"--light", {"headlight:sun"}, ""},
                        {"--ambient-occlusion", {"much"}, ""},
                        {"--look", {"film"}, ""},
                        {"--exposure", {"21"}, ""},
                        {"--tone", {"hard"}, ""},
                        {"--text", {"{fraem}"}, ""},
                        {"--annotation-size", {"9"}, ""},
                        {"--annotation-color", {"inky"}, ""},
                        {"--jpeg-quality", {"0"}, ""}};
  for (const Pair& pair : wrong) {
    try {
      jobOfFlag(pair.flag, pair.texts);
      ADD_FAILURE() << pair.flag << " " << pair.texts[0];
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find(std::string(pair.flag) + ": expected "), 0u) << error.what();
      EXPECT_NE(std::string(error.what()).find(pair.texts[0] + "'"), std::string::npos) << error.what();
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
    }
  }
}

TEST(Options, FlagOfSeveralParts_namesTheWrongPart) {
  struct Case {
    std::string flag;
    std::vector<std::string> texts;
    std::string found;
  };
  const Case cases[] = {{"--background", {"navy:skyblu"}, "'skyblu' in 'navy:skyblu'"},
                        {"--background", {"nav:skyblue"}, "'nav' in 'nav:skyblue'"},
                        {"--background", {"0,0,2:white"}, "'0,0,2' in '0,0,2:white'"},
                        {"--background", {"navy:white:red"}, "'navy:white:red'"},
                        {"--background", {"navy:"}, "'navy:'"},
                        {"--light", {"headlight", "dir:1,0,0:oragne"}, "'oragne' in 'dir:1,0,0:oragne'"},
                        {"--light", {"dir:1,x,0:red"}, "'1,x,0' in 'dir:1,x,0:red'"},
                        {"--tf", {"0:0,9:1:oragne"}, "'9:1:oragne'"}};
  for (const Case& one : cases) {
    try {
      jobOfFlag(one.flag, one.texts);
      ADD_FAILURE() << one.found;
    } catch (const Error& error) {
      EXPECT_TRUE(std::string(error.what()).ends_with(", found " + one.found)) << error.what();
    }
  }
}

TEST(Options, PointsThatAreWrong_areRefusedByTheFlagsName) {
  for (const char* text : {"1:2", "1:0.5:oragne", "2:0,1:0"}) {
    try {
      jobOfFlag("--tf", {text});
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find("--tf: expected points "), 0u) << error.what();
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
    }
  }
}

// Each word that help and completion name is legal, and each flag is described once.
TEST(Options, EveryFlag_hasHelpAndLegalWords) {
  std::set<std::string> names;
  for (const JobFlag& flag : jobFlags()) {
    EXPECT_TRUE(names.insert(flag.flag).second) << flag.flag;
    EXPECT_FALSE(flag.help.empty()) << flag.flag;
    for (const std::string& word : flag.words) {
      RenderJob job;
      EXPECT_NO_THROW(flag.apply({word}, job)) << flag.flag << " " << word;
    }
  }
}

}  // namespace
}  // namespace kiln

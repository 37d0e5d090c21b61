// Known: the final picture is the file that a batch render of the saved job writes; a newer frame ends the older one; a
// request with a path is refused.
#include "view/view_session.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <limits>
#include <thread>

#include "base/file/file.h"
#include "base/thread/parallel.h"
#include "image/file/image_file.h"
#include "image/file/png_file.h"
#include "image/named_color.h"
#include "image/srgb.h"
#include "job/render_job.h"
#include "sequence/render_job_run.h"
#include "sequence/sequence.h"
#include "sequence/sequence_frames.h"
#include "sequence/series_volumes.h"
#include "support/system/expect_error.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"
#include "view/recorded_client.h"
#include "view/view_job.h"

namespace kiln::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* kFunction =
    R"({"unit": 2, "points": [{"value": 40, "color": "#c08060", "opacity": 0}, {"value": 160, "color": "white", "opacity": 0.8}]})";

// A shell: a surface with something behind it.
DenseVolume shell(int edge) {
  return fill({.dims = {edge, edge, edge}, .type = VoxelType::u8, .world_from_index = anisotropicAffine()},
              [edge](std::int64_t x, std::int64_t y, std::int64_t z) {
                const glm::dvec3 p = (glm::dvec3(x, y, z) + 0.5) / static_cast<double>(edge) * 2.0 - 1.0;
                const double r = glm::length(p);
                return r < 0.5 ? 90 : r < 0.85 ? 200 - 80 * p.x : 0;
              });
}

class ViewSessionTest : public ::testing::Test {
 protected:
  ViewSessionTest()
      : directory_(
            freshDirectory(std::string("view_") + ::testing::UnitTest::GetInstance()->current_test_info()->name())),
        store_(makeStore(shell(48), "view_store", 16)) {}

  ViewSource source(std::uint64_t memory = std::uint64_t{256} << 20) const {
    ViewSource out;
    out.drawn.volume = store_;
    out.drawn.speed.memory_bytes = memory;
    out.named = out.drawn;
    out.job_file = directory_ / "look.view.json";
    out.title = "shell";
    return out;
  }

  static json bodyOf(const json& job, int width = 96, int height = 64, bool moving = false, int seq = 1) {
    return {{"seq", seq}, {"size", {width, height}}, {"moving", moving}, {"job", job}};
  }
  static json jobWith(const json& keys) {
    json out = {{"kiln", 2}, {"transferFunction", json::parse(kFunction)}};
    if (!keys.is_null()) out.update(keys);
    return out;
  }

  // The PNG of a batch render of the session's saved job.
  std::vector<std::byte> rendered() const {
    RenderJob job = readJob(directory_ / "look.view.json");
    job.output.path = directory_ / "batch.png";
    Progress silent;
    runRenderJob(job, 1, silent);
    return readFile(job.output.path);
  }

  Progress silent_;
  const fs::path directory_, store_;
};

// The final picture, byte for byte, for jobs that leave a frame by different ways.
TEST_F(ViewSessionTest, FinalPicture_isTheFileOfABatchRender) {
  ViewSession session(source(), silent_);
  const std::vector<json> jobs = {
      {},
      {{"camera", {{"view", "left"}, {"zoom", 1.5}}}, {"image", {{"background", "navy"}}}},
      {{"look", "studio"}, {"display", {{"exposure", 0.5}}}},
      {{"samples", 4}, {"interpolation", "cubic"}, {"region", {0, 0, 0, 48, 30, 48}}},
      {{"mode", "mip"}, {"transferFunction", "auto"}},
      {{"lattice", "voxel"}, {"level", 0}},
      {{"stereo", {{"eye", "both"}, {"interocular", 4}}}},
      {{"camera", {{"turntable", {{"frames", 1}}}}},
       {"lights", {{{"type", "directional"}, {"direction", {1, -1, 1}}, {"shadow", true}}}}},
      // Shadow maps have samples of this distance, and are drawn anew.
      {{"sampleDistance", 0.25},
       {"camera", {{"turntable", {{"frames", 1}}}}},
       {"lights", {{{"type", "directional"}, {"direction", {1, -1, 1}}, {"shadow", true}}}}},
      {{"worldRegion", {0, 0, 0, 20, 30, 50}}, {"clip", {{{"normal", {1, 0, 0}}, {"offset", -4}}}}},
  };
  for (const json& keys : jobs) {
    const json job = jobWith(keys);
    RecordedClient frame, save;
    session.answer("frame", bodyOf(job).dump(), frame);
    session.answer("save", bodyOf(job).dump(), save);
    const RecordedClient::Record* const final = frame.stage("final");
    ASSERT_NE(final, nullptr) << job << (frame.records.empty() ? json() : frame.records.back().json);
    EXPECT_TRUE(final->json.at("asRendered")) << job;
    EXPECT_EQ(final->payload, rendered()) << job;
  }
}

TEST_F(ViewSessionTest, APreviewComesFirst_andHasTheShapeOfThePicture) {
  ViewSession session(source(), silent_);
  RecordedClient client;
  session.answer("frame", bodyOf(jobWith({})).dump(), client);
  EXPECT_EQ(client.kinds(), (std::vector<std::string>{"resolved", "preview", "refined", "final", "end"}));
  const RecordedClient::Record &preview = *client.stage("preview"), &final = *client.stage("final");
  EXPECT_EQ(final.json.at("width"), 96);
  const Image small = decodePng(preview.payload, {}), large = decodePng(final.payload, {});
  const auto covered = [](const Image& image) {
    double sum = 0;
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) sum += image.rgba[i];
    return sum / (image.width * image.height);
  };
  EXPECT_GT(covered(large), 0.05);
  EXPECT_NEAR(covered(small), covered(large), 0.05);
  // Without alpha, a preview is a JPEG.
  RecordedClient opaque;
  session.answer("frame", bodyOf(jobWith({{"image", {{"background", "white"}}}}), 96, 64, true).dump(), opaque);
  EXPECT_EQ(opaque.kinds(), (std::vector<std::string>{"resolved", "preview", "end"}));
  EXPECT_EQ(opaque.stage("preview")->json.at("type"), "image/jpeg");
  EXPECT_EQ(opaque.stage("preview")->payload.at(0), std::byte{0xff});
  EXPECT_EQ(opaque.stage("preview")->payload.at(1), std::byte{0xd8});
}

// Known: the volume has one level, whose file is larger than what a preview reads. No coarser picture exists.
TEST_F(ViewSessionTest, ALevelThatIsLarge_isRefinedOnce) {
  ViewSource given = source();
  for (RenderJob* const job : {&given.drawn, &given.named})
    job->volume = makeStore(noise({{208, 208, 208}, VoxelType::u16}, 5, {0, 65535}), "large", 256);
  ViewSession session(given, silent_);
  RecordedClient client;
  session.answer("frame", bodyOf(jobWith({})).dump(), client);
  EXPECT_EQ(client.kinds(), (std::vector<std::string>{"resolved", "preview", "refined", "final", "end"}));
}

TEST_F(ViewSessionTest, ResolvedCamera_drawsThePictureAgain) {
  ViewSession session(source(), silent_);
  RecordedClient first, second, resolve;
  session.answer("frame", bodyOf(jobWith({{"camera", {{"view", "left"}}}})).dump(), first);
  json camera = first.records.front().json.at("camera");
  session.answer("resolve", bodyOf(jobWith({{"camera", {{"view", "left"}}}})).dump(), resolve);
  EXPECT_EQ(resolve.json().at("camera"), camera);
  EXPECT_EQ(resolve.json().at("transferFunctions").at(0).at("unit"), 2);
  session.answer("frame", bodyOf(jobWith({{"camera", camera}})).dump(), second);
  EXPECT_EQ(decodePng(first.stage("final")->payload, {}).rgba, decodePng(second.stage("final")->payload, {}).rgba);
}

// The first frame blocks in its client until the second has arrived.
TEST_F(ViewSessionTest, ANewerFrame_endsTheOlder) {
  ViewSession session(source(), silent_);
  RecordedClient older, newer;
  std::promise<void> begun, go_on;
  std::once_flag once;
  older.on_record = [&](const RecordedClient::Record&) {
    std::call_once(once, [&] {
      begun.set_value();
      go_on.get_future().wait();
    });
  };
  std::thread thread([&] { session.answer("frame", bodyOf(jobWith({}), 96, 64, false, 1).dump(), older); });
  begun.get_future().wait();
  newer.on_record = [&](const RecordedClient::Record& record) {
    if (record.json.at("kind") == "resolved") go_on.set_value();
  };
  session.answer("frame", bodyOf(jobWith({}), 96, 64, false, 2).dump(), newer);
  thread.join();
  EXPECT_EQ(older.kinds().back(), "cancelled");
  EXPECT_EQ(older.stage("final"), nullptr);
  EXPECT_EQ(newer.kinds().back(), "end");
  // A frame that another connection has overtaken draws nothing if it arrives soon; on a busy machine it may not.
  bool overtaken = false;
  for (int seq = 4; !overtaken && seq < 100; seq += 2) {
    RecordedClient newest, late;
    newest.on_record = [&](const RecordedClient::Record& record) {
      if (record.json.at("kind") == "resolved")
        session.answer("frame", bodyOf(jobWith({}), 96, 64, true, seq - 1).dump(), late);
    };
    session.answer("frame", bodyOf(jobWith({}), 96, 64, true, seq).dump(), newest);
    overtaken = late.kinds() == std::vector<std::string>{"cancelled"};
  }
  EXPECT_TRUE(overtaken);
}

// The frames of one page arrive while a stage of the other is under way. Known: each picture is that of the page alone.
TEST_F(ViewSessionTest, FramesOfTwoPages_endNoneOfEachOther) {
  ViewSession session(source(), silent_);
  const json slow = jobWith({{"samples", 16}, {"camera", {{"view", "left"}}}});
  const auto body = [&](const char* page, const json& job, bool moving, int seq) {
    json out = bodyOf(job, 256, 256, moving, seq);
    out["page"] = page;
    return out.dump();
  };
  RecordedClient alone, first;
  session.answer("frame", body("a", slow, false, 1), alone);
  std::promise<void> begun;
  first.on_record = [&](const RecordedClient::Record& record) {
    if (record.json.at("kind") == "resolved") begun.set_value();
  };
  std::thread thread([&] { session.answer("frame", body("a", slow, false, 5), first); });
  begun.get_future().wait();
  for (int seq = 1; seq < 5; ++seq) {
    RecordedClient second;
    session.answer("frame", body("b", jobWith({}), seq < 4, seq), second);
    EXPECT_EQ(second.kinds().back(), "end");
  }
  thread.join();
  ASSERT_EQ(first.kinds().back(), "end");
  EXPECT_EQ(first.stage("final")->payload, alone.stage("final")->payload);
  RecordedClient wrong;
  expectError([&] { session.answer("frame", body(std::string(65, 'x').c_str(), slow, true, 1), wrong); },
              ErrorCode::kUsage, "page");
  for (int page = 0; page < 100; ++page) {
    RecordedClient client;
    session.answer("frame", body(std::to_string(page).c_str(), jobWith({}), true, 1), client);
    EXPECT_EQ(client.kinds().back(), "end");
  }
}

TEST_F(ViewSessionTest, AClientThatLeaves_stopsTheDrawing) {
  ViewSession session(source(), silent_);
  RecordedClient client;
  std::atomic<int> looks = 0;
  client.leaves = [&] { return ++looks > 2; };
  const json slow = jobWith({{"samples", 16}, {"sampleDistance", 0.25}});
  expectError([&] { session.answer("frame", bodyOf(slow, 1024, 1024).dump(), client); }, ErrorCode::kCancelled, "");
  EXPECT_EQ(client.stage("final"), nullptr);
}

// A client leaves at each look of a request in turn. Known: no look follows but one of each thread, nothing is drawn
// or written, and other work than frames looks at least once for each map of a light, key and frame.
TEST_F(ViewSessionTest, AClientThatLeavesAtAnyMoment_stopsTheWork) {
  const auto key = [](int frame, int end) {
    json function = json::parse(kFunction);
    function["points"][1]["value"] = end;
    return json{{"frame", frame}, {"function", function}};
  };
  json keys = json::array();
  for (int i = 0; i < 40; ++i) keys.push_back(key(i + 1, 120 + i));
  const json many = jobWith({{"transferFunction", {{"keyframes", keys}}}});
  const json lit = jobWith(
      {{"lights",
        {{{"type", "directional"}, {"direction", {1, -1, 1}}, {"shadow", {{"softness", 20}, {"resolution", 64}}}}}},
       {"shading", {{"ambientOcclusion", 1}}}});
  const json turning = jobWith({{"camera", {{"turntable", {{"frames", 60}}}}}});
  struct Case {
    const char* request;
    json job;
    int least;  // looks
  };
  // Frames look by the clock. A soft light has 16 maps; the occlusion looks once a slice of its lattice.
  const std::vector<Case> cases = {
      {"frame", lit, 1},          {"frame", jobWith({}), 1}, {"estimate", many, 40},
      {"estimate", turning, 120}, {"save", many, 80},        {"save", turning, 120},
      {"command", turning, 120},  {"render", lit, 100},      {"thumbnail", jobWith({}), 20}};
  for (const Case& given : cases) {
    json body = bodyOf(given.job, 96, 64);
    if (std::string_view(given.request) == "thumbnail") body["preset"] = "viridis";
    const auto looksOf = [&](int leaves_at, bool& ended) {
      fs::remove(directory_ / "look.view.json"), fs::remove(directory_ / "look.view.png");
      ViewSession session(source(), silent_);
      RecordedClient client;
      std::atomic<int> looks = 0;
      client.leaves = [&] { return ++looks >= leaves_at; };
      try {
        session.answer(given.request, body.dump(), client);
        ended = true;
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kCancelled) << given.request << ": " << error.what();
        ended = false;
      }
      if (!ended) {
        EXPECT_EQ(client.stage("final"), nullptr) << given.request << " at look " << leaves_at;
        EXPECT_FALSE(fs::exists(directory_ / "look.view.json")) << given.request << " at look " << leaves_at;
        EXPECT_TRUE(client.document_bytes.empty());
      }
      return looks.load();
    };
    bool ended = false;
    const int all = looksOf(std::numeric_limits<int>::max(), ended);
    EXPECT_TRUE(ended);
    EXPECT_GE(all, given.least) << given.request;
    const int threads = static_cast<int>(ThreadLimit::active());
    for (int at = 1; at < all; at += std::max(1, all / 6)) {
      const int looks = looksOf(at, ended);
      if (ended) continue;
      EXPECT_LE(looks, at + 2 * threads + 2) << given.request << " at look " << at << " of " << all;
    }
  }
}

// Frames follow each other without a pause until the render has ended.
TEST_F(ViewSessionTest, ARenderEnds_underSteadyMoves) {
  ViewSession session(source(), silent_);
  std::atomic<bool> written = false;
  const auto move = [&](const char* page) {
    for (int seq = 1; !written; ++seq) {
      RecordedClient client;
      json body = bodyOf(jobWith({}), 96, 64, true, seq);
      body["page"] = page;
      session.answer("frame", body.dump(), client);
    }
  };
  std::thread first([&] { move("a"); }), second([&] { move("b"); });
  RecordedClient client;
  session.answer("render", bodyOf(jobWith({{"samples", 16}}), 512, 512).dump(), client);
  written = true;
  first.join(), second.join();
  EXPECT_EQ(client.kinds().back(), "written") << client.records.back().json;
}

TEST_F(ViewSessionTest, RequestsOfManyObjects_areRefused) {
  ViewSession session(source(), silent_);
  json keys = json::array();
  for (int i = 0; i < 5000; ++i)
    keys.push_back({{"frame", i + 1}, {"lights", json::array({json::object(), json::object(), json::object()})}});
  RecordedClient client;
  expectError(
      [&] {
        session.answer("frame", bodyOf(jobWith({{"lights", {{"keyframes", keys}}}})).dump(), client);
      },
      ErrorCode::kFormat, "20000");
}

TEST_F(ViewSessionTest, JobsWithPaths_areRefused) {
  ViewSession session(source(), silent_);
  const std::string body = bodyOf(jobWith({})).dump();
  for (const char* key :
       {"volume", "output", "outputs", "video", "exr", "frames", "part", "trace", "memory", "threads", "aov"}) {
    RecordedClient client;
    expectError([&] { session.answer("frame", bodyOf(jobWith({{key, "1"}})).dump(), client); }, ErrorCode::kUsage, key);
    EXPECT_TRUE(client.records.empty());
  }
  const std::vector<json> wrong = {
      jobWith({{"transferFunction", "./look.json"}}),
      jobWith({{"transferFunction", "/etc/passwd"}}),
      jobWith({{"transferFunction", {{"keyframes", {{{"frame", 1}, {"function", "a.json"}}}}}}}),
      jobWith({{"volumes", {{{"volume", "other.kiln"}}}}}),
      jobWith({{"camera", {{"file", "a.pvcc"}}}}),
      jobWith({{"camera", {{"keyframes", {{{"frame", 1}, {"file", "a.pvcc"}}}}}}}),
      jobWith({{"image", "large"}}),
      json::array(),
      "job",
  };
  for (const json& job : wrong) {
    for (const char* name : {"frame", "save", "command", "estimate", "resolve", "render"}) {
      RecordedClient client;
      expectError([&] { session.answer(name, bodyOf(job).dump(), client); }, ErrorCode::kUsage, "");
    }
  }
  EXPECT_FALSE(fs::exists(directory_ / "look.view.json"));
  for (const char* text : {"", "[]", "{", "\"a\"", "{\"size\": [0, 1]}"}) {
    RecordedClient client;
    EXPECT_THROW(session.answer("frame", text, client), Error) << text;
  }
  RecordedClient deep;
  expectError([&] { session.answer("frame", std::string(500'000, '['), deep); }, ErrorCode::kFormat, "nested");
  RecordedClient large;
  expectError([&] { session.answer("frame", bodyOf(jobWith({}), 4097, 1).dump(), large); }, ErrorCode::kUsage, "size");
}

TEST_F(ViewSessionTest, Facts_areTheVolumes) {
  ViewSource given = source();
  given.drawn.picture.camera.side = Side::kLeft;
  given.drawn.picture.transfer_function = std::string("ct-bone");
  ViewSession session(given, silent_);
  RecordedClient client;
  session.answer("session", "", client);
  const json facts = client.json();
  EXPECT_EQ(facts.at("job"), (json{{"kiln", 2}, {"camera", {{"view", "left"}}}, {"transferFunction", "ct-bone"}}));
  const json& volume = facts.at("volumes").at(0);
  EXPECT_EQ(volume.at("voxels"), (json{48, 48, 48}));
  EXPECT_EQ(volume.at("type"), "u8");
  EXPECT_EQ(volume.at("affine").at(2).at(2), 2.1);
  EXPECT_EQ(volume.at("histogram").at("counts").size(), 256u);
  std::uint64_t voxels = 0;
  for (const json& count : volume.at("histogram").at("counts")) voxels += count.get<std::uint64_t>();
  EXPECT_EQ(voxels, 48u * 48u * 48u);
  EXPECT_EQ(facts.at("looks").at("studio").at("display").at("tone"), "soft");
  EXPECT_EQ(facts.at("looks").at("plain").at("shading").at("ambient"), 0.2);
  EXPECT_EQ(facts.at("jobFile"), "look.view.json");
  EXPECT_EQ(facts.at("box").at("min").at(0), -3.35);
  EXPECT_EQ(facts.dump().find(directory_.string()), std::string::npos) << "a path is told";
}

// Known: the finite values are 0 to 70.
TEST_F(ViewSessionTest, TheRangeOfInfinities_isFinite) {
  const DenseVolume volume =
      fill({.dims = {8, 8, 8}, .type = VoxelType::f32}, [](std::int64_t x, std::int64_t y, std::int64_t z) {
        return y + z == 0 && x == 5 ? std::numeric_limits<double>::infinity() : 10.0 * x;
      });
  ViewSource given = source();
  given.drawn.volume = given.named.volume = makeStore(volume, "view_infinite", 8);
  ViewSession session(given, silent_);
  RecordedClient client;
  session.answer("session", "", client);
  const json range = client.json().at("volumes").at(0).at("range");
  EXPECT_EQ(range.at(0), 0);
  EXPECT_NEAR(range.at(1).get<double>(), 70, 0.1);
}

TEST_F(ViewSessionTest, SlicesAndProbes_areTheVoxels) {
  ViewSession session(source(), silent_);
  const DenseVolume volume = shell(48);
  RecordedClient probe;
  session.answer("probe", R"({"volume": 0, "voxel": [20, 24, 17]})", probe);
  EXPECT_EQ(probe.json().at("value"), volume.at<std::uint8_t>(20, 24, 17));
  EXPECT_FALSE(probe.json().contains("label"));
  EXPECT_NEAR(probe.json().at("world").at(1).get<double>(), 5 + 24 * 0.9, 1e-9);
  RecordedClient slice;
  session.answer("slice", R"({"volume": 0, "axis": "z", "index": 17, "window": [127.5, 255]})", slice);
  const json& record = slice.records.at(0).json;
  EXPECT_EQ(record.at("level"), 0);
  const Image image = decodePng(slice.records.at(0).payload, {});
  EXPECT_EQ(image.width, record.at("width"));
  EXPECT_GT(image.pixel(image.width / 2, image.height / 2)[0], 0.05f);
  EXPECT_EQ(image.pixel(0, 0)[0], 0.0f);
  RecordedClient coarse;
  session.answer("slice", R"({"axis": "x", "index": 40, "size": [20, 20]})", coarse);
  EXPECT_GT(coarse.records.at(0).json.at("level"), 0);
  for (const char* wrong : {R"({"axis": "w", "index": 1})", R"({"axis": "z", "index": 48})", R"({"axis": "z"})",
                            R"({"axis": "z", "index": 1, "volume": 1})", R"({"axis": "z", "index": 1.5})"}) {
    RecordedClient client;
    EXPECT_THROW(session.answer("slice", wrong, client), Error) << wrong;
  }
  for (const char* wrong : {R"({"voxel": [48, 0, 0]})", R"({"voxel": [1, 2]})", R"({})", R"({"voxel": "1"})"}) {
    RecordedClient client;
    EXPECT_THROW(session.answer("probe", wrong, client), Error) << wrong;
  }
}

// Known: the picture of a slice is that of `kiln slice`; the page is told which voxels are its columns and rows.
TEST_F(ViewSessionTest, SlicesOfTurnedVoxels_haveTheSidesOfThePatient) {
  // Voxels grow to the front, to the feet and to the left.
  DenseVolume volume = fill({.dims = {8, 6, 10}, .type = VoxelType::u8},
                            [](std::int64_t x, std::int64_t y, std::int64_t z) { return 20 * x + 4 * y + z; });
  volume.geometry.frame = PatientFrame::kLps;
  volume.geometry.world_from_index = {{0, -1, 0, 0}, {0, 0, -1, 0}, {1, 0, 0, 0}, {0, 0, 0, 1}};
  ViewSource given = source();
  given.drawn.volume = given.named.volume = makeStore(volume, "view_turned", 8);
  ViewSession session(given, silent_);
  RecordedClient facts, slice;
  session.answer("session", "", facts);
  const json views = facts.json().at("volumes").at(0).at("slices");
  ASSERT_EQ(views.size(), 3u);
  EXPECT_EQ(views.at(0), json({{"plane", "axial"},
                               {"axis", 1},
                               {"column", 2},
                               {"leftwards", false},
                               {"row", 0},
                               {"upwards", true},
                               {"letters", {"R", "L", "A", "P"}}}));
  EXPECT_EQ(views.at(1).at("plane"), "coronal");
  EXPECT_EQ(views.at(2), json({{"plane", "sagittal"},
                               {"axis", 2},
                               {"column", 0},
                               {"leftwards", true},
                               {"row", 1},
                               {"upwards", false},
                               {"letters", {"A", "P", "S", "I"}}}));
  session.answer("slice", R"({"axis": "z", "index": 3, "window": [127.5, 255]})", slice);
  const Image image = decodePng(slice.records.at(0).payload, {});
  ASSERT_EQ(image.width, 8);
  for (const auto& [x, y] : {std::pair{0, 0}, {7, 0}, {2, 5}})
    EXPECT_NEAR(srgbFromLinear(image.pixel(x, y)[0]) * 255, 20 * (7 - x) + 4 * y + 3, 0.6) << x << " " << y;
}

TEST_F(ViewSessionTest, SavedJobs_nameTheVolumeOnly) {
  ViewSession session(source(), silent_);
  RecordedClient client, command;
  session.answer("save", bodyOf(jobWith({{"camera", {{"view", "top"}}}}), 320, 200).dump(), client);
  EXPECT_EQ(client.json().at("path"), (directory_ / "look.view.json").string());
  const RenderJob job = readJob(directory_ / "look.view.json");
  EXPECT_EQ(job.volume, store_);
  EXPECT_EQ(job.picture.size.width, 320);
  EXPECT_EQ(job.picture.camera.side, Side::kTop);
  EXPECT_TRUE(job.output.path.empty());
  session.answer("command", bodyOf(jobWith({}), 320, 200).dump(), command);
  EXPECT_NE(command.json().at("command").get<std::string>().find("kiln render "), std::string::npos);
}

// The opened job's files, encoding and channels, with names that lead to equal files from another folder.
TEST_F(ViewSessionTest, SavedJobs_keepTheOutputsOfTheOpenedJob) {
  fs::create_directories(directory_ / "jobs");
  const fs::path opened = directory_ / "jobs" / "look.json";
  writeText(opened, json{{"kiln", 2},
                         {"volume", store_.string()},
                         {"image", {{"aov", {"depth"}}}},
                         {"exr", {{"compression", "zip"}}},
                         {"outputs", {{{"path", "a_####.exr"}}, {{"path", "../b_####.png"}, {"content", "color"}}}},
                         {"camera", {{"turntable", {{"frames", 4}}}}},
                         {"frames", "2-3"},
                         {"memory", "300M"},
                         {"threads", 3},
                         {"shareReads", false},
                         {"trace", "trace.json"}}
                        .dump());
  ViewSource given = source();
  given.drawn = given.named = readJob(opened);
  given.kept_keys = keptKeys(opened);
  ViewSession session(given, silent_);
  RecordedClient facts, save;
  session.answer("session", "", facts);
  json job = facts.json().at("job");
  job["camera"]["elevation"] = 10;
  session.answer("save", bodyOf(job).dump(), save);
  const json saved = json::parse(readTextFile(directory_ / "look.view.json", 1 << 20));
  EXPECT_EQ(saved.at("image").at("aov"), json({"depth"}));
  EXPECT_EQ(saved.at("exr"), json({{"compression", "zip"}}));
  EXPECT_EQ(saved.at("outputs").at(0).at("path"), "jobs/a_####.exr");
  EXPECT_EQ(saved.at("outputs").at(1).at("path"), "b_####.png");
  EXPECT_EQ(saved.at("frames"), "2-3");
  EXPECT_EQ(saved.at("memory"), "300M");
  EXPECT_EQ(saved.at("threads"), 3);
  EXPECT_EQ(saved.at("shareReads"), false);
  EXPECT_EQ(saved.at("trace"), "jobs/trace.json");
  EXPECT_EQ(saved.at("camera").at("elevation"), 10);
  // The command draws these frames and planes: by options where the turntable has no elevation.
  RecordedClient by_file, by_options;
  session.answer("command", bodyOf(job).dump(), by_file);
  job["camera"].erase("elevation");
  session.answer("command", bodyOf(job).dump(), by_options);
  const std::string picture = " -o " + (directory_ / "look.view_####.exr").string() + " --size 96x64";
  for (const RecordedClient* const client : {&by_file, &by_options}) {
    const std::string command = client->json().at("command");
    EXPECT_TRUE(command.ends_with(picture)) << command;
  }
  EXPECT_NE(by_options.json().at("command").get<std::string>().find(" --aov depth --turntable 4 --frames 2-3 -o"),
            std::string::npos)
      << by_options.json();
}

// Known: the volumes of frames 2 and 3 differ, and frame 2 alone is open.
TEST_F(ViewSessionTest, ASeries_showsItsFirstFrame) {
  for (const int frame : {2, 3})
    fs::copy(makeStore(shell(16 * frame), "view_frame", 16), directory_ / fmt::format("t_{}.kiln", frame),
             fs::copy_options::recursive);
  ViewSource given = source();
  given.named.volume = directory_ / "t_#.kiln";
  given.named.frames = {2, 3};
  given.drawn = jobAtFrame(given.named, 2);
  given.drawn.series = seriesLook(given.named, {});
  given.kept_keys = R"({"frames": "2,3"})";
  ViewSession session(given, silent_);
  const auto answerTo = [&](const char* request, std::optional<int> frame, RecordedClient& client) {
    json body = bodyOf(jobWith({}));
    if (frame) body["frame"] = *frame;
    session.answer(request, body.dump(), client);
  };
  RecordedClient facts, first, second, third, resolved, render, save;
  session.answer("session", "", facts);
  EXPECT_EQ(facts.json().at("frame"), 2);
  answerTo("frame", std::nullopt, first);
  answerTo("frame", 2, second);
  EXPECT_EQ(first.stage("final")->payload, second.stage("final")->payload);
  expectError([&] { answerTo("frame", 3, third); }, ErrorCode::kUsage, "time series");
  expectError([&] { answerTo("resolve", 3, resolved); }, ErrorCode::kUsage, "time series");
  answerTo("render", std::nullopt, render);
  EXPECT_EQ(render.records.back().json.value("path", ""), (directory_ / "look.view.png").string())
      << render.records.back().json;
  answerTo("save", std::nullopt, save);
  const RenderJob job = readJob(directory_ / "look.view.json");
  EXPECT_EQ(job.frames, (std::vector<int>{2, 3}));
  EXPECT_EQ(job.volume, directory_ / "t_#.kiln");
  EXPECT_EQ(decodePng(first.stage("final")->payload, {}).rgba, decodePng(rendered(), {}).rgba);
}

// Known: a PNG of 16 bits has such pixels, whoever writes it.
TEST_F(ViewSessionTest, PngsOf16Bits_keepTheirBits) {
  ViewSource given = source();
  given.drawn.output.png_bits = given.named.output.png_bits = 16;
  given.kept_keys = R"({"png": {"bits": 16}})";
  ViewSession session(given, silent_);
  RecordedClient frame, save, render, command;
  const std::string body = bodyOf(jobWith({})).dump();
  session.answer("frame", body, frame);
  session.answer("save", body, save);
  session.answer("render", body, render);
  session.answer("command", bodyOf({{"kiln", 2}, {"transferFunction", "viridis"}}).dump(), command);
  EXPECT_EQ(readPixelLayout(directory_ / "look.view.png").png_bits, 16);
  EXPECT_EQ(frame.stage("final")->payload, rendered());
  EXPECT_NE(command.json().at("command").get<std::string>().find("--png-bits 16"), std::string::npos);
}

// A volume of labels 3 and 7. Known: a slice has the palette's colours, then the request's, and no hidden label.
TEST_F(ViewSessionTest, SlicesOfLabels_haveTheirColours) {
  const DenseVolume volume = fill({.dims = {8, 8, 8}, .type = VoxelType::u8},
                                  [](std::int64_t x, std::int64_t, std::int64_t) { return x < 4 ? 3 : 7; });
  ViewSource given = source();
  given.drawn.volume = given.named.volume = makeStore(volume, "view_labels", 8, true);
  ViewSession session(given, silent_);
  RecordedClient facts, plain, own;
  session.answer("session", "", facts);
  const auto slice = [&](RecordedClient& client, const json& keys) {
    json body = {{"axis", "z"}, {"index", 4}};
    body.update(keys);
    session.answer("slice", body.dump(), client);
    return decodePng(client.records.front().payload, {});
  };
  const auto hexAt = [](const Image& image, int x) {
    return hexText({image.pixel(x, 4)[0], image.pixel(x, 4)[1], image.pixel(x, 4)[2]});
  };
  const Image first = slice(plain, json::object());
  const json labels = facts.json().at("volumes").at(0).at("labels");
  EXPECT_EQ(hexAt(first, 1), labels.at(0).at("color"));
  EXPECT_EQ(hexAt(first, 6), labels.at(1).at("color"));
  const json function = {
      {"labels", {{{"label", 3}, {"color", "#ff0000"}, {"opacity", 0}}, {{"label", 7}, {"color", "#00ff00"}}}}};
  const Image second = slice(own, {{"transferFunction", function}});
  EXPECT_EQ(second.pixel(1, 4)[3], 0);
  EXPECT_EQ(hexAt(second, 6), "#00ff00");
}

// Known: a batch render of an equal job file refuses these jobs, with this sentence.
TEST_F(ViewSessionTest, JobsThatBatchRefuses_areNotSaved) {
  ViewSession session(source(), silent_);
  const std::vector<json> jobs = {jobWith({{"lattice", "voxel"}, {"interpolation", "cubic"}}),
                                  jobWith({{"camera", {{"projection", "equirectangular"}}}, {"lattice", "voxel"}}),
                                  jobWith({{"level", 9}}),
                                  jobWith({{"camera", {{"eye", {1, 1, 1}}, {"target", {1, 1, 1}}}}}),
                                  jobWith({{"transferFunction", {{"labels", {{{"label", 1}, {"color", "red"}}}}}}}),
                                  jobWith({{"camera",
                                            {{"keyframes",
                                              {{{"frame", 1}, {"eye", {90, 90, 90}}, {"target", {0, 0, 0}}},
                                               {{"frame", 3}, {"eye", {1, 1, 1}}, {"target", {1, 1, 1}}}}}}}})};
  for (const json& job : jobs) {
    json file = job;
    file["volume"] = store_.string();
    file["image"] = {{"width", 96}, {"height", 64}};
    writeText(directory_ / "job.json", file.dump());
    std::string why;
    try {
      RenderJob batch = readJob(directory_ / "job.json");
      batch.output.path = directory_ / "p_#.png";
      SequenceListener listener;
      runSequence(batch, {}, silent_, listener);
    } catch (const Error& error) {
      why = error.what();
    }
    EXPECT_NE(why, "") << job;
    // The page sees its first frame at once.
    if (why.starts_with("frame 1: ")) why.erase(0, why.find(' ', 6) + 1);
    for (const char* const request : {"save", "command"}) {
      RecordedClient client;
      expectError([&] { session.answer(request, bodyOf(job).dump(), client); }, ErrorCode::kUsage, why);
    }
    EXPECT_FALSE(fs::exists(directory_ / "look.view.json"));
  }
}

// Known because the session may not replace what it reads.
TEST_F(ViewSessionTest, Pictures_replaceNoInput) {
  ViewSource given = source();
  const fs::path kept = directory_ / "look.view.png";
  writeText(kept, "an input");
  given.require_free = [&](const fs::path& output) {
    if (fs::equivalent(output, kept)) throw Error(ErrorCode::kUsage, output, "--job", "is read");
  };
  ViewSession session(std::move(given), silent_);
  RecordedClient client;
  session.answer("render", bodyOf(jobWith({})).dump(), client);
  EXPECT_EQ(client.kinds().back(), "error");
  EXPECT_EQ(readTextFile(kept), "an input");
}

// Known: # and %V in a name have a meaning in batch renders, and none for an opened volume.
TEST_F(ViewSessionTest, NamesThatReadAsPatterns_areRefused) {
  const json turning = jobWith({{"camera", {{"turntable", {{"frames", 3}}}}}});
  for (const char* const name : {"a#1", "a%V"}) {
    ViewSource given = source();
    given.job_file = directory_ / (std::string(name) + ".view.json");
    ViewSession session(given, silent_);
    for (const char* const request : {"render", "command"}) {
      RecordedClient client;
      expectError([&] { session.answer(request, bodyOf(jobWith({})).dump(), client); }, ErrorCode::kUsage, "--job");
    }
    RecordedClient save;
    session.answer("save", bodyOf(turning).dump(), save);
    EXPECT_TRUE(fs::exists(given.job_file));
  }
  ViewSource given = source();
  given.drawn.volume = given.named.volume = directory_ / "a#1.kiln";
  fs::copy(store_, given.named.volume, fs::copy_options::recursive);
  ViewSession session(given, silent_);
  RecordedClient still, command, moving;
  session.answer("save", bodyOf(jobWith({})).dump(), still);
  EXPECT_GT(rendered().size(), 0u);
  for (const char* const request : {"save", "command"})
    expectError([&] { session.answer(request, bodyOf(turning).dump(), moving); }, ErrorCode::kUsage, "rename");
}

// Known: a batch render draws such a volume, and JSON has no text for its name.
TEST_F(ViewSessionTest, NamesThatAreNoUtf8_areDrawn_andNotSaved) {
  ViewSource given = source();
  given.drawn.volume = given.named.volume = directory_ / "gr\xfcn.kiln";
  fs::copy(store_, given.named.volume, fs::copy_options::recursive);
  ViewSession session(given, silent_);
  RecordedClient drawn, client;
  session.answer("frame", bodyOf(jobWith({})).dump(), drawn);
  EXPECT_NE(drawn.stage("final"), nullptr);
  for (const char* const request : {"save", "command"})
    expectError([&] { session.answer(request, bodyOf(jobWith({})).dump(), client); }, ErrorCode::kUsage, "no UTF-8");
  EXPECT_FALSE(fs::exists(given.job_file));
}

TEST_F(ViewSessionTest, RenderedFrames_areNumbered) {
  ViewSession session(source(), silent_);
  RecordedClient client, save;
  const json body = bodyOf(jobWith({{"camera", {{"turntable", {{"frames", 3}}}}}}), 40, 30);
  session.answer("render", body.dump(), client);
  EXPECT_EQ(client.kinds().back(), "written") << client.records.back().json;
  for (const char* name : {"look.view_0001.png", "look.view_0002.png", "look.view_0003.png"})
    EXPECT_TRUE(fs::exists(directory_ / name)) << name;
  session.answer("save", body.dump(), save);
  RenderJob job = readJob(directory_ / "look.view.json");
  job.frames = {2};
  job.output.path = directory_ / "batch.png";
  runRenderJob(job, 1, silent_);
  EXPECT_EQ(readImage(directory_ / "look.view_0002.png").rgba, readImage(directory_ / "batch.png").rgba);
  json second = body;
  second["frame"] = 2;
  RecordedClient frame;
  session.answer("frame", second.dump(), frame);
  EXPECT_EQ(frame.stage("final")->payload, readFile(directory_ / "batch.png"));
}

TEST_F(ViewSessionTest, SmallMemory_isKept_orRefused) {
  ViewSession session(source(std::uint64_t{24} << 20), silent_);
  RecordedClient small, large;
  session.answer("frame", bodyOf(jobWith({})).dump(), small);
  EXPECT_NE(small.stage("final"), nullptr);
  session.answer("frame", bodyOf(jobWith({{"samples", 16}}), 2048, 2048).dump(), large);
  EXPECT_EQ(large.kinds(), std::vector<std::string>{"error"});
  EXPECT_NE(large.records.back().json.at("error").get<std::string>().find("--memory"), std::string::npos);
}

// A session with the estimated memory, rounded up, draws the picture; with less memory it does not.
TEST_F(ViewSessionTest, EstimatedMemory_isTheSmallestForARender) {
  const std::string body = bodyOf(jobWith({}), 1024, 768).dump();
  RecordedClient estimate;
  {
    ViewSession session(source(), silent_);
    session.answer("estimate", body, estimate);
  }
  const auto memory = estimate.json().at("memory").get<std::uint64_t>();
  for (const bool enough : {true, false}) {
    ViewSession session(source(enough ? memory : memory - 1), silent_);
    RecordedClient client;
    session.answer("render", body, client);
    EXPECT_EQ(client.kinds().back(), enough ? "written" : "error") << client.records.back().json;
  }
}

// Known: 10 frames take ten times as long as one; a picture of other samples or eyes says nothing.
TEST_F(ViewSessionTest, EstimatedSeconds_areThoseOfTheJob) {
  ViewSession session(source(), silent_);
  const auto secondsOf = [&](const json& keys, int width = 96) {
    RecordedClient client;
    session.answer("estimate", bodyOf(jobWith(keys), width, 64).dump(), client);
    return client.json().at("seconds");
  };
  EXPECT_TRUE(secondsOf({}).is_null());
  // The first picture reads bricks.
  for (int i = 0; i < 2; ++i) {
    RecordedClient client;
    session.answer("frame", bodyOf(jobWith({{"samples", 1}})).dump(), client);
  }
  const double one = secondsOf({{"samples", 1}});
  EXPECT_GT(one, 0);
  EXPECT_DOUBLE_EQ(secondsOf({{"samples", 1}}, 192).get<double>(), 2 * one);
  EXPECT_DOUBLE_EQ(secondsOf({{"samples", 1}, {"camera", {{"turntable", {{"frames", 10}}}}}}).get<double>(), 10 * one);
  EXPECT_TRUE(secondsOf({{"samples", 16}}).is_null());
  EXPECT_TRUE(secondsOf({{"samples", 1}, {"stereo", {{"eye", "both"}, {"interocular", 4}}}}).is_null());
}

TEST_F(ViewSessionTest, DroppedFunctionsAndThumbnails) {
  ViewSession session(source(), silent_);
  RecordedClient function, picture, estimate;
  const std::string dropped = R"([{"Name": "two", "RGBPoints": [0, 1, 0, 0, 1, 0, 0, 1], "ColorSpace": "RGB"}])";
  session.answer("function", json{{"text", dropped}}.dump(), function);
  EXPECT_GE(function.json().at("transferFunction").at("points").size(), 2u);
  EXPECT_THROW(session.answer("function", R"({"text": "no function"})", function), Error);
  session.answer("thumbnail", json{{"preset", "viridis"}, {"size", {48, 48}}, {"job", jobWith({})}}.dump(), picture);
  EXPECT_EQ(decodePng(picture.document_bytes, {}).width, 48);
  EXPECT_THROW(
      session.answer("thumbnail", json{{"preset", "a.json"}, {"size", {8, 8}}, {"job", jobWith({})}}.dump(), picture),
      Error);
  session.answer("estimate", bodyOf(jobWith({})).dump(), estimate);
  EXPECT_GT(estimate.json().at("bricks"), 0);
  EXPECT_GT(estimate.json().at("memory"), 0);
}

TEST_F(ViewSessionTest, StoppedSessions_drawNoMore) {
  ViewSession session(source(), silent_);
  session.stop();
  RecordedClient client;
  expectError([&] { session.answer("frame", bodyOf(jobWith({})).dump(), client); }, ErrorCode::kCancelled, "ended");
}

// Two volumes; the browser's list holds looks alone.
TEST_F(ViewSessionTest, SeveralVolumes_areDrawnAsInBatch) {
  const fs::path other =
      makeStore(slab({.dims = {40, 40, 40}, .type = VoxelType::u8}, 0, 10, 20, 150), "view_other", 16);
  ViewSource given = source();
  for (RenderJob* const job : {&given.drawn, &given.named}) {
    job->volumes.resize(2);
    job->volumes[0].volume = store_;
    job->volumes[1].volume = other;
  }
  ViewSession session(given, silent_);
  const json job = {{"kiln", 2},
                    {"volumes", {{{"transferFunction", json::parse(kFunction)}}, {{"transferFunction", "solid:100"}}}}};
  RecordedClient frame, save, wrong;
  session.answer("frame", bodyOf(job).dump(), frame);
  session.answer("save", bodyOf(job).dump(), save);
  ASSERT_NE(frame.stage("final"), nullptr) << frame.records.back().json;
  EXPECT_EQ(frame.records.front().json.at("transferFunctions").size(), 2u);
  EXPECT_EQ(frame.stage("final")->payload, rendered());
  expectError(
      [&] {
        session.answer("frame", bodyOf({{"kiln", 2}, {"volumes", {json::object()}}}).dump(), wrong);
      },
      ErrorCode::kUsage, "volumes");
}

}  // namespace
}  // namespace kiln::test

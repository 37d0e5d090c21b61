// Cameras of ParaView and glTF files. Known: the numbers of the files that the test writes.
#include "job/camera_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <string>

#include "job/job_flags.h"
#include "job/render_job.h"
#include "support/system/expect_error.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

class CameraFile : public ::testing::Test {
 protected:
  CameraFile() : directory_(freshDirectory("camera_file")) {}
  CameraSpec read(const std::string& name, const std::string& text) const {
    writeText(directory_ / name, text);
    CameraSpec out;
    readCameraFile(directory_ / name, out);
    return out;
  }
  void expectRefused(const std::string& name, const std::string& text, const std::string& part,
                     ErrorCode code = ErrorCode::kFormat) const {
    expectError([&] { read(name, text); }, code, part);
  }
  fs::path directory_;
};

std::string property(const std::string& name, const std::vector<double>& values) {
  std::string out = fmt::format(R"(<Property name="{}" id="1.{}" number_of_elements="{}">)", name, name, values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    out += fmt::format(R"(<Element index="{}" value="{}"/>)", i, values[i]);
  return out + R"(<Domain name="range" id="1.range"/></Property>)";
}

std::string paraView(double parallel, const std::string& position = property("CameraPosition", {1, -2.5, 300})) {
  return R"(<?xml version="1.0"?><PVCameraConfiguration description="ParaView camera configuration" version="1.0">)"
         R"(<Proxy group="views" type="RenderView" id="1" servers="21">)" +
         position + property("CameraFocalPoint", {4, 5, 6}) + property("CameraViewUp", {0, 1, 0.5}) +
         property("CameraViewAngle", {25}) + property("CameraParallelScale", {70}) +
         property("CameraParallelProjection", {parallel}) + "</Proxy></PVCameraConfiguration>\n";
}

// A node turned by 90° about x, which looks along its -z (the world's +y), inside a node 10 up.
std::string gltf(const std::string& lens, const std::string& more = "") {
  return fmt::format(
      R"({{"asset": {{"version": "2.0"}}, "cameras": [{}], "nodes": [{{"children": [1], "translation": [0, 0, 10]{}}},)"
      R"( {{"camera": 0, "rotation": [{}, 0, 0, {}], "translation": [1, -50, 3]}}]}})",
      lens, more, std::sqrt(0.5), std::sqrt(0.5));
}

void expectVector(const std::optional<glm::dvec3>& found, const glm::dvec3& expected) {
  ASSERT_TRUE(found);
  EXPECT_LT(glm::distance(*found, expected), 1e-9) << found->x << " " << found->y << " " << found->z;
}

TEST_F(CameraFile, OfParaView_isItsCamera) {
  const CameraSpec perspective = read("a.pvcc", paraView(0));
  expectVector(perspective.eye, {1, -2.5, 300});
  expectVector(perspective.target, {4, 5, 6});
  expectVector(perspective.up, {0, 1, 0.5});
  EXPECT_EQ(perspective.projection, Projection::kPerspective);
  EXPECT_EQ(perspective.fov_deg, 25);
  EXPECT_FALSE(perspective.height);
  const CameraSpec parallel = read("b.pvcc", paraView(1));
  EXPECT_EQ(parallel.projection, Projection::kOrthographic);
  EXPECT_EQ(parallel.height, 140);
}

TEST_F(CameraFile, OfGltf_hasThePlaceOfItsNode) {
  const CameraSpec camera =
      read("a.gltf", gltf(R"({"type": "perspective", "perspective": {"yfov": 0.7853981633974483, "znear": 1}})"));
  expectVector(camera.eye, {1, -50, 13});
  expectVector(camera.target, {1, 0, 13});
  expectVector(camera.up, {0, 0, 1});
  EXPECT_NEAR(*camera.fov_deg, 45, 1e-12);
  const std::string lens = R"({"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 4, "znear": 1, "zfar": 9}})";
  const CameraSpec parallel = read("b.gltf", gltf(lens, R"(, "scale": [2, 2, 2])"));
  EXPECT_EQ(parallel.height, 8);
  expectVector(parallel.eye, {2, -100, 16});
  // The JSON of a binary file is its first chunk, padded to whole words.
  std::string json = gltf(lens);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t value) {
    std::string out;
    for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i) & 255);
    return out;
  };
  const std::string head = "glTF" + word(2) + word(20 + json.size()) + word(json.size()) + "JSON";
  EXPECT_EQ(read("c.glb", head + json).height, 8);
  expectRefused("d.glb", head + json.substr(1), "d.glb");
  expectRefused("e.glb", "glTF" + word(1) + json, "e.glb");
}

TEST_F(CameraFile, Damage_isNamed) {
  expectRefused("a.pvcc", paraView(0, ""), "CameraPosition: expected 3 numbers (found 0)");
  expectRefused("b.pvcc", paraView(0, property("CameraPosition", {1, 2})), "found 2");
  expectRefused("c.pvcc", R"(<P><Property name="CameraPosition"><Element value="x"/></Property></P>)", "'x'");
  const std::string whole = paraView(0);
  expectRefused("d.pvcc", whole.substr(0, whole.size() / 2), "d.pvcc");
  expectRefused("a.gltf", R"({"nodes": []})", "a node with a camera");
  expectRefused("b.gltf", R"({"nodes": [{"camera": 1}], "cameras": [{}]})", "found '1'");
  expectRefused("c.gltf", gltf(R"({"type": "fisheye"})"), "fisheye");
  expectRefused("e.gltf",
                R"({"cameras": [{"type": "orthographic", "orthographic": {"ymag": 1}}],)"
                R"( "nodes": [{"children": [1]}, {"children": [0], "camera": 0}]})",
                "contains itself");
  expectRefused("a.obj", "", ".pvcc", ErrorCode::kUnsupported);
}

// Keys beside the file win, and the resolved job needs no file.
TEST_F(CameraFile, InAJob_isBelowOtherKeys) {
  read("a.pvcc", paraView(0));
  const fs::path job = directory_ / "job.json";
  const RenderJob read =
      parseJob(R"({"kiln": 2, "volume": "v.kiln", "camera": {"target": [0, 0, 1], "file": "a.pvcc"}})", job);
  expectVector(read.picture.camera.eye, {1, -2.5, 300});
  expectVector(read.picture.camera.target, {0, 0, 1});
  EXPECT_EQ(read.picture.camera.fov_deg, 25);
}

TEST_F(CameraFile, Flag_readsTheFile) {
  writeText(directory_ / "a.pvcc", paraView(0));
  const auto flag = std::ranges::find(jobFlags(), "--camera", &JobFlag::flag);
  ASSERT_NE(flag, jobFlags().end());
  RenderJob job;
  flag->apply({(directory_ / "a.pvcc").string()}, job);
  EXPECT_EQ(job.picture.camera.eye, glm::dvec3(1, -2.5, 300));
}

}  // namespace
}  // namespace kiln::test

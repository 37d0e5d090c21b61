#include "bench/report/report_json.h"

#include <nlohmann/json.hpp>

#include "bench/published.h"
#include "bench/summary.h"
#include "job/job_names.h"
#include "store/manifest/json_text.h"

namespace kiln {
namespace {

using Json = nlohmann::ordered_json;

Json jsonOf(const Machine& machine) {
  return {{"processor", machine.processor},
          {"logical_cores", machine.logical_cores},
          {"memory_bytes", machine.memory_bytes},
          {"system", machine.system},
          {"compiler", machine.compiler},
          {"assertions", machine.assertions},
          {"kiln", machine.version}};
}

Json jsonOf(const DistanceHistogram& distance) { return {{"pixels", distance.pixels}, {"largest", distance.largest}}; }

Json jsonOf(const VolumeSummary& v) {
  return {{"dims", {v.dims.x, v.dims.y, v.dims.z}},
          {"spacing", {v.spacing.x, v.spacing.y, v.spacing.z}},
          {"type", nameOf(v.type)},
          {"format", v.format},
          {"bricks", v.bricks},
          {"stored_bytes", v.stored_bytes},
          {"convert_s", v.convert_s}};
}

Json jsonOf(const FrameMeasurement& f) {
  const FrameStatistics& s = f.frame;
  return {{"method", nameIn(kVisibilityNames, f.method)},
          {"view", f.view},
          {"turn_deg", f.turn_deg},
          {"render_s", f.render_s},
          {"fastest_s", f.fastest_s},
          {"load_s", s.load_s},
          {"voxels", {{"visited", s.voxels_visited}, {"splats", s.voxels_splats}}},
          {"nodes", {{"tested", s.nodes_tested}, {"hidden", s.nodes_hidden}}},
          {"bricks",
           {{"total", s.bricks_total},
            {"interesting", s.bricks_interesting},
            {"read", s.bricks_read},
            {"hidden", s.bricks_hidden},
            {"read_bytes", s.bricks_read_bytes},
            {"contributing", s.bricks_contributing},
            {"contributing_bytes", s.bricks_contributing_bytes}}},
          {"identical", f.identical},
          {"distance", jsonOf(f.distance)}};
}

Json publishedJson(const SuiteCase& c, const MeasuredRun& run, VisibilityMethod method) {
  const auto visits = publishedVisits(c.paper, run.size, run.projection, method);
  const auto times = publishedTimes(c.paper, run.size, run.projection, method);
  if (!visits || !times) return nullptr;
  return {{"octree_only_visited", visits->octree_only},
          {"visited", visits->visited},
          {"ratio_percent", visits->ratio_percent},
          {"octree_only_s", times->octree_only_s},
          {"render_s", times->method_s},
          {"speed_up", times->speed_up}};
}

Json jsonOf(const Measurements& m, const MeasuredRun& run) {
  const SuiteCase& c = m.suite.cases[run.case_index];
  Json frames = Json::array(), summaries = Json::array();
  for (const FrameMeasurement& f : run.frames) frames.push_back(jsonOf(f));
  for (const VisibilityMethod method : m.suite.methods) {
    const auto s = summaryOf(run, method);
    if (!s) continue;
    summaries.push_back({{"method", nameIn(kVisibilityNames, method)},
                         {"visited", s->visited},
                         {"ratio_percent", s->ratio_percent},
                         {"render_s", s->render_s},
                         {"speed_up", s->speed_up},
                         {"identical", s->identical},
                         {"published", publishedJson(c, run, method)}});
  }
  return {{"case", c.name},
          {"classification", c.classification},
          {"paper", c.paper.empty() ? Json(nullptr) : Json(c.paper)},
          {"image", {{"width", run.size.width}, {"height", run.size.height}}},
          {"projection", nameIn(kProjectionNames, run.projection)},
          {"summary", summaries},
          {"frames", frames}};
}

Json jsonOf(const Measurements& m, const ArtifactStudy& study) {
  Json steps = Json::array();
  for (const EpsilonStep& step : study.steps) {
    steps.push_back({{"epsilon_px", step.epsilon_px},
                     {"distance", jsonOf(step.distance)},
                     {"visited", step.visited},
                     {"render_s", step.render_s}});
  }
  return {{"case", m.suite.cases[study.case_index].name},
          {"image", {{"width", study.size.width}, {"height", study.size.height}}},
          {"projection", nameIn(kProjectionNames, study.projection)},
          {"octree_only", {{"visited", study.baseline_visited}, {"render_s", study.baseline_s}}},
          {"range_tree", {{"visited", study.exact_visited}, {"render_s", study.exact_s}}},
          {"epsilon_enough_px", study.enough ? Json(study.steps[*study.enough].epsilon_px) : Json(nullptr)},
          {"steps", steps}};
}

Json jsonOf(const VisibilityCosts& costs) {
  Json updates = Json::array(), tests = Json::array();
  for (const UpdateCost& u : costs.updates) {
    updates.push_back({{"method", nameIn(kVisibilityNames, u.method)},
                       {"size_px", u.size_px},
                       {"pixels", u.pixels},
                       {"ns_per_pixel", u.ns_per_pixel}});
  }
  for (const TestCost& t : costs.tests) {
    tests.push_back({{"method", nameIn(kVisibilityNames, t.method)},
                     {"size_px", t.size_px},
                     {"area_px", t.area_px},
                     {"hidden_ns", t.hidden_ns},
                     {"mixed_ns", t.mixed_ns}});
  }
  return {{"updates", updates}, {"tests", tests}};
}

Json jsonOf(const ScalingPoint& p) {
  return {{"volume", jsonOf(p.volume)},
          {"first_s", p.first_s},
          {"render_s", p.render_s},
          {"memory_bytes", p.memory_bytes},
          {"voxels_visited", p.first.voxels_visited},
          {"read_bytes", p.first.bricks_read_bytes},
          {"contributing_bytes", p.first.bricks_contributing_bytes}};
}

}  // namespace

std::string measurementsJson(const Measurements& m) {
  Json volumes = Json::array(), runs = Json::array(), artifacts = Json::array(), standings = Json::array(),
       scaling = Json::array();
  for (const VolumeSummary& v : m.volumes) volumes.push_back(jsonOf(v));
  for (const MeasuredRun& run : m.runs) runs.push_back(jsonOf(m, run));
  for (const ArtifactStudy& study : m.artifacts) artifacts.push_back(jsonOf(m, study));
  for (const Standing& s : standingsOf(m)) {
    standings.push_back({{"method", nameIn(kVisibilityNames, s.method)},
                         {"speed_up", s.speed_up},
                         {"ratio_percent", s.ratio_percent},
                         {"wins", s.wins},
                         {"least_speed_up", s.least_speed_up},
                         {"greatest_speed_up", s.greatest_speed_up}});
  }
  for (const ScalingPoint& p : m.scaling) scaling.push_back(jsonOf(p));
  const Json out = {{"kiln_report", 1},
                    {"title", m.suite.title},
                    {"time", m.time},
                    {"command", m.command},
                    {"seconds", m.seconds},
                    {"quick", m.suite.quick},
                    {"machine", jsonOf(m.machine)},
                    {"suite", Json::parse(m.suite.text, nullptr, true, true)},
                    {"volumes", volumes},
                    {"runs", runs},
                    {"standings", standings},
                    {"artifacts", artifacts},
                    {"costs", jsonOf(m.costs)},
                    {"scaling", scaling}};
  return jsonText(out, 1) + "\n";
}

}  // namespace kiln

// Reads and checks the keys of a suite; missing keys keep the defaults of the structs.
#include "bench/suite.h"

#include <algorithm>
#include <bit>
#include <set>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "base/nearest_word.h"
#include "bench/published.h"
#include "ingest/source/formats.h"
#include "job/job_names.h"
#include "job/job_parts.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kLargestSuite_bytes = 16u << 20;
constexpr std::size_t kMostCases = 10'000;

bool isPixels(double v) { return v >= 1 && v <= 65536 && v == static_cast<int>(v); }
bool isEpsilon(double v) { return v >= 0 && v <= kLargestEpsilon && v == static_cast<int>(v); }

template <class E>
std::vector<E> named(const std::vector<std::size_t>& places) {
  std::vector<E> out;
  for (const std::size_t place : places) out.push_back(static_cast<E>(place));
  return out;
}

std::vector<int> pixelsFrom(const JobObject& object, std::string_view key, std::vector<int> otherwise) {
  const auto found = object.numberList(key, "a list of whole numbers of pixels from 1 to 65536", isPixels);
  if (!found) return otherwise;
  return std::vector<int>(found->begin(), found->end());
}

void readSizes(const JobObject& object, SuiteCase& c) {
  const auto sizes = object.pairs("sizes", "a list of [width, height] in pixels", isPixels);
  if (!sizes) return;
  if (sizes->empty()) object.refuse("sizes", "at least one [width, height]");
  c.sizes.clear();
  for (const auto& [width, height] : *sizes) c.sizes.push_back({static_cast<int>(width), static_cast<int>(height)});
}

void readNodeSlice(const JobObject& object, SuiteCase& c) {
  object.requireKnown({"axis", "index"});
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  NodeSliceRequest slice;
  slice.axis = static_cast<int>(object.choice("axis", kAxes).value_or(static_cast<std::size_t>(slice.axis)));
  slice.index = object.integer("index", 0, std::int64_t{1} << 40);
  c.node_slice = slice;
}

void readPaper(const JobObject& object, SuiteCase& c) {
  const auto row = object.text("paper", "the name of a row in the paper's tables");
  if (!row) return;
  const std::vector<std::string_view> rows = publishedNames();
  if (std::find(rows.begin(), rows.end(), *row) == rows.end()) {
    object.complain("paper", "the paper's tables have no row '" + *row + "'; did you mean '" +
                                 std::string(nearestWord(*row, rows)) + "'?");
  }
  c.paper = *row;
}

int repeatFrom(const JobObject& object, int otherwise) {
  return static_cast<int>(object.integer("repeat", 1, 1000).value_or(otherwise));
}

std::string volumeFrom(const JobObject& object, const std::string& name) {
  return namesPhantom(name) ? name : (object.path().parent_path() / name).string();
}

SuiteCase caseFrom(const JobObject& object, int repeat) {
  object.requireKnown({"name", "classification", "volume", "note", "paper", "transferFunction", "shading", "camera",
                       "sizes", "node_slice", "artifacts", "quick", "repeat"});
  SuiteCase c;
  const auto name = object.text("name", "a name for the case");
  if (!name) object.complain("name", "is missing; a case has a name, which the tables show");
  c.name = *name;
  const auto volume = object.text("volume", "a store, a volume file or phantom:NAME:XxYxZ");
  if (!volume) object.complain("volume", "is missing; a case names the store or volume file to draw");
  c.volume = volumeFrom(object, *volume);
  c.classification = object.text("classification", "a few words").value_or("");
  c.note = object.text("note", "a sentence").value_or("");
  readPaper(object, c);
  c.transfer_function = transferFunctionChoiceFrom(object).value_or(c.transfer_function);
  if (const auto shading = object.object("shading")) c.shading = shadingFrom(*shading);
  if (const auto camera = object.object("camera")) {
    c.camera = cameraFrom(*camera);
    if (c.camera.projection) camera->complain("projection", "the suite's projections are drawn, each of them");
  }
  readSizes(object, c);
  if (const auto slice = object.object("node_slice")) readNodeSlice(*slice, c);
  c.artifacts = object.flag("artifacts").value_or(c.artifacts);
  c.quick = object.flag("quick").value_or(c.quick);
  c.repeat = repeatFrom(object, repeat);
  return c;
}

void readMethods(const JobObject& root, Suite& suite) {
  if (const auto methods = root.choices("methods", kVisibilityNames)) suite.methods = named<VisibilityMethod>(*methods);
  if (suite.methods.empty() || suite.methods.front() != VisibilityMethod::kNone)
    root.complain("methods", "must begin with \"none\", octree only, which the others are measured against");
  if (const auto projections = root.choices("projections", kProjectionNames))
    suite.projections = named<Projection>(*projections);
  if (suite.projections.empty() ||
      std::count(suite.projections.begin(), suite.projections.end(), Projection::kEquirectangular) > 0)
    root.refuse("projections", "\"orthographic\", \"perspective\" or both");
}

void readDrawing(const JobObject& root, Suite& suite) {
  suite.fov_deg =
      root.number("fov", "a number of degrees in (0, 180)", [](double v) { return v > 0 && v < 180; }).value_or(60);
  suite.threshold = root.number("threshold", "a number above 0 and up to 1", [](double v) { return v > 0 && v <= 1; })
                        .value_or(suite.threshold);
  suite.views = static_cast<int>(root.integer("views", 1, 1000).value_or(suite.views));
  suite.turn_deg =
      root.number("turn_deg", "a number of degrees from 0 to 360", [](double v) { return v >= 0 && v <= 360; })
          .value_or(suite.turn_deg);
  suite.threads = static_cast<unsigned>(root.integer("threads", 0, 4096).value_or(suite.threads));
  suite.tile_px = static_cast<int>(root.integer("tile_px", 0, 65536).value_or(suite.tile_px));
  if (suite.tile_px != 0 && (suite.tile_px < 64 || !std::has_single_bit(static_cast<unsigned>(suite.tile_px))))
    root.refuse("tile_px", "0, the whole image, or a power of two from 64 on");
  if (const auto area = root.choice("area", kProjectedAreaNames)) suite.area = static_cast<ProjectedArea>(*area);
  suite.test_samples = root.flag("test_samples").value_or(suite.test_samples);
  if (const auto memory = root.text("memory", "an amount of memory such as \"2G\"")) {
    try {
      suite.memory_bytes = parseBytes(*memory);
    } catch (const Error&) {
      root.refuse("memory", "an amount of memory such as \"512M\" or \"2G\"");
    }
  }
}

void readArtifactsAndCost(const JobObject& root, Suite& suite) {
  constexpr std::string_view kEpsilons = "a list of whole numbers of pixels that begins with 0 and ascends";
  if (const auto epsilons = root.numberList("epsilon_px", kEpsilons, isEpsilon)) {
    suite.epsilons_px.assign(epsilons->begin(), epsilons->end());
    if (epsilons->empty() || epsilons->front() != 0 || !std::is_sorted(epsilons->begin(), epsilons->end()))
      root.refuse("epsilon_px", kEpsilons);
  }
  if (const auto cost = root.object("cost")) {
    cost->requireKnown({"sizes", "areas"});
    suite.cost.sizes_px = pixelsFrom(*cost, "sizes", suite.cost.sizes_px);
    suite.cost.areas_px = pixelsFrom(*cost, "areas", suite.cost.areas_px);
    for (const int size : suite.cost.sizes_px)
      if (size < 64 || size > 8192) cost->refuse("sizes", "images of 64 to 8192 pixels");
  }
}

void readScaling(const JobObject& object, ScalingRequest& scaling) {
  object.requireKnown({"volumes", "size", "transferFunction", "camera", "repeat"});
  const auto volumes = object.texts("volumes", "a list of stores, volume files or phantom:NAME:XxYxZ");
  if (!volumes || volumes->size() < 2) object.refuse("volumes", "a list of at least two volumes, the smallest first");
  for (const std::string& volume : *volumes) scaling.volumes.push_back(volumeFrom(object, volume));
  if (const auto size = object.numberList("size", "[width, height] in pixels", isPixels)) {
    if (size->size() != 2) object.refuse("size", "[width, height] in pixels");
    scaling.size = {static_cast<int>((*size)[0]), static_cast<int>((*size)[1])};
  }
  scaling.transfer_function = transferFunctionChoiceFrom(object).value_or(scaling.transfer_function);
  if (const auto camera = object.object("camera")) scaling.camera = cameraFrom(*camera);
  scaling.repeat = repeatFrom(object, scaling.repeat);
}

}  // namespace

Suite parseSuite(const std::string& text, const fs::path& path) {
  const JobObject root = JobObject::parse(text, path);
  root.requireKnown({"kiln_suite", "title", "methods", "projections", "fov", "threshold", "views", "turn_deg", "repeat",
                     "threads", "tile_px", "area", "test_samples", "memory", "epsilon_px", "cost", "scaling", "cases"});
  if (!root.has("kiln_suite")) root.complain("kiln_suite", "is missing; add \"kiln_suite\": 1");
  root.number("kiln_suite", "1, the suite format of this version", [](double v) { return v == 1; });
  Suite suite;
  suite.path = path;
  suite.text = text;
  suite.title = root.text("title", "a title").value_or(suite.title);
  readMethods(root, suite);
  readDrawing(root, suite);
  readArtifactsAndCost(root, suite);
  if (const auto scaling = root.object("scaling")) readScaling(*scaling, suite.scaling);
  const auto cases = root.objects("cases", "a list of cases [{name, volume, …}, …]", {kMostCases, "cases"});
  if (!cases || cases->empty()) root.refuse("cases", "a list of at least one case {name, volume, …}");
  const int repeat = repeatFrom(root, SuiteCase().repeat);
  std::set<std::string> names;
  for (const JobObject& object : *cases) {
    suite.cases.push_back(caseFrom(object, repeat));
    if (!names.insert(suite.cases.back().name).second) object.complain("name", "another case has this name");
  }
  return suite;
}

Suite readSuite(const fs::path& path) { return parseSuite(readTextFile(path, kLargestSuite_bytes), path); }

Suite quickened(Suite suite) {
  std::erase_if(suite.cases, [](const SuiteCase& c) { return !c.quick; });
  if (suite.cases.empty())
    throw Error(ErrorCode::kUsage, suite.path, "cases",
                "all have \"quick\": false, so a quick run is empty; let a case be drawn in quick runs");
  for (SuiteCase& c : suite.cases) {
    c.sizes.resize(1);
    c.repeat = 1;
  }
  suite.views = std::min(suite.views, 2);
  suite.scaling.repeat = 1;
  std::erase_if(suite.cost.sizes_px, [](int size) { return size > 1024; });
  suite.quick = true;
  return suite;
}

}  // namespace kiln

// Source: Lee and Ihm, §3. Ratios and speed-ups are stored as printed, not computed, so that a test can compare them
// with the times.
#include "bench/published.h"

#include <algorithm>
#include <array>

namespace kiln {
namespace {

constexpr std::array<PublishedData, 7> kData = {{
    {"BRAIN", "UNC Brain", "256×256×167", "skin"},
    {"HEAD", "UNC Head", "256×256×225", "bone"},
    {"BONESKIN", "UNC Head", "256×256×225", "bone & trans. skin"},
    {"ENGINE", "UNC Engine", "256×256×110", "block"},
    {"VM1BONESKIN", "Visible Man 1", "384×384×384", "bone & skin"},
    {"VM2BONE", "Visible Man 2", "587×341×1878", "bone"},
    {"VM2SKIN", "Visible Man 2", "587×341×1878", "skin"},
}};

// Results of a method in one projection.
struct Entry {
  std::uint64_t visited;
  double ratio_percent;
  double method_s, speed_up;
};

struct Row {
  std::string_view name;
  ImageSize size;
  std::uint64_t octree_only;
  std::array<double, 2> octree_only_s;                         // orthographic, perspective
  std::array<Entry, 2> range_tree, quadtree;                   // orthographic, perspective
  std::optional<std::array<Entry, 2>> overlay = std::nullopt;  // orthographic, perspective
};

const std::array<Row, 12> kRows = {{
    {"BRAIN",
     {256, 256},
     1841140,
     {2.50, 4.59},
     {{{125605, 6.82, 0.49, 5.10}, {74781, 4.06, 0.58, 7.91}}},
     {{{144107, 7.83, 0.46, 5.43}, {75968, 4.13, 0.49, 9.37}}},
     {{{{374010, 20.31, 0.82, 3.05}, {228755, 12.42, 0.99, 4.64}}}}},
    {"BRAIN",
     {512, 512},
     1841140,
     {3.22, 5.44},
     {{{145172, 7.88, 1.16, 2.78}, {75352, 4.09, 1.01, 5.39}}},
     {{{114999, 6.25, 0.80, 4.03}, {74153, 4.03, 0.78, 6.97}}},
     {{{{604015, 32.81, 1.56, 2.06}, {273521, 14.86, 1.42, 3.83}}}}},
    {"HEAD",
     {256, 256},
     1041109,
     {2.03, 3.28},
     {{{404140, 38.82, 1.41, 1.44}, {250071, 24.02, 1.60, 2.05}}},
     {{{412407, 39.61, 1.34, 1.51}, {253023, 24.30, 1.48, 2.22}}},
     {{{{636374, 61.12, 1.68, 1.21}, {461052, 44.28, 2.14, 1.53}}}}},
    {"HEAD",
     {512, 512},
     1041109,
     {3.08, 4.14},
     {{{404367, 38.84, 2.96, 1.04}, {248817, 23.90, 2.82, 1.47}}},
     {{{392558, 37.71, 2.45, 1.25}, {247550, 23.78, 2.39, 1.73}}},
     {{{{781471, 75.06, 3.02, 1.02}, {531907, 51.09, 3.29, 1.26}}}}},
    {"BONESKIN",
     {256, 256},
     3593793,
     {6.59, 11.43},
     {{{1252323, 34.85, 4.08, 1.62}, {965060, 26.85, 5.74, 1.99}}},
     {{{1246309, 34.68, 3.88, 1.70}, {980304, 27.28, 5.49, 2.08}}},
     {{{{1747621, 48.63, 4.64, 1.42}, {1499644, 41.73, 7.03, 1.63}}}}},
    {"BONESKIN",
     {512, 512},
     3593793,
     {10.64, 15.18},
     {{{1157769, 32.22, 8.86, 1.20}, {931888, 25.93, 10.39, 1.46}}},
     {{{1126928, 31.36, 7.96, 1.34}, {926174, 25.77, 9.45, 1.61}}},
     {{{{2111928, 58.77, 9.48, 1.12}, {1697359, 47.23, 11.87, 1.28}}}}},
    {"ENGINE",
     {256, 256},
     1111569,
     {1.73, 3.05},
     {{{152259, 13.70, 0.61, 2.84}, {123384, 11.10, 0.90, 3.39}}},
     {{{147302, 13.25, 0.52, 3.33}, {122394, 11.01, 0.79, 3.86}}},
     {{{{354015, 31.85, 0.86, 2.01}, {275563, 24.79, 1.24, 2.46}}}}},
    {"ENGINE",
     {512, 512},
     1111569,
     {2.14, 3.58},
     {{{167240, 15.05, 1.36, 1.57}, {114455, 10.30, 1.66, 2.16}}},
     {{{151573, 13.64, 1.03, 2.08}, {114239, 10.28, 1.35, 2.65}}},
     {{{{486646, 43.78, 1.55, 1.38}, {317345, 28.55, 2.00, 1.79}}}}},
    {"VM1BONESKIN",
     {384, 384},
     6152250,
     {8.37, 15.23},
     {{{922612, 15.00, 2.63, 3.18}, {605368, 9.84, 3.43, 4.44}}},
     {{{972882, 15.81, 2.50, 3.35}, {611788, 9.94, 3.23, 4.72}}}},
    {"VM1BONESKIN",
     {768, 768},
     6152250,
     {10.49, 16.85},
     {{{759773, 12.35, 5.28, 1.99}, {685184, 11.14, 5.88, 2.87}}},
     {{{769964, 12.52, 4.44, 2.36}, {684415, 11.12, 5.04, 3.34}}}},
    {"VM2BONE",
     {340, 1024},
     6684695,
     {15.17, 25.80},
     {{{2214662, 33.13, 9.10, 1.67}, {1522817, 22.78, 10.56, 2.44}}},
     {{{2556224, 38.24, 9.55, 1.59}, {2071589, 30.99, 13.02, 1.98}}}},
    {"VM2SKIN",
     {340, 1024},
     84222607,
     {113.94, 203.24},
     {{{4512176, 5.36, 17.07, 6.67}, {2680970, 3.18, 17.90, 11.35}}},
     {{{6105606, 7.25, 19.45, 5.86}, {4500617, 5.34, 23.94, 8.49}}}},
}};

struct Found {
  const Row* row;
  Entry entry;
  double octree_only_s;
};

std::optional<Found> find(std::string_view name, const ImageSize& size, Projection projection,
                          VisibilityMethod method) {
  const auto row = std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) {
    return r.name == name && r.size.width == size.width && r.size.height == size.height;
  });
  if (row == kRows.end()) return std::nullopt;
  const std::size_t half = projection == Projection::kOrthographic ? 0 : 1;
  const double octree_only_s = row->octree_only_s[half];
  if (method == VisibilityMethod::kRangeTree) return Found{&*row, row->range_tree[half], octree_only_s};
  if (method == VisibilityMethod::kQuadtree) return Found{&*row, row->quadtree[half], octree_only_s};
  if (method == VisibilityMethod::kOverlay && row->overlay) return Found{&*row, (*row->overlay)[half], octree_only_s};
  return std::nullopt;
}

}  // namespace

std::vector<std::string_view> publishedNames() {
  std::vector<std::string_view> out;
  for (const PublishedData& data : kData) out.push_back(data.name);
  return out;
}

std::optional<PublishedData> publishedData(std::string_view name) {
  const auto found = std::find_if(kData.begin(), kData.end(), [&](const PublishedData& d) { return d.name == name; });
  return found == kData.end() ? std::nullopt : std::optional(*found);
}

std::vector<PublishedRow> publishedRows() {
  std::vector<PublishedRow> out;
  for (const Row& row : kRows) out.push_back({row.name, row.size});
  return out;
}

std::optional<PublishedVisits> publishedVisits(std::string_view name, const ImageSize& size, Projection projection,
                                               VisibilityMethod method) {
  const auto found = find(name, size, projection, method);
  if (!found) return std::nullopt;
  return PublishedVisits{found->row->octree_only, found->entry.visited, found->entry.ratio_percent};
}

std::optional<PublishedTimes> publishedTimes(std::string_view name, const ImageSize& size, Projection projection,
                                             VisibilityMethod method) {
  const auto found = find(name, size, projection, method);
  if (!found) return std::nullopt;
  return PublishedTimes{found->octree_only_s, found->entry.method_s, found->entry.speed_up};
}

}  // namespace kiln

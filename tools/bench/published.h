// What Lee and Ihm measured, as data: their Tables 1, 2, 3 and 5, number by number. Their machine was an SGI
// workstation with a 195 MHz R10000, so times are to be read beside ours only as ratios.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "job/render_job.h"
#include "scene/camera/camera.h"

namespace kiln {

inline constexpr std::string_view kPublishedMachine = "SGI workstation, 195 MHz R10000";

/// Table 1.
struct PublishedData {
  std::string_view name, data, size, classification;
};

/// One half (one projection) of a row of Table 2(a), 2(b) or 5(a).
struct PublishedVisits {
  std::uint64_t octree_only = 0, visited = 0;
  double ratio_percent = 0;
};

/// The same of Table 3(a), 3(b) or 5(b). unit: seconds.
struct PublishedTimes {
  double octree_only_s = 0, method_s = 0;
  double speed_up = 0;
};

/// A row of the tables: one classification at one image size.
struct PublishedRow {
  std::string_view name;
  ImageSize size;
};

/// The names of all rows, each once, in the paper's order.
std::vector<std::string_view> publishedNames();
std::optional<PublishedData> publishedData(std::string_view name);
std::vector<PublishedRow> publishedRows();

/// Empty where the paper has no such number: another method, another size, or a row that Table 5 leaves out.
std::optional<PublishedVisits> publishedVisits(std::string_view name, const ImageSize& size, Projection projection,
                                               VisibilityMethod method);
std::optional<PublishedTimes> publishedTimes(std::string_view name, const ImageSize& size, Projection projection,
                                             VisibilityMethod method);

}  // namespace kiln

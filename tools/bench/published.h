// The measurements of Lee and Ihm as data: Tables 1, 2, 3 and 5, number by number. Their machine was an SGI workstation
// with a 195 MHz R10000, so only ratios of times are comparable.
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

/// One half of a row of Table 3(a), 3(b) or 5(b). unit: seconds.
struct PublishedTimes {
  double octree_only_s = 0, method_s = 0;
  double speed_up = 0;
};

/// A row of the tables: a classification at one image size.
struct PublishedRow {
  std::string_view name;
  ImageSize size;
};

/// Returns the names of all rows, each name once, in the paper's order.
std::vector<std::string_view> publishedNames();
std::optional<PublishedData> publishedData(std::string_view name);
std::vector<PublishedRow> publishedRows();

/// Empty if the paper has no such number: another method or size, or a row omitted in Table 5.
std::optional<PublishedVisits> publishedVisits(std::string_view name, const ImageSize& size, Projection projection,
                                               VisibilityMethod method);
std::optional<PublishedTimes> publishedTimes(std::string_view name, const ImageSize& size, Projection projection,
                                             VisibilityMethod method);

}  // namespace kiln

// The options of opacity over values and gradients, and of scattering.
#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/file/file.h"
#include "base/text.h"
#include "image/file/png_file.h"
#include "image/srgb.h"
#include "job/job_names.h"
#include "job/job_options.h"
#include "scene/scene_limits.h"

namespace kiln {
namespace {

constexpr NumberRange kFactor{0, 1};
constexpr std::string_view kShareRange = "fraction";

// Two limits, the first below the second.
template <class Owner>
OptionValue<Owner> limitsValue(glm::dvec2 Owner::*member, const NumberRange& range) {
  const std::string expected = range.least == 0 ? "[least, greatest], the least 0 or above and below the greatest"
                                                : "[least, greatest], the least below the greatest";
  OptionForm form;
  form.schema = {{"$ref", "pair"}};
  return OptionValue<Owner>::custom(
             std::move(form),
             [member, range, expected](const JobObject& object, std::string_view key, Owner& owner) {
               const auto limits = *object.numbers<2>(key, expected, range);
               if (!(limits[0] < limits[1])) object.refuse(key, expected);
               owner.*member = {limits[0], limits[1]};
             },
             [member](const Owner& owner) {
               return nlohmann::ordered_json{(owner.*member).x, (owner.*member).y};
             })
      .resolvedIf(kAlways);
}

// The factors of a picture: its brightest channel as stored, times alpha. The lowest row of pixels is the first.
void readPicture(const std::filesystem::path& path, GradientTable& table) {
  constexpr std::uint64_t kLargestFile_bytes = 64u << 20, kMostBytes = 16 * kMostTableNodes + (32u << 20);
  const Image image = decodePng(readFile(path, kLargestFile_bytes), path, kMostBytes);
  const auto nodes = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (image.width > kMostTableEdge || image.height > kMostTableEdge || nodes > kMostTableNodes)
    throw Error(ErrorCode::kUsage, path, "",
                fmt::format("expected at most {} factors and {} along a side (found {} x {}); scale the picture down",
                            kMostTableNodes, kMostTableEdge, image.width, image.height));
  table.columns = image.width, table.rows = image.height;
  table.opacity.clear();
  for (int row = image.height - 1; row >= 0; --row) {
    for (int column = 0; column < image.width; ++column) {
      const float* const p = image.pixel(column, row);
      const float alpha = p[3], brightest = std::max({p[0], p[1], p[2]});
      const double stored = alpha > 0 ? srgbFromLinear(static_cast<double>(brightest / alpha)) : 0;
      table.opacity.push_back(static_cast<float>(std::clamp(stored, 0.0, 1.0)) * alpha);
    }
  }
}

// The shortest number that a float is read from.
double shortNumber(float value) { return *numberOf<double>(fmt::format("{}", value)); }

// A picture, or the factors row by row.
OptionValue<GradientTable> nodesValue() {
  OptionForm form;
  form.schema["anyOf"] = {{{"$ref", "text"}}, {{"type", "array"}, {"items", {{"$ref", kShareRange}}}, {"minItems", 1}}};
  const auto read = [](const JobObject& object, std::string_view key, GradientTable& table) {
    if (object.isText(key)) {
      if (table.columns > 0) object.complain("columns", "contradicts a picture, which has columns of its own");
      return readPicture(object.path().parent_path() / *object.text(key, "a file name"), table);
    }
    const std::string expected = fmt::format(
        "the name of a PNG file, or the numbers from 0 to 1 of all rows of {} columns", std::max(table.columns, 1));
    const auto factors = *object.numberList(key, expected, &legal::fraction);
    const auto columns = static_cast<std::size_t>(table.columns);
    if (columns == 0) object.complain("columns", "is missing; it is the number of factors of a row");
    if (factors.empty() || factors.size() % columns != 0 || factors.size() > kMostTableNodes)
      object.refuse(key, expected);
    table.rows = static_cast<int>(factors.size() / columns);
    table.opacity.assign(factors.begin(), factors.end());
  };
  const auto write = [](const GradientTable& table) {
    auto out = nlohmann::ordered_json::array();
    for (const float factor : table.opacity) out.push_back(shortNumber(factor));
    return out;
  };
  return OptionValue<GradientTable>::custom(std::move(form), read, write).resolvedIf(kAlways);
}

}  // namespace

const Options<GradientRegion>& gradientRegionOptions() {
  constexpr std::string_view kMissing = "a region has values and gradients";
  using Row = Option<GradientRegion>;
  static const Options<GradientRegion> kOptions = {
      Row("shape", {KILN_MEMBER(shape), Word{kRegionShapeNames}, kAlways},
          "rectangle, or a triangle with its tip in the middle of the values at the least gradient."),
      Row("values", limitsValue(&GradientRegion::values, {-kLargestValue, kLargestValue}), "Least and greatest value.",
          kMissing),
      Row("gradients", limitsValue(&GradientRegion::gradients, {0, kLargestValue}),
          "Least and greatest length of the gradient, in values per world unit.", kMissing),
      Row("opacity", {KILN_MEMBER(opacity), Number{kFactor, "", kShareRange}, kAlways},
          "Factor of the opacity of the points."),
      Row("softness", {KILN_MEMBER(softness), Number{kFactor, "", kShareRange}, kAlways},
          "Share of the half width over which the opacity rises at an edge."),
      Row("color",
          {KILN_MEMBER(color), ColorValue{kFactor, kShareRange},
           [](const GradientRegion& region) { return region.color.has_value(); }},
          "Colour instead of the colour of the points."),
  };
  return kOptions;
}

const Options<GradientTable>& gradientTableOptions() {
  static constexpr std::string_view kMissing = "a table has values, gradients and opacity";
  static const auto kThere = [](const GradientTable& table) { return table.columns > 0; };
  using Row = Option<GradientTable>;
  static const Options<GradientTable> kOptions = [] {
    Options<GradientTable> rows = {
        Row("values", limitsValue(&GradientTable::values, {-kLargestValue, kLargestValue}),
            "Values of the first and the last column.", kMissing),
        Row("gradients", limitsValue(&GradientTable::gradients, {0, kLargestValue}),
            "Gradients of the first and the last row, in values per world unit.", kMissing),
        Row("columns", {KILN_MEMBER(columns), Whole{1, kMostTableEdge, "columns"}}, "Number of factors of a row."),
        Row("opacity", nodesValue(),
            "Factors of the opacity of the points, row by row from the least gradient on; or the name of a PNG file, "
            "whose lowest row has the least gradient.",
            kMissing),
    };
    for (Row& row : rows) row.value.resolved = kThere;
    return rows;
  }();
  return kOptions;
}

const Options<Scattering>& scatteringOptions() {
  using Row = Option<Scattering>;
  static const Options<Scattering> kOptions = {
      Row("albedo", {KILN_MEMBER(albedo), Number{kFactor, "", kShareRange}, kAlways},
          "Share of the light that is scattered, not absorbed."),
      Row("anisotropy", {KILN_MEMBER(anisotropy), Number{{-0.99, 0.99}}, kAlways},
          "Mean cosine of the scattered light's angle: 0 evenly, above 0 forward, below 0 back."),
  };
  return kOptions;
}

}  // namespace kiln

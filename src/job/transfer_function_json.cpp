#include "job/transfer_function_json.h"

#include <set>

#include "image/srgb.h"
#include "scene/scene_limits.h"
#include "scene/transfer/label_styles.h"

namespace kiln {
namespace {

constexpr std::array<std::string_view, 2> kColorSpaceNames = {"linear", "srgb"};

glm::dvec3 colorFrom(const JobObject& object, bool srgb) {
  const auto color = *object.numbers<3>("color", "[red, green, blue] from 0 to 1", legal::fraction);
  glm::dvec3 out;
  for (int channel = 0; channel < 3; ++channel) {
    const double given = color[static_cast<std::size_t>(channel)];
    out[channel] = srgb ? linearFromSrgb(given) : given;
  }
  return out;
}

TransferPoint pointFrom(const JobObject& object, bool srgb) {
  object.requireKnown(job_keys::kPoint);
  for (const char* key : {"value", "color", "opacity"}) {
    if (!object.has(key)) object.complain(key, "is missing; a point has value, color and opacity");
  }
  TransferPoint point;
  point.value = *object.number("value", "a finite number", legal::voxelValue);
  point.opacity = *object.number("opacity", "a number from 0 to 1", legal::fraction);
  point.color = colorFrom(object, srgb);
  return point;
}

std::vector<GradientPoint> gradientOpacityFrom(const JobObject& owner) {
  const auto points =
      owner.objects("gradientOpacity", "a list of points [{gradient, factor}, …]", {kMostPoints, "points"});
  std::vector<GradientPoint> out;
  if (!points) return out;
  for (const JobObject& point : *points) {
    point.requireKnown(job_keys::kGradientPoint);
    for (const char* key : {"gradient", "factor"}) {
      if (!point.has(key)) point.complain(key, "is missing; a point has gradient and factor");
    }
    const auto legal_gradient = [](double v) { return v >= 0 && legal::voxelValue(v); };
    out.push_back({*point.number("gradient", "a number of values per world unit, 0 or above", legal_gradient),
                   *point.number("factor", "a number from 0 to 1", legal::fraction)});
    if (out.size() > 1 && out[out.size() - 2].gradient > out.back().gradient)
      point.refuse("gradient", "a gradient not below that of the point before, for points are sorted");
  }
  return out;
}

std::vector<LabelStyle> labelsFrom(const JobObject& owner, bool srgb) {
  std::vector<LabelStyle> out;
  const auto labels =
      owner.objects("labels", "a list of labels [{label, color, opacity}, …]", {kMostLabelLooks, "labels"});
  std::set<double> known;
  if (labels->empty()) owner.refuse("labels", "a list of at least one label {label, color, opacity}");
  for (const JobObject& object : *labels) {
    object.requireKnown(job_keys::kLabel);
    for (const char* key : {"label", "color"}) {
      if (!object.has(key)) object.complain(key, "is missing; a label has label and color");
    }
    LabelStyle look;
    const auto most = static_cast<std::int64_t>(kLargestLabel);
    look.label = static_cast<double>(*object.integer("label", -most, most));
    if (!known.insert(look.label).second) object.complain("label", "is given twice");
    look.name = object.text("name", "a name").value_or("");
    look.color = colorFrom(object, srgb);
    look.opacity = object.number("opacity", "a number from 0 to 1", legal::fraction).value_or(look.opacity);
    out.push_back(std::move(look));
  }
  sortLabels(out);
  return out;
}

}  // namespace

TransferFunction transferFunctionFrom(const JobObject& object) {
  object.requireKnown(job_keys::kTransferFunction);
  TransferFunction out;
  const auto legal_unit = [](double v) { return v == 0 || legal::positiveLength(v); };
  out.unit = object.number("unit", "a length above 0, or 0 for the mean voxel spacing", legal_unit).value_or(0);
  const bool srgb = object.choice("colorSpace", kColorSpaceNames).value_or(0) == 1;
  if (object.has("labels")) {
    for (const char* key : {"points", "gradientOpacity"}) {
      if (object.has(key)) object.complain(key, "contradicts labels; a function has points or labels");
    }
    out.labels = labelsFrom(object, srgb);
    return out;
  }
  const auto points =
      object.objects("points", "a list of points [{value, color, opacity}, …]", {kMostPoints, "points"});
  if (!points || points->empty()) object.refuse("points", "a list of at least one point {value, color, opacity}");
  for (const JobObject& point : *points) {
    out.points.push_back(pointFrom(point, srgb));
    const std::size_t count = out.points.size();
    if (count < 2 || out.points[count - 2].value <= out.points[count - 1].value) continue;
    point.refuse("value", "a value not below that of the point before, for points are sorted");
  }
  out.gradient_opacity = gradientOpacityFrom(object);
  return out;
}

}  // namespace kiln

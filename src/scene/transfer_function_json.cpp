#include "scene/transfer_function_json.h"

#include "base/srgb.h"

namespace kiln {
namespace {

constexpr std::array<std::string_view, 2> kColorSpaceNames = {"linear", "srgb"};

TransferPoint pointFrom(const JobObject& object, bool srgb) {
  object.requireKnown(job_keys::kPoint);
  for (const char* key : {"value", "color", "opacity"}) {
    if (!object.has(key)) object.complain(key, "is missing; a point has value, color and opacity");
  }
  TransferPoint point;
  point.value = *object.number("value", "a finite number", legal::voxelValue);
  point.opacity = *object.number("opacity", "a number from 0 to 1", legal::fraction);
  const auto color = *object.numbers<3>("color", "[red, green, blue] from 0 to 1", legal::fraction);
  for (int channel = 0; channel < 3; ++channel) {
    const double given = color[static_cast<std::size_t>(channel)];
    point.color[channel] = srgb ? linearFromSrgb(given) : given;
  }
  return point;
}

std::vector<GradientPoint> gradientOpacityFrom(const JobObject& owner) {
  const auto points = owner.objects("gradientOpacity", "a list of points [{gradient, factor}, …]");
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

}  // namespace

TransferFunction transferFunctionFrom(const JobObject& object) {
  object.requireKnown(job_keys::kTransferFunction);
  TransferFunction out;
  const auto legal_unit = [](double v) { return v == 0 || legal::positiveLength(v); };
  out.unit = object.number("unit", "a length above 0, or 0 for the mean voxel spacing", legal_unit).value_or(0);
  const bool srgb = object.choice("colorSpace", kColorSpaceNames).value_or(0) == 1;
  const auto points = object.objects("points", "a list of points [{value, color, opacity}, …]");
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

#include "job/transfer_function_json.h"

#include <set>

#include "image/srgb.h"
#include "job/job_names.h"
#include "job/job_options.h"
#include "scene/transfer/label_styles.h"

namespace kiln {
namespace {

void makeLinear(glm::dvec3& color) {
  for (int channel = 0; channel < 3; ++channel) color[channel] = linearFromSrgb(color[channel]);
}

void requireOnce(const JobObject& object, const std::vector<LabelStyle>& labels) {
  std::set<double> known;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (known.insert(labels[i].label).second) continue;
    object.objects("labels", "labels", {labels.size(), "labels"})->at(i).complain("label", "is given twice");
  }
}

}  // namespace

TransferFunction transferFunctionFrom(const JobObject& object) {
  TransferFunction out;
  if (object.has("labels")) {
    for (const char* key : {"points", "gradientOpacity"}) {
      if (object.has(key)) object.complain(key, "contradicts labels; a function has points or labels");
    }
  }
  readOptions(transferFunctionOptions(), object, out);
  if (out.labels.empty() && out.points.empty())
    object.refuse("points", "a list of at least one point {value, color, opacity}");
  if (object.choice("colorSpace", kColorSpaceNames).value_or(0) == 1) {
    for (TransferPoint& point : out.points) makeLinear(point.color);
    for (LabelStyle& style : out.labels) makeLinear(style.color);
  }
  requireOnce(object, out.labels);
  sortLabels(out.labels);
  return out;
}

}  // namespace kiln

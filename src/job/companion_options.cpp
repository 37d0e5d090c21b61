// The options of companions: masks, and colours by another volume.
#include <fmt/format.h>

#include <cmath>

#include "job/job_options.h"
#include "job/job_parts.h"
#include "job/option_kinds.h"
#include "job/stated_job.h"
#include "scene/scene_limits.h"
#include "scene/transfer/label_styles.h"

namespace kiln {
namespace {

constexpr auto kLastLabel = static_cast<std::int64_t>(kLargestLabel);

OptionValue<MaskChoice> labelsValue() {
  OptionForm form;
  form.schema = {{"type", "array"},
                 {"items", {{"type", "integer"}, {"minimum", -kLastLabel}, {"maximum", kLastLabel}}},
                 {"minItems", 1},
                 {"maxItems", kMostMaskLabels}};
  return OptionValue<MaskChoice>::custom(
             std::move(form),
             [](const JobObject& object, std::string_view key, MaskChoice& mask) {
               constexpr std::string_view kExpected = "a list of at least one label, a whole number";
               const std::vector<double> labels = *object.numberList(
                   key, kExpected, [](double v) { return std::abs(v) <= kLargestLabel && v == std::trunc(v); });
               if (labels.empty() || labels.size() > kMostMaskLabels) object.refuse(key, kExpected);
               mask.labels.assign(labels.begin(), labels.end());
             },
             [](const MaskChoice& mask) { return nlohmann::ordered_json(mask.labels); })
      .resolvedIf(kAlways);
}

}  // namespace

const Options<MaskChoice>& maskOptions() {
  using Row = Option<MaskChoice>;
  static const Options<MaskChoice> kOptions = {
      Row("volume", {KILN_MEMBER(volume), FileName{}, kAlways}, "A store or volume file of labels, at the same place.",
          "a mask names its store or volume file"),
      Row("labels", labelsValue(), "The labels where the volume is shown.", "a mask lists the labels that show"),
  };
  return kOptions;
}

const Options<ColorByChoice>& colorByOptions() {
  using Row = Option<ColorByChoice>;
  static const Options<ColorByChoice> kOptions = [] {
    OptionForm function;
    function.schema = {{"anyOf", {{{"$ref", "text"}}, {{"$ref", "transferFunction"}}}}};
    return Options<ColorByChoice>{
        Row("volume", {KILN_MEMBER(volume), FileName{}, kAlways}, "A store or volume file at the same place.",
            "colours come from a store or volume file"),
        Row("transferFunction",
            OptionValue<ColorByChoice>::custom(
                std::move(function),
                [](const JobObject& object, std::string_view key, ColorByChoice& colors) {
                  colors.transfer_function = *transferFunctionChoiceFrom(object, key);
                },
                [](const ColorByChoice& colors) { return statedJson(colors.transfer_function); })
                .resolvedIf(kAlways),
            "Colours of the values of this volume; its opacity is ignored.")};
  }();
  return kOptions;
}

}  // namespace kiln

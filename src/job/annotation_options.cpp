// The options of annotations, over the finished picture.
#include <fmt/format.h>

#include <utility>

#include "job/job_names.h"
#include "job/job_options.h"
#include "scene/annotation_text.h"

namespace kiln {
namespace {

using enum OptionGroup;

std::string expectedText() {
  std::string out = "a text with placeholders among";
  for (const std::string_view name : kPlaceholders) out += fmt::format(" {{{}}}", name);
  return out + "; {{ and }} are braces";
}

OptionValue<Annotations> textValue() {
  OptionForm form = Text{"a text"}.form();
  form.expected = expectedText();
  form.parse = [](const std::string& text) -> nlohmann::json {
    if (!wrongPlaceholder(text).empty()) return {};
    return text;
  };
  form.wrong_part = [](const std::string& text) { return wrongPlaceholder(text); };
  const auto read = [](const JobObject& object, std::string_view key, Annotations& out) {
    Text{"a text"}.read(object, key, out.text);
    if (!wrongPlaceholder(out.text).empty()) object.refuse(key, expectedText());
  };
  return OptionValue<Annotations>::custom(std::move(form), read,
                                          [](const Annotations& annotations) { return annotations.text; })
      .resolvedIf([](const Annotations& annotations) { return !annotations.text.empty(); });
}

}  // namespace

const Options<Annotations>& annotationOptions() {
  using Row = Option<Annotations>;
  static const Options<Annotations> kOptions = {
      Row("scaleBar", "--scale-bar", kAnnotations,
          {KILN_MEMBER(scale_bar), Switch{}, [](const Annotations& a) { return a.scale_bar; }},
          "Draw a bar of 1, 2 or 5 times a power of ten of the volume's unit of length; in perspective it is right at "
          "the depth of the camera's target."),
      Row("scaleBarLength", "--scale-bar-length", kAnnotations,
          {KILN_MEMBER(scale_bar_length), Number{{0, 1e12, true}, "world units"},
           [](const Annotations& a) { return a.scale_bar_length.has_value(); }},
          "Length of the scale bar; a bar that is longer than the picture is left out. Default: a round length."),
      Row("box", "--box", kAnnotations, {KILN_MEMBER(box), Switch{}, [](const Annotations& a) { return a.box; }},
          "Draw the outline of the volume's box after clipping; edges behind what is drawn are dashed and dim."),
      Row("legend", "--legend", kAnnotations,
          {KILN_MEMBER(legend), Switch{}, [](const Annotations& a) { return a.legend; }},
          "Draw the colours of the transfer function with their values, the colours of its surfaces, or the names of "
          "its labels; a camera without --eye and --target fits the volume beside it."),
      Row("legendTitle", "--legend-title", kAnnotations,
          {KILN_MEMBER(legend_title), Text{"a text"}, [](const Annotations& a) { return !a.legend_title.empty(); }},
          "Title of the legend, such as the quantity and its unit."),
      Row("legendPosition", "--legend-position", kAnnotations,
          {KILN_MEMBER(legend_place), Word{kLegendPlaceNames},
           [](const Annotations& a) { return a.legend_place.has_value(); }},
          "Side or corner of the legend. Default: the right side; in a tall picture the upper right corner."),
      Row("axes", "--axes", kAnnotations, {KILN_MEMBER(axes), Switch{}, [](const Annotations& a) { return a.axes; }},
          "Draw the directions of the world: letters R, L, A, P, S and I of a patient, else arrows x, y and z."),
      Row("text", "--text", kAnnotations, textValue(),
          "Draw a text in the upper left corner. {frame}, {time} (seconds of a video), {volume} (its name), {unit} (of "
          "length), {minimum}, {maximum} and {voxels} are filled in; {{ is a brace."),
      Row("color", "--annotation-color", kAnnotations,
          {KILN_MEMBER(color), ColorValue{{0, 1}, "fraction"},
           [](const Annotations& a) { return a.color.has_value(); }},
          "Colour of text and lines, r,g,b in linear light, a name, #rgb or #rrggbb. Default: dark on a light or "
          "transparent background, else light."),
      Row("size", "--annotation-size", kAnnotations,
          {KILN_MEMBER(size), Number{{kLeastAnnotationSize, kMostAnnotationSize}},
           [](const Annotations& a) { return a.any() && a.size != 1; }},
          "Size of text and lines, as a factor. At 1, text has 1/36 of the picture's shorter side."),
  };
  return kOptions;
}

}  // namespace kiln

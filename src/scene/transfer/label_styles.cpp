#include "scene/transfer/label_styles.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/vector_relational.hpp>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/text.h"
#include "image/srgb.h"
#include "scene/scene_limits.h"
#include "scene/transfer/color_map.h"
#include "scene/transfer/label_palette.h"

namespace kiln {
namespace {

// Returns a line of text without surrounding space; empty for a comment.
std::string content(std::string line) {
  line.erase(0, std::min(line.find_first_not_of(" \t\r"), line.size()));
  line.erase(line.find_last_not_of(" \t\r") + 1);
  return line.starts_with('#') ? "" : line;
}

// Opacity of labels whose source has none.
constexpr double kPaletteOpacity = 0.95;

struct Described {
  LabelStyle style;
  std::optional<double> alpha;  // in a colour table. unit: 255ths
  bool listed = false;          // in a list of names
};

bool isLabel(double number) { return number >= 0 && number <= kLargestLabel && number == std::floor(number); }

bool areBytes(const glm::dvec3& channels) {
  return glm::all(glm::greaterThanEqual(channels, glm::dvec3(0))) &&
         glm::all(glm::lessThanEqual(channels, glm::dvec3(255)));
}

// A line of ITK-SNAP's.
std::optional<Described> itkSnapLine(const std::string& line) {
  std::istringstream in(line);
  double label = 0, opacity = 0, in_slices = 0, in_mesh = 0;
  glm::dvec3 channels(0);
  in >> label >> channels[0] >> channels[1] >> channels[2] >> opacity >> in_slices >> in_mesh;
  if (!in) return std::nullopt;
  std::string name;
  std::getline(in, name);
  name = content(name);
  if (name.size() < 2 || name.front() != '"' || name.back() != '"') return std::nullopt;
  if (!isLabel(label) || !areBytes(channels) || !(opacity >= 0 && opacity <= 1)) return std::nullopt;
  return Described{{label, name.substr(1, name.size() - 2), linearFromSrgb(channels / 255.0),
                    in_mesh != 0 && label != 0 ? opacity : 0},
                   {}};
}

// A line of a colour table of FreeSurfer's or 3D Slicer's: index, name without blanks, red, green, blue, alpha.
std::optional<Described> tableLine(const std::string& line) {
  std::istringstream in(line);
  double label = 0, alpha = 0;
  glm::dvec3 channels(0);
  std::string name, more;
  in >> label >> name >> channels[0] >> channels[1] >> channels[2] >> alpha;
  if (!in || in >> more || numberOf<double>(name)) return std::nullopt;
  if (!isLabel(label) || !areBytes(channels) || !(alpha >= 0 && alpha <= 255)) return std::nullopt;
  return Described{{label, name, linearFromSrgb(channels / 255.0), label != 0 ? 1.0 : 0.0}, alpha};
}

// A line of a list of names, as beside the atlases of MRIcron and FSL: index, and the rest is the name.
std::optional<Described> nameLine(const std::string& line) {
  std::istringstream in(line);
  double label = 0;
  std::string name;
  in >> label;
  if (!in || !std::getline(in, name)) return std::nullopt;
  name = content(name);
  if (!isLabel(label) || name.empty() || name.find('"') != std::string::npos) return std::nullopt;
  if (numberOf<double>(name.substr(0, name.find_first_of(" \t")))) return std::nullopt;
  return Described{{label, name, paletteColor(std::max(label, 1.0)), label != 0 ? kPaletteOpacity : 0}, {}, true};
}

// Lists of MRIcron end each line with the number of a region in the atlas's own count. A column of whole numbers is no
// part of the names if the names differ without the column.
void dropNumberColumn(std::vector<Described>& all) {
  std::set<std::string> names;
  for (const Described& each : all) {
    const std::string& name = each.style.name;
    const std::size_t blank = name.find_last_of(" \t");
    if (!each.listed || blank == std::string::npos || !decimalOf<std::int64_t>(name.substr(blank + 1))) return;
    if (!names.insert(content(name.substr(0, blank))).second) return;
  }
  for (Described& each : all) each.style.name = content(each.style.name.substr(0, each.style.name.find_last_of(" \t")));
}

std::optional<Described> describedBy(const std::string& line) {
  for (const auto read : {itkSnapLine, tableLine, nameLine}) {
    if (auto found = read(line)) return found;
  }
  return std::nullopt;
}

}  // namespace

bool isLabelDescription(const std::string& text) {
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    // No JSON of a function begins with a number.
    if (const std::string said = content(line); !said.empty())
      return said.front() == '-' || said.front() == '.' || (said.front() >= '0' && said.front() <= '9');
    if (line.find("Label Description File") != std::string::npos) return true;
  }
  return text.find('#') != std::string::npos;
}

TransferFunction labelDescription(const std::string& text, const std::filesystem::path& path) {
  constexpr std::size_t kMost = 80;
  std::vector<Described> all;
  std::istringstream in(text);
  std::set<double> known;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::string said = content(line);
    if (said.empty()) continue;
    const auto found = describedBy(said);
    if (!found)
      throw Error(ErrorCode::kFormat, path, fmt::format("line {}", number),
                  fmt::format("expected a label's index, red, green, blue (0 to 255), opacity (0 to 1), two of 0 or 1, "
                              "and its name in quotes; or index, name, red, green, blue, alpha; or index and name "
                              "(found '{}{}'); mend the line, or put # before it",
                              said.substr(0, kMost), said.size() > kMost ? "..." : ""));
    if (!known.insert(found->style.label).second)
      throw Error(ErrorCode::kFormat, path, fmt::format("line {}", number),
                  fmt::format("label {:.0f} is given twice; remove one of its lines", found->style.label));
    if (all.size() == kMostLabelLooks)
      throw Error(ErrorCode::kFormat, path, fmt::format("line {}", number),
                  fmt::format("a transfer function has at most {} labels; describe those to draw", kMostLabelLooks));
    all.push_back(*found);
  }
  dropNumberColumn(all);
  // FreeSurfer writes 0 for each label, 3D Slicer 255 for opaque labels.
  const bool has_alpha = std::ranges::any_of(all, [](const Described& one) { return one.alpha.value_or(0) > 0; });
  TransferFunction out;
  for (Described& one : all) {
    if (has_alpha && one.alpha) one.style.opacity *= *one.alpha / 255;
    out.labels.push_back(std::move(one.style));
  }
  if (out.labels.empty()) throw Error(ErrorCode::kFormat, path, "", "describes no label; write a line for each");
  sortLabels(out.labels);
  return out;
}

void sortLabels(std::vector<LabelStyle>& labels) {
  std::sort(labels.begin(), labels.end(), [](const LabelStyle& a, const LabelStyle& b) { return a.label < b.label; });
}

void requireFitting(const TransferFunction& function, bool has_window, const Manifest& manifest) {
  const auto refuse = [](const std::string& what) { throw Error(ErrorCode::kUsage, what); };
  if (manifest.volume_class != VolumeClass::kLabels) {
    if (function.labels.empty()) return;
    refuse(
        "transfer function: it has labels, but the volume's values are amounts; convert it with --labels if they are "
        "labels");
  }
  if (function.labels.empty())
    refuse(
        "transfer function: it has points, but the volume's values are labels; give a label description of "
        "ITK-SNAP's, a function with \"labels\", or auto");
  if (has_window) refuse("window: labels are names, which no window can stretch; leave it out");
  const ValueRange& range = manifest.range;
  if (!areDistinct(range))
    refuse(fmt::format(
        "labels from {:.0f} to {:.0f}: labels beyond {:.0f} cannot be distinguished; number the labels anew", range.lo,
        range.hi, kLargestLabel));
}

bool areDistinct(const ValueRange& labels) {
  return labels.empty() || std::max(-labels.lo, labels.hi) <= kLargestLabel;
}

namespace {

LabelStyle defaultStyle(double label, const std::vector<DeclaredLook::Label>& declared) {
  const auto before = [](const DeclaredLook::Label& a, double b) { return static_cast<double>(a.label) < b; };
  const auto found = std::lower_bound(declared.begin(), declared.end(), label, before);
  if (found == declared.end() || static_cast<double>(found->label) != label)
    return {label, "", paletteColor(std::abs(label)), kPaletteOpacity};
  LabelStyle out{label, "", srgbOf(found->color), found->color.alpha / 255.0};
  out.color = linearFromSrgb(out.color);
  return out;
}

}  // namespace

TransferFunction labelPalette(const Manifest& manifest) {
  TransferFunction out;
  const auto add = [&](double label) {
    if (label != 0) out.labels.push_back(defaultStyle(label, manifest.look.labels));
  };
  if (const auto known = labelsOf(manifest)) {
    for (const LabelCount& count : *known) add(count.label);
  } else if (!manifest.range.empty()) {
    if (manifest.range.hi - manifest.range.lo >= static_cast<double>(kMostLabels))
      throw Error(
          ErrorCode::kUsage,
          fmt::format("--tf auto: has colours for labels within a range of {} (found {:.0f} to {:.0f}); list the "
                      "labels to draw in a file, as --tf labels.txt",
                      kMostLabels, manifest.range.lo, manifest.range.hi));
    for (double label = manifest.range.lo; label <= manifest.range.hi; ++label) add(label);
  }
  // A function without labels would be a function of points.
  if (out.labels.empty()) out.labels.push_back({0, "", glm::dvec3(1), 0});
  return out;
}

std::optional<std::vector<LabelCount>> labelsOf(const Manifest& manifest) {
  const std::vector<std::uint64_t>& counts = manifest.histogram.counts;
  if (!countsEachLabel(manifest.volume_class, manifest.type, manifest.range) ||
      manifest.range.hi - manifest.range.lo + 1 != static_cast<double>(counts.size()))
    return std::nullopt;
  std::vector<LabelCount> out;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) out.push_back({manifest.range.lo + static_cast<double>(i), counts[i]});
  }
  return out;
}

std::string unknownLabelsText(const std::vector<TransferFunction>& functions, const Manifest& manifest) {
  const auto known = labelsOf(manifest);
  if (!known) return {};
  std::string list;
  std::size_t unknown = 0;
  for (const LabelCount& count : *known) {
    const bool given = std::any_of(functions.begin(), functions.end(),
                                   [&](const TransferFunction& function) { return function.hasLabel(count.label); });
    if (given || count.label == 0) continue;
    if (++unknown <= 8) list += fmt::format("{}{:.0f}", list.empty() ? "" : ", ", count.label);
  }
  if (unknown == 0) return {};
  if (unknown > 8) list += fmt::format(" and {} more", unknown - 8);
  return fmt::format("label{} {} {} in the volume and not among those given: nothing is drawn there",
                     unknown == 1 ? "" : "s", list, unknown == 1 ? "is" : "are");
}

std::string likelyLabelsText(const Manifest& manifest) {
  // 8-bit measurements have more values than this, except for masks, which labels draw as well.
  constexpr std::size_t kMostLikely = 48;
  if (manifest.volume_class != VolumeClass::kUnknown || isFloating(manifest.type) || manifest.range.empty() ||
      manifest.range.lo < 0)
    return {};
  const std::vector<std::string>& files = manifest.source.files;
  const bool said = std::any_of(files.begin(), files.end(), [](const std::string& file) {
    return lowered(file).ends_with(".seg.nrrd") || lowered(file).ends_with(".seg.nhdr");
  });
  const auto& counts = manifest.histogram.counts;
  const auto different =
      static_cast<std::size_t>(std::count_if(counts.begin(), counts.end(), [](std::uint64_t n) { return n > 0; }));
  const bool each_has_bin = manifest.range.hi - manifest.range.lo < static_cast<double>(counts.size());
  if (!said && (!each_has_bin || different > kMostLikely || different < 2)) return {};
  return fmt::format(
      "its values, {}, look like labels and are drawn as amounts; --labels FILE draws labels (a store is converted "
      "with --labels), and a transfer function (--add-tf) confirms the amounts",
      said ? "of a segmentation" : fmt::format("{} whole numbers", different));
}

}  // namespace kiln

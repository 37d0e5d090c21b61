// What the labels of a label volume look like: as ITK-SNAP has it in a file, or a palette for those who say nothing.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Whole numbers up to here are exact where labels are drawn.
inline constexpr double kLargestLabel = 1 << 23;

/// How fast a label's extinction rises from nothing to all of it where its surface is. unit: per voxel of a plane face.
inline constexpr float kLabelRise = 4;

/// Whether the text begins as ITK-SNAP's label descriptions do: with comments, or a line that begins with a number.
bool isLabelDescription(const std::string& text);
/// A line a label: index, red, green, blue (0 to 255, sRGB), opacity (0 to 1), whether it is shown in slices and in the
/// mesh, "name"; # begins a comment. A label that is not shown in the mesh, or has index 0, is transparent. throws:
/// Error kFormat naming the line. source: ITK-SNAP's own files say it in their first lines.
TransferFunction labelDescription(const std::string& text, const std::filesystem::path& path);

/// A colour of its own for each label but 0. throws: Error kUsage where there are too many to choose for.
TransferFunction labelPalette(const Manifest& manifest);

struct LabelCount {
  double label = 0;
  std::uint64_t voxels = 0;
};
/// The labels that have voxels, in order; nothing where the manifest does not know them one by one (countsEachLabel).
std::optional<std::vector<LabelCount>> labelsOf(const Manifest& manifest);

/// Those of them, but for 0, that none of the functions says anything of, as a sentence; empty where there are none, or
/// nobody knows.
std::string unknownLabelsText(const std::vector<TransferFunction>& functions, const Manifest& manifest);

/// A sentence where the volume's values are drawn as amounts and look like labels: whole numbers, few of them, or a
/// file that says so (3D Slicer's .seg.nrrd). Empty where they do not.
std::string likelyLabelsText(const Manifest& manifest);

/// throws: Error kUsage where the function is of labels and the volume is not, or the other way round, where a window
/// would stretch labels, or where they are too large to be drawn.
void requireFitting(const TransferFunction& function, bool has_window, const Manifest& manifest);

/// By label, as a function has them.
void sortLabels(std::vector<LabelStyle>& labels);

}  // namespace kiln

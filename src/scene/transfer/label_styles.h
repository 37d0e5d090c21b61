// Names, colours and opacities of labels: from label files of other programs, or from the default palette.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/transfer/transfer_function.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Largest label: integers up to here are exact when labels are drawn.
inline constexpr double kLargestLabel = 1 << 23;

/// True if each label of the range is drawn as itself.
bool areDistinct(const ValueRange& labels);

/// Slope of a label's extinction at its surface, from none to all. unit: per voxel, at a plane face.
inline constexpr float kLabelRise = 4;

/// True if the text begins like a label description: with comments, or with a line that begins with a number.
bool isLabelDescription(const std::string& text);
/// Parses one label per line: index, red, green, blue (0 to 255, sRGB), opacity (0 to 1), shown in slices, shown in the
/// mesh, "name"; # begins a comment. A label that is not shown in the mesh, or has index 0, is transparent. Lines may
/// also be those of a colour table, index, name, red, green, blue, alpha (FreeSurfer, 3D Slicer), or of a list, index
/// and name, whose colours are those of the palette. If each alpha is 0, labels of a table are opaque.
/// throws: Error kFormat naming the line. source: the first lines of ITK-SNAP's own files; FreeSurferColorLUT.txt.
TransferFunction labelDescription(const std::string& text, const std::filesystem::path& path);

/// Returns the colour that the source declares for each label but 0, else a distinct one. throws: Error kUsage if there
/// are too many labels.
TransferFunction labelPalette(const Manifest& manifest);

struct LabelCount {
  double label = 0;
  std::uint64_t voxels = 0;
};
/// Returns the labels with voxels, in order; nothing if the manifest does not count labels one by one
/// (countsEachLabel).
std::optional<std::vector<LabelCount>> labelsOf(const Manifest& manifest);

/// Returns a sentence about the volume's labels, except 0, that no function styles; empty if there are none, or the
/// labels are unknown.
std::string unknownLabelsText(const std::vector<TransferFunction>& functions, const Manifest& manifest);

/// Returns a sentence if the volume's values are drawn as amounts but look like labels: few integers, or a file of a
/// segmentation (3D Slicer's .seg.nrrd). Else empty.
std::string likelyLabelsText(const Manifest& manifest);

/// throws: Error kUsage if only one of function and volume has labels, if a window would stretch labels, or if labels
/// are too large to be drawn.
void requireFitting(const TransferFunction& function, bool has_window, const Manifest& manifest);

/// Sorts by label, as functions require.
void sortLabels(std::vector<LabelStyle>& labels);

}  // namespace kiln

// Finds the volume in an HDF5 file by the conventions of the programs that write such files.
#pragma once

#include <functional>

#include "ingest/chunks/array_volume.h"
#include "ingest/hdf5/bdv_xml.h"
#include "ingest/hdf5/hdf5_objects.h"
#include "ingest/hdf5/scaled_slices.h"

namespace kiln {

/// A data set, and how its axes lie in the world.
struct Hdf5Image {
  std::string path;
  std::vector<ArrayAxis> axes;
  bool has_scale = false;
  /// The part of the data set that holds voxels; empty for all. Imaris pads data sets to whole chunks.
  AxisNumbers used_shape;
  /// Replaces the place that `axes` give.
  std::optional<glm::dmat4> world_from_index;
  PatientFrame frame = PatientFrame::kUnknown;
  /// True if whole numbers are unsigned, whatever their type. BigDataViewer writes unsigned numbers as signed.
  bool is_unsigned = false;
  /// Scales of whole numbers slice by slice, as in MINC.
  SliceScales scales;
  /// Further files that describe the image: the XML file of BigDataViewer.
  std::vector<std::filesystem::path> headers;
  /// True if the path already chose the channel, time and scale.
  bool path_chooses = false;
  /// For SourceInfo::format: ", Imaris, channel 0".
  std::string choice;
  std::vector<std::string> notes;
};

/// Returns the image in the data set at `path`, by the convention of the program that writes such paths. requires: a
/// data set of numbers. throws: Error kUnsupported, kFormat.
Hdf5Image hdf5ImageAt(const std::filesystem::path& file, const std::string& path, const Hdf5Objects& objects,
                      BdvXmlBeside& beside);

/// Describes a file, first the object at a path and all below. throws: Error kFormat, kBudget.
using DescribeHdf5 = std::function<Hdf5Objects(const std::string& path)>;

/// Chooses the data set at `path`, or without a path: BigDataViewer's, Imaris's, MINC's, NeXus's, Data Exchange's, or
/// the only one of three axes. throws: Error kUsage, listing the data sets, if there are several, or an option does not
/// apply; kUnsupported, kFormat.
Hdf5Image findHdf5Image(const std::filesystem::path& file, const std::string& path, const DescribeHdf5& describe,
                        const SourceOptions& options);

}  // namespace kiln

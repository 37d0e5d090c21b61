// Values of options that say what a picture shows, as the command line writes them.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "job/render_job.h"

namespace kiln::tool {

/// Light, clipping and background: options that a picture has beside camera and transfer function.
struct SceneArguments {
  std::optional<std::string> shading, region, world_region, background;
  std::vector<std::string> lights, planes;
  std::optional<double> ambient, diffuse, specular, power;
  /// Overrides what the options name. throws: Error kUsage naming the option.
  void apply(PictureOptions& picture) const;
};

void addSceneArguments(CLI::App& command, SceneArguments& arguments);

/// A preset or a file that exists. throws: Error kUsage naming `option` and the presets.
TransferFunctionChoice transferFunctionNamed(const std::string& text, const char* option);
/// "CENTRE,WIDTH". throws: Error kUsage naming `option`.
Window parseWindow(const std::string& text, const char* option);

/// "X0,Y0,Z0,X1,Y1,Z1" in voxels, half-open. throws: Error kUsage naming `option`, and what was `expected`.
VoxelBox parseVoxelBox(const std::string& text, const char* option, const char* expected);

/// "X,Y,W,H" in pixels. throws: Error kUsage naming `option`.
PixelRect parseCrop(const std::string& text, const char* option);

}  // namespace kiln::tool

// The job that INPUT and the options of a command describe, for commands that draw.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "foreign_store.h"
#include "job/command/given_flags.h"
#include "job/render_job.h"

namespace kiln::tool {

/// The options --add, --labels and --add-tf.
struct AddedArguments {
  std::vector<std::string> added, functions, labels;
  void addTo(CLI::App& command, OptionFacts& facts);
  /// throws: Error kUsage for a function that is none.
  AddedVolumes resolve() const;
};

/// Returns whether INPUT is a volume, and no job.
bool isVolumeName(const std::filesystem::path& input);

/// Returns the job of INPUT (a volume, a job, or a picture of Kiln's, whose job it is) with the flags applied and the
/// volumes added. throws: Error kUsage for flags that contradict the job; as readJob and jobOfPicture.
RenderJob jobOfInput(const std::string& input, const GivenFlags& flags, const AddedArguments& volumes);

/// Returns the files and folders that a job reads: transfer functions, and the volumes of all frames.
std::vector<std::filesystem::path> inputsOf(const RenderJob& job);

/// Volume files of a job: dimensions and types of the command line belong to INPUT, the folder of stores to all
/// volumes; labels are known per volume.
class InputOptions {
 public:
  /// throws: Error kUsage for --store if all volumes are stores.
  InputOptions(const ForeignArguments& source, const RenderJob& job);
  ForeignVolume of(const std::filesystem::path& volume) const {
    return {volume, names_.contains(volume) ? described_.options : SourceOptions(), described_.store_directory};
  }
  bool areLabels(const std::filesystem::path& volume) const { return labels_.contains(volume); }

 private:
  ForeignVolume described_;  // options and folder, without a name
  std::set<std::filesystem::path> names_, labels_;
};

/// Returns the store. throws: Error kUsage if labels are required and the store holds amounts.
std::filesystem::path requiredClass(const std::filesystem::path& store, bool labels);

}  // namespace kiln::tool

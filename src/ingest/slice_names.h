// Tests that the names of a folder's slices form one stack without gaps.
#pragma once

#include <string>
#include <vector>

#include "ingest/slice_directory.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// Returns without effect if the names differ in one number only, and the number grows by a constant step from name
/// to name. If the names differ in a second number, the files whose second number is `options.channel`, or
/// `options.time`, are kept, and the choice is noted in `slices.part`. All other names are kept with a sentence in
/// `slices.notes` if `options.allow_irregular` is true.
/// requires: `slices.files` in natural order. throws: Error kUsage if there are several stacks and none is chosen, or
/// the chosen stack is not there, or both options are given; kFormat naming the two slices around the first gap, or the
/// groups that the names form.
void requireOneStack(SliceFiles& slices, const SourceOptions& options);

/// Groups files whose names differ in one number only: the number that has the most values. A file of another name is a
/// group of its own.
std::vector<std::vector<std::filesystem::path>> stacksByName(const std::vector<std::filesystem::path>& files);

/// Returns the second number by which the names of `files` differ, for each stack; nothing if the names differ in fewer
/// numbers or more. requires: `stacks` are the groups of the files by stacksByName.
std::vector<std::string> numbersOfStacks(const std::vector<std::filesystem::path>& files,
                                         const std::vector<std::vector<std::filesystem::path>>& stacks);

}  // namespace kiln

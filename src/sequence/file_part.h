// Lends a file the planes of a drawn picture that the file holds, without a copy, while the file is written.
#pragma once

#include <algorithm>
#include <iterator>
#include <utility>

#include "annotate/annotator.h"
#include "image/image.h"
#include "job/job_facts.h"
#include "sequence/opened_job.h"

namespace kiln {

/// Moves the file's planes out of the image, and back on destruction.
class FilePart {
 public:
  FilePart(Image& whole, const OutputFile& file, const Aovs& aovs) : whole_(whole) {
    part_.width = whole.width;
    part_.height = whole.height;
    part_.deep = whole.deep;
    if (holdsColors(file.content)) part_.rgba.swap(whole.rgba);
    const auto others = std::stable_partition(whole.planes.begin(), whole.planes.end(),
                                              [&](const Plane& plane) { return isOf(plane, file, aovs); });
    std::move(whole.planes.begin(), others, std::back_inserter(part_.planes));
    whole.planes.erase(whole.planes.begin(), others);
  }
  ~FilePart() {
    if (!part_.rgba.empty()) part_.rgba.swap(whole_.rgba);
    std::move(part_.planes.begin(), part_.planes.end(), std::back_inserter(whole_.planes));
  }
  FilePart(const FilePart&) = delete;
  FilePart& operator=(const FilePart&) = delete;
  const Image& image() const { return part_; }

 private:
  static bool isOf(const Plane& plane, const OutputFile& file, const Aovs& aovs) {
    if (plane.name.starts_with(kAnnotationPlanes)) return holdsColors(file.content);
    return plane.name == "value" ? aovs.value : plane.name.starts_with("N.") ? aovs.normal : aovs.depth;
  }

  Image& whole_;
  Image part_;
};

}  // namespace kiln

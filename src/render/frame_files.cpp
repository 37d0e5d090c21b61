#include "render/frame_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

#include "base/hash.h"
#include "base/span.h"
#include "output/image_file.h"
#include "render/composite_parts.h"
#include "scene/frame_list.h"
#include "scene/job_names.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr const char* kHashKey = "kiln:jobHash";
constexpr const char* kDamageKey = "kiln:damagedBricks";
constexpr const char* kJobKey = "kiln:job";

bool holdsColors(Content content) { return content == Content::kPicture || content == Content::kColor; }

bool isOf(const Plane& plane, const Aovs& aovs) {
  return plane.name == "value" ? aovs.value : plane.name.starts_with("N.") ? aovs.normal : aovs.depth;
}

// The job that draws what the file holds of the frame, and nothing else.
RenderJob jobOfFile(const RenderJob& job, const OutputFile& file, const FrameScene& scene) {
  RenderJob out;
  out.volume = job.volume;
  out.volumes = job.volumes;
  for (std::size_t i = 0; i < out.volumes.size(); ++i) {
    VolumeOptions& volume = out.volumes[i];
    volume.transfer_function = scene.volumes.at(i).transfer_function;
    volume.functions.clear();
    volume.window.reset();
  }
  out.picture = scene.picture;
  out.picture.aovs = aovsOf(job, file);
  out.picture.skip_damaged = false;  // a whole picture's header does not depend on it
  out.speed = job.speed;
  return out;
}

std::string textOf(const RenderJob& of_file, const FrameScene& scene) {
  return resolvedJobText(of_file, scene.camera, scene.transfer_function);
}

ImageMetadata metadataOf(const RenderJob& job, const OutputFile& file, const DrawnFrame& drawn,
                         const StoreReader& store) {
  RenderJob of_file = jobOfFile(job, file, drawn.scene);
  ImageMetadata out;
  if (const std::uint64_t damaged = drawn.statistics.bricks_damaged) {
    of_file.picture.skip_damaged = true;
    out.text[kDamageKey] = std::to_string(damaged);
  }
  if (const auto& crop = job.picture.crop)
    out.whole = {crop->x0, crop->y0, job.picture.size.width, job.picture.size.height};
  out.world_to_camera = exrWorldToCamera(drawn.view);
  out.world_to_ndc = exrWorldToNdc(drawn.view);
  out.text[kJobKey] = textOf(of_file, drawn.scene);
  out.text["kiln:version"] = KILN_VERSION;
  if (drawsPart(of_file.picture)) out.text["kiln:volume"] = partOriginText(store.manifest());
  if (!job.output.owner.empty()) out.text["owner"] = job.output.owner;
  if (!job.output.comments.empty()) out.text["comments"] = job.output.comments;
  if (job.output.statistics_in_header) {
    RenderStatistics statistics;
    statistics.add(drawn.statistics);
    out.text["kiln:statistics"] = statisticsText(statistics);
  }
  out.text[kHashKey] = contentHash(job, file, drawn.scene, store);
  return out;
}

// Takes the file's part out of the image, and puts it back.
class FilePart {
 public:
  FilePart(Image& whole, const OutputFile& file, const Aovs& aovs) : whole_(whole) {
    part_.width = whole.width;
    part_.height = whole.height;
    if (holdsColors(file.content)) part_.rgba.swap(whole.rgba);
    const auto others = std::stable_partition(whole.planes.begin(), whole.planes.end(), [&](const Plane& plane) {
      return plane.name == kCoveragePlane ? holdsColors(file.content) : isOf(plane, aovs);
    });
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
  Image& whole_;
  Image part_;
};

OutputFile keptFrame(const VideoOptions& video) { return {keptFramesOf(video) / "######.png", Content::kColor}; }

// Names still without numbers.
std::vector<OutputFile> patternsOf(const RenderJob& job) {
  std::vector<OutputFile> out;
  if (!job.output.path.empty()) out.push_back({job.output.path, Content::kPicture});
  for (OutputFile file : job.output.files) {
    // Beside an EXR with more planes, a PNG is what can be seen of it.
    if (file.content == Content::kPicture && !isExrPath(file.path)) file.content = Content::kColor;
    out.push_back(file);
  }
  const auto colored = [](const OutputFile& file) { return holdsColors(file.content); };
  if (!job.output.video.path.empty() && std::none_of(out.begin(), out.end(), colored))
    out.push_back(keptFrame(job.output.video));
  return out;
}

// Where two texts of a job first differ, as a line of each; the name of the volume, which says nothing, is in front.
std::string differenceOf(const std::string& found_text, const std::string& expected_text) {
  const auto behind_volume = [](const std::string& text) {
    return text.substr(std::min(text.find("\"image\""), text.size()));
  };
  const std::string found = behind_volume(found_text), expected = behind_volume(expected_text);
  const auto line_at = [](const std::string& text, std::size_t at) {
    const std::size_t begin = text.rfind('\n', at) == std::string::npos ? 0 : text.rfind('\n', at) + 1;
    std::string line = text.substr(begin, text.find('\n', at) - begin);
    line.erase(0, line.find_first_not_of(' '));
    return line.ends_with(',') ? line.substr(0, line.size() - 1) : line;
  };
  const auto [a, b] = std::mismatch(found.begin(), found.end(), expected.begin(), expected.end());
  if (a == found.end() || b == expected.end()) return "; its volume, its kind of file or Kiln's version is another";
  return fmt::format("; it has {} where this job has {}", line_at(found, static_cast<std::size_t>(a - found.begin())),
                     line_at(expected, static_cast<std::size_t>(b - expected.begin())));
}

}  // namespace

fs::path keptFramesOf(const VideoOptions& video) { return video.path.string() + ".frames"; }

std::vector<OutputFile> filesOf(const RenderJob& job, int frame) {
  std::vector<OutputFile> out = patternsOf(job);
  for (OutputFile& file : out) file.path = pathOfFrame(file.path, frame);
  return out;
}

fs::path videoFrameOf(const RenderJob& job, int frame) {
  const std::vector<OutputFile> files = filesOf(job, frame);
  return std::find_if(files.begin(), files.end(), [](const OutputFile& file) { return holdsColors(file.content); })
      ->path;
}

void requireOutputs(const RenderJob& job, std::size_t frames) {
  std::set<fs::path> seen;
  for (const OutputFile& file : patternsOf(job)) {
    requireImagePath(file.path, aovsOf(job, file).any());
    if (frames > 1 && !hasFramePlace(file.path)) {
      const fs::path numbered = file.path.stem().string() + "_####" + file.path.extension().string();
      throw Error(ErrorCode::kUsage, file.path, "",
                  fmt::format("has no place for the numbers of {} frames; write {}", frames,
                              (file.path.parent_path() / numbered).string()));
    }
    if (!seen.insert(file.path.lexically_normal()).second)
      throw Error(ErrorCode::kUsage, file.path, "", "is named twice; each output needs a name of its own");
  }
}

std::string contentHash(const RenderJob& job, const OutputFile& file, const FrameScene& scene,
                        const StoreReader& store) {
  RenderJob of_file = jobOfFile(job, file, scene);
  of_file.volume.clear();  // a moved store is the same volume
  std::string checksums = toHex(store.manifest().index_checksum);
  for (std::size_t i = 0; i < of_file.volumes.size(); ++i) {
    of_file.volumes[i].volume.clear();
    if (i > 0) checksums.append(" ").append(toHex(scene.volumes[i].index_checksum));
  }
  const std::string kind = isExrPath(file.path) ? fmt::format("exr {} {}", job.output.exr_float ? "float" : "half",
                                                              job.output.exr_compression)
                                                : fmt::format("png {}", job.output.png_bits);
  return toHex(
      hashOf(std::string_view(fmt::format("{}\n{}\n{}\n{}\n{}", KILN_VERSION, checksums,
                                          nameIn(kContentNames, file.content), kind, textOf(of_file, scene)))));
}

void writeFrame(const RenderJob& job, int frame, DrawnFrame& drawn, const StoreReader& store) {
  const auto begin = std::chrono::steady_clock::now();
  for (const OutputFile& file : filesOf(job, frame)) {
    Span span(Activity::kWrite);
    if (span.traced()) span.note("file", file.path.filename().native());
    const FilePart part(drawn.image, file, aovsOf(job, file));
    const bool as_float = job.output.exr_float || drawsPart(job.picture);
    writeImage(part.image(), metadataOf(job, file, drawn, store),
               {as_float, job.output.png_bits, job.output.exr_compression}, file.path);
  }
  drawn.statistics.output_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

FoundFile findFile(const RenderJob& job, const OutputFile& file, const FrameScene& scene, const StoreReader& store) {
  std::map<std::string, std::string> text;
  try {
    text = readImageText(file.path);
    if (const auto hash = text.find(kHashKey);
        hash != text.end() && hash->second == contentHash(job, file, scene, store)) {
      if (text.contains(kDamageKey) && !job.picture.skip_damaged) return FoundFile::kDamaged;
      checkImage(file.path);
      return FoundFile::kWhole;
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kNotFound) return FoundFile::kMissing;
    if (error.code() == ErrorCode::kFormat || error.code() == ErrorCode::kUnsupported) return FoundFile::kDamaged;
    throw;
  }
  const auto said = text.find(kJobKey);
  const std::string why =
      said == text.end() ? "" : differenceOf(said->second, textOf(jobOfFile(job, file, scene), scene));
  throw Error(
      ErrorCode::kExists, file.path, "",
      fmt::format("is a picture of another job{}; name another output, or leave --resume out to replace it", why));
}

}  // namespace kiln

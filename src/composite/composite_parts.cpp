#include "composite/composite_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>
#include <variant>

#include "composite/part_order.h"
#include "frame/background.h"
#include "frame/part_image.h"
#include "image/display.h"
#include "image/image_memory.h"
#include "job/job_facts.h"
#include "job/json/job_json.h"
#include "job/render_job.h"
#include "job/stereo.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

using nlohmann::ordered_json;

struct Part {
  fs::path path;
  RenderJob job;
  VoxelBox box;
  ordered_json look;  // the job without the keys that differ between parts
  ordered_json volume;
  std::uint64_t damaged_bricks = 0;
  std::map<std::string, std::string> text;  // of the header
  PixelLayout layout;
};

VolumeGeometry geometryOf(const ordered_json& volume) {
  VolumeGeometry out;
  const auto dims = volume.at("dims").get<std::array<std::int64_t, 3>>();
  out.dims = {dims[0], dims[1], dims[2]};
  out.world_from_index = glm::make_mat4(volume.at("worldFromIndex").get<std::array<double, 16>>().data());
  return out;
}

Part partFrom(const fs::path& path, std::uint64_t memory_bytes) {
  std::map<std::string, std::string> text = readImageText(path, memory_bytes);
  const auto of = [&](const char* name) -> const std::string& {
    const auto found = text.find(name);
    if (found != text.end()) return found->second;
    throw Error(ErrorCode::kUnsupported, path, name,
                "is not in the header; expected an image that kiln render --part drew");
  };
  Part out{path, {}, {}, {}, {}, 0, {}, {}};
  try {
    out.look = ordered_json::parse(of(ImageMetadata::kJob));
    out.volume = ordered_json::parse(of("kiln:volume"));
    geometryOf(out.volume);
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorCode::kFormat, path, ImageMetadata::kJob + std::string(" or kiln:volume"),
                readableJsonError(error.what()) + "; draw the part again");
  }
  out.layout = readPixelLayout(path);
  if (out.layout.deep)
    throw Error(ErrorCode::kUnsupported, path, "",
                "compositing would flatten its deep samples; draw the parts without --deep, or merge deep parts with "
                "oiiotool --deepmerge");
  // Without a folder, relative names stay relative.
  out.job = parseJob(of(ImageMetadata::kJob), {});
  if (!out.job.picture.clipping.part)
    throw Error(ErrorCode::kUnsupported, path, ImageMetadata::kJob,
                "names no part; expected an image that kiln render --part drew");
  if (!std::holds_alternative<TransferFunction>(out.job.picture.transfer_function))
    throw Error(ErrorCode::kFormat, path, ImageMetadata::kJob,
                "names a transfer function instead of its points; draw the part again");
  out.box = intersection(*out.job.picture.clipping.part, boxOf(geometryOf(out.volume).dims));
  // Only the header of a part with a damaged brick has "skipDamaged".
  for (const char* key : {"part", "volume", "skipDamaged"}) out.look.erase(key);
  if (const auto damaged = text.find(ImageMetadata::kDamagedBricks); damaged != text.end())
    std::from_chars(damaged->second.data(), damaged->second.data() + damaged->second.size(), out.damaged_bricks);
  out.text = std::move(text);
  return out;
}

// Other programs may have moved a part, cut it, or left out its alpha, and keep its header.
void requireSamples(const Part& part, const PixelRect& samples) {
  const PixelLayout& found = part.layout;
  for (const char* const name : {"R", "G", "B", "A"}) {
    if (std::ranges::find(found.channels, name, &std::pair<std::string, std::string>::first) == found.channels.end())
      throw Error(ErrorCode::kFormat, part.path, fmt::format("channel {}", name), "is missing; draw the part again");
  }
  if (found.width != samples.width() || found.height != samples.height() || found.x != samples.x0 ||
      found.y != samples.y0)
    throw Error(ErrorCode::kFormat, part.path, "dataWindow",
                fmt::format("{} x {} samples from ({}, {}) on, expected {} x {} from ({}, {}) on; draw the part again",
                            found.width, found.height, found.x, found.y, samples.width(), samples.height(), samples.x0,
                            samples.y0));
}

void requireSameScene(const Part& first, const Part& other) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::kUsage, other.path, what, fmt::format("is another than in {}", first.path.string()));
  };
  if (first.volume != other.volume) refuse("volume");
  for (const auto& [key, value] : first.look.items()) {
    if (!other.look.contains(key) || other.look[key] != value) refuse(key);
  }
  if (first.look.size() != other.look.size()) refuse("job");
}

// Sorts the parts front to back.
std::vector<Part> inOrder(std::vector<Part> parts, const View& view, const VolumeGeometry& volume) {
  std::vector<VoxelBox> boxes;
  for (const Part& part : parts) boxes.push_back(part.box);
  const std::vector<int> order = requiredOrder(boxes, view, volume, parts.front().path);
  std::vector<Part> out;
  for (const int place : order) out.push_back(std::move(parts[static_cast<std::size_t>(place)]));
  return out;
}

void requireDisjoint(const std::vector<Part>& parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (intersection(parts[i].box, parts[j].box).empty()) continue;
      throw Error(ErrorCode::kUsage, parts[i].path, "part",
                  fmt::format("has voxels that {} has, too; each voxel belongs to one part", parts[j].path.string()));
    }
  }
}

// Returns the text of that name of all parts, each wording once; empty where no part has one.
std::string joinedText(const std::vector<Part>& parts, const char* name) {
  std::vector<std::string> wordings;
  for (const Part& part : parts) {
    const auto text = part.text.find(name);
    if (text == part.text.end() || std::ranges::find(wordings, text->second) != wordings.end()) continue;
    wordings.push_back(text->second);
  }
  return fmt::format("{}", fmt::join(wordings, "; "));
}

ImageMetadata metadataOf(const std::vector<Part>& parts, const Camera& camera, const View& view) {
  RenderJob job = parts.front().job;
  std::uint64_t damaged_bricks = 0;
  for (const Part& part : parts) damaged_bricks += part.damaged_bricks;
  job.picture.clipping.part.reset();
  job.picture.skip_damaged = damaged_bricks > 0;
  ImageMetadata out;
  for (const char* const name : {ImageMetadata::kOwner, ImageMetadata::kComments}) {
    if (const std::string text = joinedText(parts, name); !text.empty()) out.text[name] = text;
  }
  if (damaged_bricks > 0) out.text[ImageMetadata::kDamagedBricks] = std::to_string(damaged_bricks);
  if (const auto& crop = job.picture.crop) out.whole = {crop->x0, crop->y0, view.size.width, view.size.height};
  out.world_to_camera = exrWorldToCamera(view);
  out.world_to_ndc = exrWorldToNdc(view);
  out.text[ImageMetadata::kJob] =
      resolvedJobText(job, camera, std::get<TransferFunction>(job.picture.transfer_function));
  out.text["kiln:version"] = KILN_VERSION;
  return out;
}

// Returns the folder of the command that drew a part; empty if the part's names are absolute.
fs::path drawnFrom(const Part& part) {
  if (!namesRelatively(part.job)) return {};
  const auto folder = part.text.find(ImageMetadata::kFolder);
  return "." / part.path.parent_path() / (folder == part.text.end() ? "" : folder->second);
}

}  // namespace

std::string partOriginText(const Manifest& volume) {
  const VolumeGeometry& geometry = volume.geometry();
  std::array<double, 16> matrix;
  std::copy_n(glm::value_ptr(geometry.world_from_index), matrix.size(), matrix.begin());
  const ordered_json out = {{"dims", {geometry.dims.x, geometry.dims.y, geometry.dims.z}},
                            {"worldFromIndex", matrix},
                            {"indexChecksum", toHex(volume.index_checksum)}};
  return out.dump();
}

CompositedParts compositeParts(const std::vector<fs::path>& paths, Progress& progress, std::uint64_t memory_bytes,
                               Medium medium) {
  if (paths.empty()) throw Error(ErrorCode::kUsage, "there are no partial images to composite");
  std::vector<Part> parts;
  for (const fs::path& path : paths) {
    parts.push_back(partFrom(path, memory_bytes));
    requireSameScene(parts.front(), parts.back());
  }
  requireDisjoint(parts);
  // Only light, in an EXR, has planes.
  if (medium == Medium::kDisplay) parts.front().job.picture.aovs = {};
  const PictureOptions picture = parts.front().job.picture;
  const VolumeGeometry volume = geometryOf(parts.front().volume);
  const Camera camera = picture.camera.resolve(volume, picture.size);
  const View view = resolve(camera, picture.stereo, picture.size);
  const SampleWindow window = sampleWindowOf(picture);
  const PixelRect& samples = window.samples;
  for (const Part& part : parts) requireSamples(part, samples);
  CompositedParts out;
  Image made = emptyPart(samples, picture.aovs);
  // Pixels are allocated after the last part is freed, and take no more memory than a part's samples.
  const std::uint64_t made_bytes = samples.count() * (4 + made.planes.size()) * sizeof(float);
  requireMemory(2 * made_bytes, memory_bytes, parts.front().path);
  std::vector<std::string> planes;
  for (const Plane& plane : made.planes) planes.push_back(plane.name);
  const auto opacity_threshold = static_cast<float>(picture.opacity_threshold);
  std::uint64_t done = 0;
  out.metadata = metadataOf(parts, camera, view);
  out.drawn_from = drawnFrom(parts.front());
  std::int64_t voxels = 0;
  for (const Part& part : inOrder(std::move(parts), view, volume)) {
    progress.throwIfCancelled("compositing");
    Image image = readImage(part.path, planes, memory_bytes - made_bytes);
    layBehind(image, picture.aovs, 0, 0, opacity_threshold, made);
    voxels += part.box.count();
    progress.advance("compositing", "parts", ++done, paths.size());
  }
  out.volume_share = static_cast<double>(voxels) / static_cast<double>(volume.dims.count());
  out.image = pixelsOf(made, picture, picture.aovs);
  if (medium == Medium::kDisplay) show(displayOf(picture), out.image);
  layOverBackground(out.image, drawnPixels(picture.size, picture.crop).y0, picture.size.height,
                    backgroundOf(picture, std::get<TransferFunction>(picture.transfer_function)));
  return out;
}

}  // namespace kiln

#include "sequence/frame_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <optional>
#include <span>
#include <utility>

#include "base/elapsed.h"
#include "base/file/file.h"
#include "base/file/folder.h"
#include "base/hash.h"
#include "base/thread/profile_scope.h"
#include "composite/composite_parts.h"
#include "frame/background.h"
#include "frame/part_image.h"
#include "image/file/image_file.h"
#include "job/frame/series_look.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "job/job_names.h"
#include "job/stereo.h"
#include "sequence/file_part.h"
#include "sequence/frame_annotations.h"
#include "sequence/frame_checkpoint.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

void requireKnownEnding(const fs::path& path) {
  if (pictureFormatOf(path)) return;
  throw Error(
      ErrorCode::kUsage, path, "",
      fmt::format("the ending is no picture's or video's (found '{}'); pictures end in .exr, .png, .tif or .jpg, "
                  "videos in .mp4, .mov, .mkv or .webm",
                  extensionOf(path)));
}

// A JPEG has no alpha. throws: Error kUsage for a JPEG whose background lets something through.
void requireOpaqueJpeg(const RenderJob& job, const fs::path& path) {
  if (pictureFormatOf(path) != PictureFormat::kJpeg) return;
  const std::optional<Background>& background = job.picture.background;
  const bool opaque = background ? isOpaque(*background) : !engineOf(job).capabilities().composites;
  if (!opaque)
    throw Error(ErrorCode::kUsage, path, "",
                "a JPEG has no transparency, and the background is transparent; add --background white or another "
                "colour, or write a PNG or a TIFF");
}

// Both eyes of a file lie side by side, except in an EXR.
void requireSidesOf(const RenderJob& job, const OutputFile& file) {
  const PixelRect drawn = drawnPixels(job.picture.size, job.picture.crop);
  const bool beside = drawsBothEyes(job.picture.stereo) && !file.eye && !isExrPath(file.path);
  requireSides(file.path, (beside ? 2 : 1) * drawn.width(), drawn.height());
}

// Returns what a file's bytes depend on beside its picture.
std::string kindOf(const OutputOptions& output, const fs::path& path) {
  switch (*pictureFormatOf(path)) {
    case PictureFormat::kExr:
      return fmt::format("exr {} {}", output.exr_float ? "float" : "half", output.exr_compression);
    case PictureFormat::kPng:
      return fmt::format("png {}", output.png_bits);
    case PictureFormat::kTiff:
      return "tiff";
    case PictureFormat::kJpeg:
      return fmt::format("jpeg {}", output.jpeg_quality);
  }
  return {};
}

constexpr const char* kHashKey = "kiln:jobHash";

// Returns the job that draws only the planes of one file.
RenderJob jobOfFile(const RenderJob& job, const OutputFile& file, const FrameScene& scene) {
  RenderJob out;
  out.volume = job.volume;
  out.volumes = job.volumes;
  out.companions = job.companions;
  const auto resolveColors = [&](std::size_t i, Companions& companions) {
    if (companions.color_by && i < scene.colors.size() && scene.colors[i])
      companions.color_by->transfer_function = scene.colors[i]->function;
  };
  resolveColors(0, out.companions);
  for (std::size_t i = 0; i < out.volumes.size(); ++i) {
    VolumeOptions& volume = out.volumes[i];
    resolveColors(i, volume.companions);
    volume.transfer_function = scene.volumes.at(i).transfer_function;
    volume.functions.clear();
    volume.window.reset();
    volume.clipping.section = scene.volumes.at(i).clipping.section;
  }
  out.picture = scene.picture;
  out.picture.aovs = aovsOf(job, file);
  if (!holdsColors(file.content)) out.picture.annotations = {};
  if (file.eye && out.picture.stereo) out.picture.stereo->eye = *file.eye;
  out.picture.skip_damaged = false;  // the header of a whole picture does not depend on this option
  out.speed = job.speed;
  return out;
}

std::string textOf(const RenderJob& of_file, const FrameScene& scene) {
  return resolvedJobText(of_file, scene.camera, scene.transfer_function);
}

ImageMetadata metadataOf(const RenderJob& job, const OutputFile& file, const DrawnFrame& drawn, const View& view,
                         const BrickedVolume& store) {
  RenderJob of_file = jobOfFile(job, file, drawn.scene);
  ImageMetadata out;
  if (const std::uint64_t damaged = drawn.statistics.bricks_damaged) {
    of_file.picture.skip_damaged = true;
    out.text[ImageMetadata::kDamagedBricks] = std::to_string(damaged);
  }
  if (drawsPart(of_file.picture)) {
    const auto [samples, picture] = sampleWindowOf(of_file.picture);
    out.whole = {samples.x0, samples.y0, picture.width, picture.height};
  } else if (const auto& crop = job.picture.crop) {
    out.whole = {crop->x0, crop->y0, job.picture.size.width, job.picture.size.height};
  }
  out.world_to_camera = exrWorldToCamera(view);
  out.panorama = view.projection == Projection::kEquirectangular;
  if (!out.panorama) out.world_to_ndc = exrWorldToNdc(view);
  out.text[ImageMetadata::kJob] = textOf(of_file, drawn.scene);
  std::error_code unknown;
  if (const auto folder =
          namesRelatively(of_file) ? folderSeenFrom(file.path, fs::current_path(unknown)) : std::nullopt)
    out.text[ImageMetadata::kFolder] = *folder;
  out.text["kiln:version"] = KILN_VERSION;
  if (job.series && !job.series->frames.empty()) out.text[kSeriesKey] = job.series->frames;
  if (drawsPart(of_file.picture)) out.text["kiln:volume"] = partOriginText(store.manifest());
  if (!job.output.owner.empty()) out.text[ImageMetadata::kOwner] = job.output.owner;
  if (!job.output.comments.empty()) out.text[ImageMetadata::kComments] = job.output.comments;
  if (job.output.statistics_in_header) {
    RenderStatistics statistics;
    statistics.add(drawn.statistics);
    out.text["kiln:statistics"] = statisticsText(statistics);
  }
  out.text[kHashKey] = contentHash(job, file, drawn.scene, store.manifest());
  return out;
}

// Returns the place of the first of the drawn views that the file holds.
std::size_t placeOf(const OutputFile& file, const DrawnFrame& drawn) {
  return file.eye == StereoEye::kRight && drawn.views.size() > 1 ? 1 : 0;
}

// Returns the drawn views that the file holds.
std::span<DrawnView> viewsIn(const OutputFile& file, DrawnFrame& drawn) {
  const std::span<DrawnView> all(drawn.views);
  return file.eye ? all.subspan(placeOf(file, drawn), 1) : all;
}

// Puts both views side by side, the left eye's on the left, as players of stereo pictures expect.
Image besideEachOther(const Image& left, const Image& right) {
  Image out(left.width + right.width, left.height);
  for (int y = 0; y < out.height; ++y) {
    std::copy_n(left.pixel(0, y), 4 * left.width, out.pixel(0, y));
    std::copy_n(right.pixel(0, y), 4 * right.width, out.pixel(left.width, y));
  }
  return out;
}

OutputFile keptFrame(const VideoOptions& video) { return {keptFramesOf(video) / "######.png", Content::kColor, {}}; }

// Returns whether a video can use the file. A stereo video needs both eyes in one picture; an EXR has two pictures.
bool isVideoFrame(const OutputFile& file, const RenderJob& job) {
  const bool in_two = drawsBothEyes(job.picture.stereo) && isExrPath(file.path);
  // An EXR holds light, its annotations beside, and a video is shown.
  const bool is_light =
      isExrPath(file.path) && (!showsAsDrawn(displayOf(job.picture)) || job.picture.annotations.any());
  return holdsColors(file.content) && !file.eye && !in_two && !is_light;
}

// Returns all requested files except the video, with names that have no frame number yet.
std::vector<OutputFile> askedPatternsOf(const RenderJob& job) {
  std::vector<OutputFile> out;
  if (!job.output.path.empty())
    out.push_back({job.output.path, job.output.deep ? Content::kDeep : Content::kPicture, {}});
  for (OutputFile file : job.output.files) {
    // A PNG holds the colours alone.
    if (file.content == Content::kPicture && !isExrPath(file.path)) file.content = Content::kColor;
    out.push_back(file);
  }
  return ofEyes(out, job.picture.stereo);
}

std::vector<OutputFile> patternsOf(const RenderJob& job) {
  std::vector<OutputFile> out = askedPatternsOf(job);
  if (keepsFramesForVideo(job)) out.push_back(keptFrame(job.output.video));
  return out;
}

Finish finishOf(const FrameScene& scene) { return kiln::finishOf(scene.picture, scene.transfer_function); }

int firstRowOf(const PictureOptions& picture) { return drawnPixels(picture.size, picture.crop).y0; }

// Writes one picture. An EXR is finished already. `annotator` may be null; `depth` belongs to the picture.
void writeFlat(const Image& image, const ImageMetadata& metadata, const ImageFileOptions& options,
               const FrameScene& scene, const Annotator* annotator, const float* depth, const fs::path& path) {
  if (mediumOf(path) == Medium::kLight || (finishOf(scene).none() && annotator == nullptr))
    return writeImage(image, metadata, options, path);
  ShownView shown(image, scene, annotator, depth);
  writeImage(shown.rows(), metadata, options, path);
}

// Returns both eyes side by side as a display shows them.
Image shownBeside(const Image& left, const Image& right, const DrawnFrame& drawn, const Annotators& annotators) {
  Image out = besideEachOther(left, right);
  const int first_row = firstRowOf(drawn.scene.picture);
  finishPicture(out, first_row, finishOf(drawn.scene), Medium::kDisplay);
  for (std::size_t i = 0; i < annotators.size(); ++i) {
    if (annotators[i])
      annotators[i]->over(out, static_cast<int>(i) * left.width, first_row, depthOf(drawn.views[i].image));
  }
  return out;
}

void writeFile(const RenderJob& job, const OutputFile& file, DrawnFrame& drawn, const BrickedVolume& store,
               const Annotators& annotators, std::uint64_t writer_bytes) {
  const bool deep = file.content == Content::kDeep;
  const bool as_float = job.output.exr_float || (drawsPart(job.picture) && !deep);
  const ImageFileOptions options{.exr_float = as_float,
                                 .png_bits = job.output.png_bits,
                                 .exr_compression = job.output.exr_compression,
                                 .writer_bytes = writer_bytes,
                                 .jpeg_quality = job.output.jpeg_quality};
  if (drawn.tiles) {
    TileRows rows(*drawn.tiles, file, aovsOf(job, file), finishOf(drawn.scene), annotators.front().get());
    return writeImage(rows, metadataOf(job, file, drawn, drawn.views.front().view, store), options, file.path);
  }
  std::deque<FilePart> parts;
  std::vector<ImageView> views;
  for (DrawnView& view : viewsIn(file, drawn)) {
    const Image& image = parts.emplace_back(view.image, file, aovsOf(job, file)).image();
    const auto eye = views.empty() ? StereoEye::kLeft : StereoEye::kRight;
    views.push_back(
        {std::string(nameIn(kStereoEyeNames, eye)), &image, metadataOf(job, file, drawn, view.view, store)});
  }
  const Image& first = *views.front().image;
  if (deep)
    writeDeepImage(*first.deep, views.front().metadata, options, file.path);
  else if (views.size() == 1)
    writeFlat(first, views.front().metadata, options, drawn.scene, annotators[placeOf(file, drawn)].get(),
              depthOf(viewsIn(file, drawn).front().image), file.path);
  else if (isExrPath(file.path))
    writeImageViews(views, options, file.path);
  else {
    views.front().metadata.views_beside = 2;
    writeImage(shownBeside(first, *views.back().image, drawn, annotators), views.front().metadata, options, file.path);
  }
}

// Lays the backgrounds that the frame was drawn without, and adds the planes of annotations for `files` of light.
void finishLight(DrawnFrame& drawn, const Annotators& annotators, bool files) {
  if (drawn.tiles) return;
  const int first_row = firstRowOf(drawn.scene.picture);
  for (std::size_t i = 0; i < drawn.views.size(); ++i) {
    Image& image = drawn.views[i].image;
    finishPicture(image, first_row, finishOf(drawn.scene), Medium::kLight);
    if (files && annotators[i]) annotators[i]->addPlanes(image, first_row, depthOf(image));
  }
}

// Describes the difference between the job of an existing picture and this job, as the end of a sentence.
std::string differenceOf(const std::string& there, const std::string& here) {
  const std::string difference = jobDifference(there, here);
  return difference.empty() ? "; what its volume holds, its kind of file or Kiln's version is another"
                            : ": " + difference;
}

}  // namespace

fs::path keptFramesOf(const VideoOptions& video) { return video.path.string() + ".frames"; }

bool keepsFramesForVideo(const RenderJob& job) {
  const std::vector<OutputFile> asked = askedPatternsOf(job);
  return !job.output.video.path.empty() &&
         std::none_of(asked.begin(), asked.end(), [&](const OutputFile& file) { return isVideoFrame(file, job); });
}

std::vector<OutputFile> filesOf(const RenderJob& job, int frame) {
  std::vector<OutputFile> out = patternsOf(job);
  for (OutputFile& file : out) file.path = pathOfFrame(file.path, frame);
  return out;
}

void requirePlaces(const RenderJob& job, int frame) {
  for (const OutputFile& file : filesOf(job, frame)) FileSystem::real().requirePlaceFor(file.path);
}

OutputFile videoFrameOf(const RenderJob& job, int frame) {
  const std::vector<OutputFile> files = filesOf(job, frame);
  return *std::find_if(files.begin(), files.end(), [&](const OutputFile& file) { return isVideoFrame(file, job); });
}

void requireOutputs(const RenderJob& job, const std::vector<int>& frames) {
  PictureOptions drawn = job.picture;
  drawn.aovs = drawnAovs(job);
  requireEngineOptions(drawn);
  for (const OutputFile& file : patternsOf(job)) {
    requireKnownEnding(file.path);
    requireOpaqueJpeg(job, file.path);
    requireSidesOf(job, file);
    requireImagePath(file.path, aovsOf(job, file).any());
    if (frames.size() > 1 && !hasFramePlace(file.path)) {
      throw Error(ErrorCode::kUsage, file.path, "",
                  fmt::format("has no place for the numbers of {} frames; write {}", frames.size(),
                              withFramePlace(file.path).string()));
    }
  }
  FileNames seen;
  for (const int frame : frames) {
    for (const OutputFile& file : filesOf(job, frame)) {
      if (!seen.add(file.path))
        throw Error(ErrorCode::kUsage, file.path, "", "is named twice; each output needs a name of its own");
    }
  }
}

std::string frameText(const RenderJob& job, const OutputFile& file, const FrameScene& scene) {
  return textOf(jobOfFile(job, file, scene), scene);
}

std::string contentHash(const RenderJob& job, const OutputFile& file, const FrameScene& scene,
                        const Manifest& manifest) {
  RenderJob of_file = jobOfFile(job, file, scene);
  forEachVolume(of_file, [](const fs::path&) { return fs::path(); });  // a moved store is the same volume
  std::string checksums = toHex(manifest.index_checksum);
  for (std::size_t i = 1; i < of_file.volumes.size(); ++i)
    checksums.append(" ").append(toHex(scene.volumes[i].index_checksum));
  for (const Hash128& companion : scene.companions) checksums.append(" ").append(toHex(companion));
  // The titles of several legends.
  for (std::size_t i = 0; i < scene.shown.size() && scene.shown.size() > 1; ++i)
    checksums.append(" ").append(scene.shown[i].name);
  std::string kind = kindOf(job.output, file.path);
  if (file.content == Content::kDeep)
    kind += fmt::format(" {} {}", job.output.deep_bound.samples, job.output.deep_bound.error);
  return toHex(
      hashOf(std::string_view(fmt::format("{}\n{}\n{}\n{}\n{}", KILN_VERSION, checksums,
                                          nameIn(kContentNames, file.content), kind, textOf(of_file, scene)))));
}

void writeFrame(const RenderJob& job, int frame, DrawnFrame& drawn, const BrickedVolume& store,
                std::uint64_t writer_bytes) {
  const auto begin = std::chrono::steady_clock::now();
  const Annotators annotators = annotatorsOf(job, drawn);
  const std::vector<OutputFile> files = filesOf(job, frame);
  const bool light = std::any_of(files.begin(), files.end(),
                                 [](const OutputFile& file) { return mediumOf(file.path) == Medium::kLight; });
  // Pictures on a display need the volume's light without the background.
  for (const Medium medium : {Medium::kDisplay, Medium::kLight}) {
    if (medium == Medium::kLight) finishLight(drawn, annotators, light);
    for (const OutputFile& file : files) {
      if (mediumOf(file.path) != medium) continue;
      ProfileScope span(Activity::kWrite);
      if (span.traced()) span.note("file", file.path.filename().native());
      writeFile(job, file, drawn, store, annotators, writer_bytes);
    }
  }
  drawn.statistics.output_s = secondsSince(begin);
}

std::vector<std::byte> pngOf(const RenderJob& job, const DrawnFrame& drawn, const BrickedVolume& store,
                             const Progress& progress) {
  const DrawnView& first = drawn.views.front();
  // The ending alone enters the header: a name in the current folder.
  ImageMetadata metadata = metadataOf(job, {"picture.png", Content::kPicture, {}}, drawn, first.view, store);
  const Annotators annotators = annotatorsOf(job, drawn);
  if (drawn.views.size() > 1) {
    metadata.views_beside = 2;
    const Image both = shownBeside(first.image, drawn.views.back().image, drawn, annotators);
    RowsOfImage all(both);
    RowsUntilStopped rows(all, progress);
    return encodedPng(rows, metadata, job.output.png_bits);
  }
  ShownView shown(first.image, drawn.scene, annotators.front().get(), depthOf(first.image));
  RowsUntilStopped rows(shown.rows(), progress);
  return encodedPng(rows, metadata, job.output.png_bits);
}

FoundFile findFile(const RenderJob& job, const OutputFile& file, const FrameScene& scene, const BrickedVolume& store) {
  std::map<std::string, std::string> text;
  try {
    text = readImageText(file.path, job.speed.memory_bytes);
    if (const auto hash = text.find(kHashKey);
        hash != text.end() && hash->second == contentHash(job, file, scene, store.manifest())) {
      if (text.contains(ImageMetadata::kDamagedBricks) && !job.picture.skip_damaged) return FoundFile::kDamaged;
      checkImage(file.path, job.speed.memory_bytes);
      return FoundFile::kWhole;
    }
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kNotFound) return FoundFile::kMissing;
    if (error.code() == ErrorCode::kFormat || error.code() == ErrorCode::kUnsupported) return FoundFile::kDamaged;
    throw;
  }
  const auto said = text.find(ImageMetadata::kJob);
  const std::string why =
      said == text.end() ? "" : differenceOf(said->second, textOf(jobOfFile(job, file, scene), scene));
  throw Error(
      ErrorCode::kExists, file.path, "",
      fmt::format("is a picture of another job{}; name another output, or leave --resume out to replace it", why));
}

}  // namespace kiln

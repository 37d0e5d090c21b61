// Facts that follow from a job (its engine, frames, eyes and files), and checks of options against one another.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "engine/capabilities.h"
#include "job/render_job.h"

namespace kiln {

/// Returns the background of a picture. By default: transparent behind light; behind projected values the colour of the
/// function's low end, which no value falls below.
Background backgroundOf(const PictureOptions& picture, const TransferFunction& transfer_function);
/// Returns the display of a picture. Projected values are colours of a scale, not light: they have no tone curve.
Display displayOf(const PictureOptions& picture);
/// Returns true if the job sets more than one sample a pixel.
bool oversamples(const PictureOptions& picture);
/// Returns whether the number is 1, 2, 4 or 16.
bool samplesKnown(int samples);
/// Returns the number of sub-pixels along a pixel's edge; two samples a pixel use half of the sub-pixels. throws: Error
/// kUsage for other numbers than 1, 2, 4 and 16.
int subPixelsAlongEdge(int samples);
/// Returns the engine of a picture of one volume.
EngineChoice engineOf(const PictureOptions& picture);
/// throws: Error kUsage if the engine of the picture lacks an option (engine/capabilities.h).
void requireEngineOptions(const PictureOptions& picture);

/// Returns whether the job draws a partial image: a part of the volume without background.
bool drawsPart(const PictureOptions& picture);

/// Renames all volumes of the job, and their companions.
void forEachVolume(RenderJob& job, const std::function<std::filesystem::path(const std::filesystem::path&)>& change);
/// Returns the names of all volumes that are drawn.
std::vector<std::filesystem::path> volumesOf(const RenderJob& job);
/// Returns the names of all volumes that are drawn, and then of their companions (Companions).
std::vector<std::filesystem::path> inputVolumesOf(const RenderJob& job);
/// Returns whether a name of these is relative to the folder of the command.
bool namesRelatively(const RenderJob& job);

/// Returns whether anything changes from frame to frame.
bool moves(const RenderJob& job);
/// Returns the frames to draw: the job's list, or all frames of the animation.
std::vector<int> framesOf(const RenderJob& job);
/// Returns the projection of all frames; keyframes have the same.
Projection projectionOf(const RenderJob& job);
/// Returns the size of a picture without a stated size.
ImageSize defaultSize(const RenderJob& job);
/// Returns the engine that draws the job.
EngineChoice engineOf(const RenderJob& job);
/// Returns whether nothing shows through the background.
inline bool isOpaque(const Background& background) { return background.top[3] >= 1 && background.bottom[3] >= 1; }
/// Returns whether a file of this content holds colours.
inline bool holdsColors(Content content) { return content == Content::kPicture || content == Content::kColor; }
/// throws: Error kUsage for a partial image that could not be composited or written.
void requirePart(const RenderJob& job);
/// throws: Error kUsage for volumes, companions, cut faces or colours of channels that the engine of the job does not
/// draw.
void requireVolumes(const RenderJob& job);
/// throws: Error kUsage for a mask or colours of another volume if the engine of the job draws none.
void requireCompanions(const RenderJob& job);
/// throws: Error kUsage for cut faces that show values if the engine draws none, or if nothing is cut.
void requireSections(const RenderJob& job);
/// throws: Error kUsage for colours of channels without several projected volumes.
void requireChannels(const RenderJob& job);
/// Makes the job's single volume the first of several. requires: `volumes` is empty.
void makeFirstOfSeveral(RenderJob& job);

/// Returns whether a file of the job is deep.
bool drawsDeep(const RenderJob& job);
/// Returns a name for a kind of frame that cannot be drawn in tiles; null if tiles are possible.
const char* viewWithoutTiles(const RenderJob& job);
/// Returns whether the job draws a pair of eyes, or an eye of a pair, without the distance between both.
bool lacksInterocular(const RenderJob& job);
/// throws: Error kUsage for a deep image or a stereo pair that the scene does not allow, or that could not be written.
void requireViews(const RenderJob& job);
/// Returns whether the outline of the volume is hidden by the depth of what is drawn.
bool hidesOutline(const RenderJob& job);
/// throws: Error kUsage for annotations that the picture or its files cannot have.
void requireAnnotations(const RenderJob& job);
/// Returns the pictures of one frame: the picture itself, or the left and the right eye's.
std::vector<PictureOptions> eyesOf(const PictureOptions& picture);
/// Returns the files. A file with a place for the name of an eye is listed once per drawn eye.
std::vector<OutputFile> ofEyes(const std::vector<OutputFile>& files, const std::optional<Stereo>& stereo);

/// Returns the encodings of files alone, without files; none is deep.
OutputOptions encodingsOf(const OutputOptions& output);
/// Returns the names of a job's pictures, other files and video, as far as present.
std::vector<std::filesystem::path> namesOf(const OutputOptions& output);
/// Returns whether the name has a video's ending.
bool isVideo(const std::filesystem::path& path);
/// Sets the video or the picture, by the ending of the path.
void putOutput(const std::filesystem::path& path, OutputOptions& output);

}  // namespace kiln

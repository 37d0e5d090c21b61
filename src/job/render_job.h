// A render job: what the picture is, and, apart, how fast it appears. Nothing in the second group changes a bit of the
// picture; the one exception is the quadtree, an approximation. The JSON form and its keys are those of the command
// line.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/capabilities.h"
#include "image/deep_samples.h"
#include "job/animation.h"
#include "job/stereo.h"
#include "job/transfer_function_choice.h"
#include "scene/camera/camera.h"
#include "scene/camera/camera_spec.h"
#include "scene/camera/framing.h"
#include "scene/clip_region.h"
#include "scene/frame_rate.h"
#include "scene/render_options.h"
#include "scene/sampling.h"
#include "scene/shading.h"
#include "scene/volume_part.h"

namespace kiln {

/// The picture's content: everything that changes its pixels.
struct PictureOptions {
  ImageSize size;
  std::optional<PixelRect> crop;  // the pixels of the whole picture that are drawn; else all
  std::optional<int> samples;  // sub-pixels that a pixel is made of: 1, 2, 4 or 16; else as job/auto_samples.h has it
  Background background;
  Mode mode{};
  Aovs aovs;
  CameraSpec camera;
  Fit fit = Fit::kVisible;       // the box that a camera without an eye fits into the picture
  std::optional<Stereo> stereo;  // draw one eye of a pair, or both, of which the camera is the middle
  /// "auto" is grey from black to white over the range of values where a value is projected.
  TransferFunctionChoice transfer_function = std::string("auto");
  std::optional<Window> window;  // the transfer function's first and last points lie at its ends
  Shading shading;
  Clipping clipping;
  std::optional<PartNumber> part;  // a part of the volume by number, instead of clipping.part
  double opacity_threshold = 0.998;
  Lattice lattice{};
  Interpolation interpolation = Interpolation::kLinear;  // pixel lattice only
  double sample_distance = kSampleDistance;              // all but the voxel lattice (Sampling). unit: voxels
  std::optional<int>
      level;        // one level for the whole picture; else "auto": for each region the level with voxels of a pixel
  int coarser = 0;  // levels by which "auto" is coarser, for previews
  bool skip_damaged = false;  // draw a brick that cannot be read as nothing, instead of no picture
};

/// Returns whether the job sets more than one sample a pixel.
bool oversamples(const PictureOptions& picture);
/// Returns whether the number is 1, 2, 4 or 16.
bool samplesKnown(int samples);
/// Sub-pixels along a pixel's edge; of two samples a pixel, half of them are left out. throws: Error kUsage where
/// `samples` is none of these.
int subPixelsAlongEdge(int samples);
/// Returns the engine of a picture of one volume.
EngineChoice engineOf(const PictureOptions& picture);
/// throws: Error kUsage if the engine of the picture lacks an option (engine/capabilities.h).
void requireEngineOptions(const PictureOptions& picture);

/// Returns whether the job draws a partial image: a part of the volume without background.
bool drawsPart(const PictureOptions& picture);

inline constexpr std::int64_t kMostThreads = 4096;

/// Options of speed and memory, which change no pixel.
struct SpeedOptions {
  VisibilityOptions visibility;
  std::uint64_t memory_bytes = 2ull << 30;
  unsigned threads = 0;  // 0: all
  int tile_px = 64;      // a power of two from 64 on; 0: the frame is one tile, drawn by one thread
};

/// The content of a file: colours, in an EXR with the requested planes; colours alone; the planes of depth, normals or
/// values alone, in an EXR; or the slabs of each pixel in a deep EXR, without background.
enum class Content { kPicture, kColor, kDepth, kNormal, kValue, kDeep };

struct OutputFile {
  std::filesystem::path path;
  Content content = Content::kPicture;
  std::optional<StereoEye> eye;  // the eye of a stereo pair that the file holds; else both
};

/// Frames one after the other in a file that another program makes, which must be there.
struct VideoOptions {
  std::filesystem::path path;  // .mp4, .mov, .mkv or .webm; empty for none
  FrameRate rate;
  std::filesystem::path encoder;  // the program: ffmpeg, or what takes its arguments
};

/// Options of the files. All files of one kind are written with the same options.
struct OutputOptions {
  std::filesystem::path path;
  bool exr_float = false;               // else half; a partial image is always float
  std::string exr_compression = "zip";  // one of kExrCompressionNames
  std::string owner, comments;          // in a file's header, if not empty
  bool statistics_in_header = false;    // which then is another each time
  bool deep = false;                    // the picture at `path` is Content::kDeep
  DeepBound deep_bound;                 // bound of every deep file
  int png_bits = 8;                     // 8 or 16
  std::vector<OutputFile> files;        // more of the same frame
  VideoOptions video;
};

/// The names of a job's pictures, the rest of its files and its video, those that there are.
std::vector<std::filesystem::path> namesOf(const OutputOptions& output);
/// Returns whether the name has a video's ending.
bool isVideo(const std::filesystem::path& path);
/// Makes the path the video or the picture, whichever its name ends as.
void putOutput(const std::filesystem::path& path, OutputOptions& output);

/// One of several volumes in one picture, each where its affine has it. What they have in common is the picture's:
/// lights, planes that cut all, level, interpolation, distance of samples.
struct VolumeOptions {
  std::filesystem::path volume;
  bool labels = false;  // a foreign file's values are labels, as `kiln convert --labels` has it
  TransferFunctionChoice transfer_function = std::string("auto");
  std::vector<Key<TransferFunctionChoice>> functions;  // if there are any, instead
  std::optional<Window> window;
  std::optional<Shading> shading;  // else the picture's; its lights say nothing
  Clipping clipping;               // of this volume alone
};

struct SeriesLook;

/// Distribution of a job over ranks: whole frames or tiles of frames, whichever reads fewer bytes (kAuto); always
/// tiles; always frames; or bricks, of which each rank draws its own in every frame.
enum class Distribution { kAuto, kTiles, kFrames, kBricks };

/// `volume` and `output.path` may have a place for the frame's number (job/frame_list.h).
struct RenderJob {
  std::filesystem::path volume;
  /// All of several volumes; `volume` is then the first's. The picture's transfer function, window and region and the
  /// animation's functions then say nothing.
  std::vector<VolumeOptions> volumes;
  PictureOptions picture;
  Animation animation;
  std::vector<int> frames;  // in the order they are drawn; where it is empty, those of the animation
  SpeedOptions speed;
  Distribution distribution = Distribution::kAuto;
  bool share_reads = true;  // each brick file is read by one rank for all ranks that share tiles or frames
  OutputOptions output;
  std::filesystem::path trace;  // file of the trace of all threads; empty for none
  /// Decides camera and colours of all frames of a time series; null where each frame uses its own volumes. Not part
  /// of a job's text.
  std::shared_ptr<const SeriesLook> series;
};

/// Returns whether anything changes from frame to frame.
bool moves(const RenderJob& job);
/// The frames that the job draws: those it names, else the animation's.
std::vector<int> framesOf(const RenderJob& job);
/// Returns the engine that draws the job.
EngineChoice engineOf(const RenderJob& job);
/// throws: Error kUsage where the job draws a partial image that could not be composited, or not be written.
void requirePart(const RenderJob& job);
/// throws: Error kUsage where the job draws several volumes in a way that only one is drawn in.
void requireVolumes(const RenderJob& job);
/// Makes the job's one volume the first of several. requires: there are no others yet.
void makeFirstOfSeveral(RenderJob& job);

/// Returns whether a file of the job is deep.
bool drawsDeep(const RenderJob& job);
/// Names the kind of frame that cannot be drawn tile by tile, in words; null where tiles are possible.
const char* viewWithoutTiles(const RenderJob& job);
/// throws: Error kUsage where the job draws a deep image or a stereo pair that its scene has not, or that could not be
/// written.
void requireViews(const RenderJob& job);
/// The pictures that are drawn of one frame: the picture, or, where it is of both eyes, the left's and the right's.
std::vector<PictureOptions> eyesOf(const PictureOptions& picture);
/// The files, of those with a place for the name of an eye one of each eye that is drawn.
std::vector<OutputFile> ofEyes(const std::vector<OutputFile>& files, const std::optional<Stereo>& stereo);

/// Reads a job; paths in it are relative to the job's folder; comments are allowed. `volume` is required, an absent
/// `output` leaves an empty path. A `transferFunction` text is a preset, or a file where it has a dot or a slash.
/// throws: Error naming file, line or key, what was found and what was expected: kFormat where the text is not JSON or
/// has a key twice, kUsage for an unknown key (naming the nearest known one) or a wrong value, kUnsupported for what a
/// later version may do; readJob also kNotFound, kIo.
RenderJob parseJob(const std::string& text, const std::filesystem::path& path);
RenderJob readJob(const std::filesystem::path& path);

/// The job as JSON with every choice about the picture made: what an EXR header keeps. `camera` and `transfer_function`
/// are the resolved ones. How fast and where to are left out, so that equal pictures have equal headers; `parseJob` of
/// the text gives the same picture.
/// Of several volumes each has its resolved function.
std::string resolvedJobText(const RenderJob& job, const Camera& camera, const TransferFunction& transfer_function);

/// Which keys of two such texts differ, the first few, as "shading.ambient is 0.2 there and 0.3 here"; names of volumes
/// aside. Empty where none does, or one is no such text.
std::string jobDifference(const std::string& there, const std::string& here);

}  // namespace kiln

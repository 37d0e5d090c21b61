// A render job: the picture, and separately the speed. Options of speed change no bit of the picture; the only
// exception is the quadtree, an approximation. JSON keys have the names of command line options.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"
#include "scene/camera/camera_spec.h"
#include "scene/clipping.h"
#include "scene/frame_rate.h"
#include "scene/keyframes.h"
#include "scene/render_options.h"
#include "scene/shading.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

/// Range of Annotations::size.
inline constexpr double kLeastAnnotationSize = 0.25, kMostAnnotationSize = 4;

enum class LegendPlace { kRight, kLeft, kTopRight, kTopLeft, kBottomRight, kBottomLeft };

/// Annotations drawn over a finished picture (annotate/README.md).
struct Annotations {
  bool scale_bar = false;
  bool box = false;
  bool legend = false;
  bool axes = false;
  std::string legend_title;                 // above the legend
  std::optional<LegendPlace> legend_place;  // absent: chosen by the shape of the picture
  std::optional<double> scale_bar_length;   // unit: world; absent: a round length
  std::string text;                         // lines with placeholders (scene/annotation_text.h)
  std::optional<glm::dvec3> color;  // color of text and lines, in linear light; absent: chosen by the background
  double size = 1;                  // height of text and width of lines, relative to the picture

  bool any() const { return box || letters(); }
  /// Returns whether letters are drawn.
  bool letters() const { return scale_bar || legend || axes || !text.empty(); }
  bool operator==(const Annotations&) const = default;
};

/// Everything that changes the picture's pixels.
struct PictureOptions {
  ImageSize size;
  std::optional<PixelRect> crop;  // the pixels of the whole picture to draw; absent: all
  std::optional<int> samples;     // sub-pixels of a pixel: 1, 2, 4 or 16; absent: chosen by job/frame/auto_samples.h
  std::optional<Background> background;  // absent: chosen by backgroundOf
  Mode mode{};
  double attenuation = kAttenuation;       // strength of attenuated MIP. unit: per voxel
  std::vector<glm::dvec3> channel_colors;  // color of each projected volume, in order of the volumes, with "auto"
  Aovs aovs;
  CameraSpec camera;
  std::optional<Fit> fit;  // the box that a camera without an eye fits; absent: kRegion with an outline, else kVisible
  std::optional<Stereo> stereo;  // draw one eye of a pair, or both, of which the camera is the middle
  Lens lens;
  /// In projections, "auto" is grey from black to white over the values of projectionRange.
  TransferFunctionChoice transfer_function = std::string("auto");
  std::optional<Window> window;  // the values of the transfer function's first and last points
  Shading shading;
  Display display;  // in PNG and video
  Annotations annotations;
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

inline constexpr std::int64_t kMostThreads = 4096;

/// Options of speed and memory, which change no pixel.
struct SpeedOptions {
  VisibilityOptions visibility;
  std::uint64_t memory_bytes = 2ull << 30;
  unsigned threads = 0;         // 0: all
  int tile_px = kLeastTile_px;  // a power of two from kLeastTile_px on; 0: the frame is one tile and has one thread
};

/// The content of a file: colours, in an EXR with the requested planes; colours alone; the planes of depth, normals or
/// values alone, in an EXR; or the slabs of each pixel in a deep EXR, without background.
enum class Content { kPicture, kColor, kDepth, kNormal, kValue, kDeep };

struct OutputFile {
  std::filesystem::path path;
  Content content = Content::kPicture;
  std::optional<StereoEye> eye;  // the eye in the file; absent: both
};

/// A video file that another program makes of the frames. The program must be installed.
struct VideoOptions {
  std::filesystem::path path;  // .mp4, .mov, .mkv or .webm; empty for none
  FrameRate rate;
  std::filesystem::path encoder;  // the program: ffmpeg, or another with equal arguments
};

/// Options of files. All files of a kind are written with equal options.
struct OutputOptions {
  std::filesystem::path path;
  bool exr_float = false;               // else half; a partial image is always float
  std::string exr_compression = "zip";  // a name of kExrCompressionNames
  std::string owner, comments;          // in a file's header, if not empty
  bool statistics_in_header = false;    // makes each header different
  bool deep = false;                    // the picture at `path` is Content::kDeep
  DeepBound deep_bound;                 // bound of every deep file
  int png_bits = 8;                     // 8 or 16
  int jpeg_quality = 92;                // 1 to 100
  std::vector<OutputFile> files;        // more files of the same frame
  VideoOptions video;
};

/// The parts of a picture that change from frame to frame.
/// An empty list of keys leaves the still picture's value. All keys of a list have equally many lights of the same
/// kinds in the same order, or equally many planes; a convergence stands in all keys of eyes or in none.
struct Animation {
  CameraPath camera;
  std::vector<Key<TransferFunctionChoice>> functions;
  std::vector<Key<std::vector<Light>>> lights;
  std::vector<Key<std::vector<ClipPlane>>> clip;  // in addition to the still picture's planes
  std::vector<Key<Stereo>> stereo;                // the still picture selects the eye
  bool any() const {
    return camera.index() != 0 || !functions.empty() || !lights.empty() || !clip.empty() || !stereo.empty();
  }
  /// Returns the frames from the first key to the last; frame 1 without keys.
  std::vector<int> frames() const;
};

/// Shows a volume only where a volume of labels, at the same place, has one of these labels.
struct MaskChoice {
  std::filesystem::path volume;
  std::vector<std::int64_t> labels;
  bool operator==(const MaskChoice&) const = default;
};

/// Takes the colours of a volume from the values of another volume at the same place; opacity stays the volume's own.
struct ColorByChoice {
  std::filesystem::path volume;
  TransferFunctionChoice transfer_function = std::string("auto");
  bool operator==(const ColorByChoice&) const = default;
};

struct Companions {
  std::optional<MaskChoice> mask;
  std::optional<ColorByChoice> color_by;
  bool any() const { return mask || color_by; }
  bool operator==(const Companions&) const = default;
};

/// A volume of a picture with several volumes, placed by its own affine. Lights, planes through all volumes, level,
/// interpolation and distance of samples are the picture's.
struct VolumeOptions {
  std::filesystem::path volume;
  bool labels = false;  // the values of a foreign file are labels (`kiln convert --labels`)
  TransferFunctionChoice transfer_function = std::string("auto");
  std::vector<Key<TransferFunctionChoice>> functions;  // if there are any, instead
  std::optional<Window> window;
  std::optional<Shading> shading;  // absent: the picture's; lights in it are ignored
  Clipping clipping;               // for the volume alone
  Companions companions;
};

struct SeriesLook;
enum class Quality;

/// Distribution of a job over ranks.
/// - kAuto: tiles of frames or whole frames, whichever reads fewer bytes.
/// - kTiles, kFrames: always tiles, always frames.
/// - kBricks: each rank draws its own bricks in every frame.
enum class Distribution { kAuto, kTiles, kFrames, kBricks };

/// `volume` and `output.path` may have a place for the frame's number (job/frame_list.h).
struct RenderJob {
  std::filesystem::path volume;
  /// All of several volumes; `volume` is then the first's. The picture's transfer function, window and region and the
  /// animation's functions then say nothing.
  std::vector<VolumeOptions> volumes;
  Companions companions;  // masks and colors of `volume`, if alone
  PictureOptions picture;
  bool states_size = false;        // else the picture's size is defaultSize
  std::optional<Quality> quality;  // some options of the picture are this quality's, and follow a change of the engine
  Animation animation;
  std::vector<int> frames;  // in the order of drawing; empty: all frames of the animation
  SpeedOptions speed;
  Distribution distribution = Distribution::kAuto;
  bool share_reads = true;  // one rank reads a brick file for all ranks that share tiles or frames
  OutputOptions output;
  std::filesystem::path trace;  // file of the trace of all threads; empty for none
  /// Camera and colours of all frames of a time series; null: each frame uses its own volumes. Not part of a job's
  /// text.
  std::shared_ptr<const SeriesLook> series;
};

/// The shading of all frames, up to places and colours of lights: keys have lights of equal kinds and shadows.
Shading shadingOf(const RenderJob& job);

/// Reads a job. Paths are relative to the job's folder; comments are allowed. `volume` is required; without `output`
/// the path is empty. A `transferFunction` text with a dot or a slash is a file, otherwise a preset.
/// throws: Error naming file, line or key, found and expected value: kFormat for a text that is not JSON or has a key
/// twice; kUsage for an unknown key (naming the nearest known key) or a wrong value; kUnsupported for features of later
/// versions; readJob also kNotFound, kIo.
RenderJob parseJob(const std::string& text, const std::filesystem::path& path);
RenderJob readJob(const std::filesystem::path& path);

/// Returns the job as JSON with every choice about the picture made, as in EXR headers. `camera` and
/// `transfer_function` are the resolved values; with several volumes each volume has its resolved function. Speed and
/// outputs are left out, so that equal pictures have equal headers. `parseJob` of the text gives an equal picture.
std::string resolvedJobText(const RenderJob& job, const Camera& camera, const TransferFunction& transfer_function);

/// Returns the first few differing keys of two such texts, as "shading.ambient is 0.2 there and 0.3 here". Keys of
/// the camera come last. Ignores names of volumes. Empty without a difference, or if a text is no resolved job.
std::string jobDifference(const std::string& there, const std::string& here);

}  // namespace kiln

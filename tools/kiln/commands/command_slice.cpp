#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "annotate/edge_letters.h"
#include "annotate/font.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "commands.h"
#include "examples.h"
#include "foreign_store.h"
#include "frame/plane_slice.h"
#include "frame/slice.h"
#include "image/file/image_file.h"
#include "job/frame_list.h"
#include "job/option_kinds.h"
#include "output_files.h"
#include "say.h"
#include "scene/transfer/display_map.h"
#include "scene/transfer/label_styles.h"
#include "scene_arguments.h"
#include "sequence/sheet/slice_sheet.h"
#include "source_arguments.h"
#include "store/brick_index.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace {

struct SliceArguments {
  std::string store, output, axis = "z", window, colormap = "gray", memory = kDefaultMemory;
  int level = 0;
  std::optional<std::string> index, at, plane;
  double thickness = 0;         // world
  std::optional<double> pixel;  // world
  std::string mode = "average";
  bool sheet = false, no_letters = false;
  ForeignArguments source;
};

void warnBeside(const std::string& picture, const Window& window, const ValueRange& range, Progress& progress) {
  if (range.empty()) return;
  if (range.hi >= window.centre - 0.5 * window.width && range.lo <= window.centre + 0.5 * window.width) return;
  progress.warn(
      fmt::format("{}: the picture is of one colour: all values of the volume, {:g} to {:g}, lie beside --window",
                  picture, range.lo, range.hi));
}

// True if the picture gets letters. A program that was built without a font draws the picture without letters.
bool hasLetters(const SliceArguments& a, const VolumeGeometry& volume, Progress& progress) {
  if (a.no_letters || volume.frame == PatientFrame::kUnknown) return false;
  if (!hasFont()) {
    progress.warn(fmt::format("{}: no letters at the edges: this kiln was built without a font", a.output));
    return false;
  }
  try {
    font();
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}; or give --no-letters", error.what()));
  }
  return true;
}

// The colours of an EXR stay colours of voxels: its letters are planes.
void addLetters(const EdgeLetters& letters, const StoreReader& store, std::uint64_t memory_bytes,
                const std::string& output, Image& image) {
  if (!isExrPath(output)) return drawEdgeLetters(letters, image);
  constexpr std::uint64_t kPixelAndPlanes = 8 * sizeof(float);
  requireSliceFits(store, image.width, image.height, kPixelAndPlanes, memory_bytes);
  addEdgeLetterPlanes(letters, image);
}

void write(const Image& image, const StoreReader& store, std::uint64_t memory_bytes, const std::filesystem::path& path,
           Progress& progress) {
  writeImage(image, {}, ImageFileOptions().within(memory_bytes - store.index().bytes(), image), path);
  noteBlack(image, path, progress);
}

// The numbers of the slices: those of --index, else the middle one, or all of a numbered output.
std::vector<int> slicesOf(const SliceArguments& a, const NearestAxis& across, const Extent3& dims) {
  const std::int64_t count = dims[across.index];
  if (a.index) {
    const std::vector<int> out = parseFrames(*a.index, "--index");
    if (const int most = *std::max_element(out.begin(), out.end()); most >= count)
      throw Error(ErrorCode::kUsage, fmt::format("--index: {} is not between 0 and {}", most, count - 1));
    return out;
  }
  if (!hasFramePlace(a.output)) return {static_cast<int>(SliceView::middle(across, dims))};
  std::vector<int> all(static_cast<std::size_t>(count));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

void drawSlices(const SliceArguments& a, const StoreReader& store, SliceRequest request, Context& context) {
  request.level = a.level;
  store.requireLevel(a.level);
  const VolumeGeometry& level = store.level(a.level).geometry;
  request.axis = sliceAxis(level, a.axis);
  const SliceView view = sliceViewAcross(level, request.axis);
  const std::vector<int> slices = slicesOf(a, view.across, level.dims);
  if (slices.size() > 1 && !hasFramePlace(a.output))
    throw Error(ErrorCode::kUsage,
                fmt::format("-o: {} slices need a name with a place for their number (found {}); write {}",
                            slices.size(), a.output, withFramePlace(a.output).string()));
  const bool letters = hasLetters(a, level, context.progress);
  const std::string plane = *view.plane == 0 ? "" : fmt::format(", {}", view.plane);
  for (const int slice : slices) {
    request.index = slice;
    const std::filesystem::path path = pathOfFrame(a.output, slice);
    Image image = renderSlice(store, request, context.progress);
    if (letters) addLetters(view.letters, store, request.memory_bytes, a.output, image);
    write(image, store, request.memory_bytes, path, context.progress);
    context.progress.clear();
    say("{}: {} x {} pixels{}\n", path.string(), image.width, image.height, plane);
  }
}

// "NX,NY,NZ,OFFSET".
void setPlane(const std::string& text, PlaneSliceRequest& request) {
  const nlohmann::json numbers = numbersOfText(text);
  if (numbers.size() != 4)
    throw Error(ErrorCode::kUsage,
                fmt::format("--plane: expected four finite numbers NX,NY,NZ,OFFSET (found '{}')", text));
  for (int axis = 0; axis < 3; ++axis) request.normal[axis] = numbers[static_cast<std::size_t>(axis)].get<double>();
  request.offset = numbers[3].get<double>();
}

void drawPlane(const SliceArguments& a, const StoreReader& store, const SliceRequest& slice, Context& context) {
  PlaneSliceRequest request;
  request.window = slice.window;
  request.colormap = slice.colormap;
  request.labels = slice.labels;
  request.memory_bytes = slice.memory_bytes;
  request.level = a.level;
  request.thickness = a.thickness;
  request.pixel = a.pixel;
  request.statistic = a.mode;
  setPlane(*a.plane, request);
  store.requireLevel(a.level);
  const VolumeGeometry& level = store.level(a.level).geometry;
  const PlanePixels pixels = pixelsOfPlane(level, request);
  Image image = renderPlaneSlice(store, request, context.progress);
  if (hasLetters(a, level, context.progress))
    addLetters(edgeLetters(pixels.right, pixels.down, level.frame), store, request.memory_bytes, a.output, image);
  write(image, store, request.memory_bytes, a.output, context.progress);
  context.progress.clear();
  const glm::dvec3 middle =
      pixels.at(0.5 * static_cast<double>(pixels.width - 1), 0.5 * static_cast<double>(pixels.height - 1));
  say("{}: {} x {} pixels of {:.6g}{}, {} across the slice, around {:.6g},{:.6g},{:.6g}\n", a.output, image.width,
      image.height, pixels.edge, level.unit.empty() ? "" : " " + level.unit,
      isExactAcross(store, request) ? "all values"
      : pixels.samples == 1         ? "1 sample"
                                    : fmt::format("{} samples", pixels.samples),
      middle.x, middle.y, middle.z);
}

void drawSheet(const SliceArguments& a, const StoreReader& store, const SliceRequest& slice, Context& context) {
  SliceSheetRequest request{std::nullopt,   slice.window,
                            slice.colormap, hasLetters(a, store.manifest().geometry(), context.progress),
                            slice.labels,   slice.memory_bytes};
  if (a.at) {
    const glm::dvec3 at = tripleOfText(*a.at, "--at");
    request.at = VoxelCoord{std::llround(at.x), std::llround(at.y), std::llround(at.z)};
  }
  const SliceSheet sheet = renderSliceSheet(store, request, context.progress);
  write(sheet.image, store, request.memory_bytes, a.output, context.progress);
  context.progress.clear();
  say("{}: {} x {} pixels, slices of level {} through voxel {},{},{} with the value {:.9g}\n", a.output,
      sheet.image.width, sheet.image.height, sheet.level, sheet.at.x, sheet.at.y, sheet.at.z, sheet.value);
}

// Labels have the colours of a picture, unless a window or a map is given, or they are too many for a palette.
bool hasColorsOfLabels(const SliceArguments& a, const Manifest& manifest) {
  const bool asked_for_values = !a.window.empty() || a.colormap != SliceArguments().colormap;
  if (manifest.volume_class != VolumeClass::kLabels || asked_for_values) return false;
  return labelsOf(manifest) || manifest.range.hi - manifest.range.lo < static_cast<double>(kMostLabels);
}

void run(const SliceArguments& a, Context& context) {
  requireImagePath(a.output);
  FileSystem::real().requirePlaceFor(a.output);
  OutputFiles outputs;
  outputs.add(a.output);
  a.source.requireNoneForStore(a.store);
  if (a.at && !a.sheet) throw Error(ErrorCode::kUsage, "--at: is a point of a sheet; add --sheet, or give --index");
  SliceRequest request;
  request.memory_bytes = parseBytes(a.memory, "--memory");
  request.colormap = a.colormap;
  if (!a.window.empty()) request.window = parseWindow(a.window, "--window");
  const StoreReader store(storeOfInput(a.source.volume(a.store), request.memory_bytes, outputs, context),
                          request.memory_bytes);
  if (hasColorsOfLabels(a, store.manifest())) request.labels = labelPalette(store.manifest()).labels;
  if (a.sheet)
    drawSheet(a, store, request, context);
  else if (a.plane)
    drawPlane(a, store, request, context);
  else
    drawSlices(a, store, request, context);
  if (request.window) warnBeside(a.output, *request.window, store.manifest().range, context.progress);
}

}  // namespace

void addSlice(CLI::App& app, Context& context) {
  auto a = std::make_shared<SliceArguments>();
  CLI::App* command = app.add_subcommand("slice", "Draw slices, the first look after converting.");
  command->add_option("STORE", a->store, "The store, or a volume file (converted to a store beside it first).")
      ->required();
  command
      ->add_option("-o,--output", a->output,
                   "The picture, .png, .exr, .tif or .jpg; a run of # becomes the slice's number.")
      ->required();
  CLI::Option* const axis =
      command
          ->add_option("--axis", a->axis,
                       "The axis across the slices: x, y or z; or axial, coronal or sagittal, the nearest to the "
                       "patient's.")
          ->capture_default_str();
  context.facts.offer(axis, {"x", "y", "z", "axial", "coronal", "sagittal"});
  CLI::Option* const level =
      addNumber(*command, "--level", a->level, "Level of resolution, 0 for the finest.")->capture_default_str();
  CLI::Option* const index =
      command
          ->add_option("--index", a->index,
                       "The slice, in voxels of the level: 7, 0-100, 0-100x10 or 3,20; the middle one if not given, or "
                       "all if the name has a place for a number.")
          ->type_name("SLICES");
  command
      ->add_flag("--sheet", a->sheet, "Draw three slices through a voxel, the histogram and the voxel's value instead.")
      ->excludes(axis)
      ->excludes(level)
      ->excludes(index);
  command->add_option("--at", a->at, "The voxel of a sheet; the middle if not given.")->type_name("X,Y,Z");
  CLI::Option* const plane =
      command
          ->add_option("--plane", a->plane,
                       "Any plane: where NX x + NY y + NZ z + OFFSET = 0 in the world, seen along its normal.")
          ->type_name("NX,NY,NZ,OFFSET")
          ->excludes(axis)
          ->excludes(index)
          ->excludes("--sheet");
  addNumber(*command, "--thickness", a->thickness,
            "Thickness of the slice around --plane, in the volume's unit of length.")
      ->type_name("LENGTH")
      ->needs(plane)
      ->capture_default_str();
  addNumber(*command, "--pixel", a->pixel,
            "Edge of a pixel of --plane, in the volume's unit of length; the shortest edge of a voxel if not given.")
      ->type_name("LENGTH")
      ->needs(plane);
  CLI::Option* const mode =
      command->add_option("--mode", a->mode, "The value of a pixel of a thick slice: average, mip or minip.")
          ->type_name("MODE")
          ->needs(plane)
          ->capture_default_str();
  context.facts.offer(mode, {"average", "mip", "minip"});
  command->add_option("--window", a->window, "Values shown: the middle 99 % if not given.")->type_name("CENTRE,WIDTH");
  CLI::Option* const colormap =
      command
          ->add_option("--colormap", a->colormap,
                       fmt::format("Colours: {}. Labels have their own without a window and with gray.",
                                   fmt::join(displayMapNames(), ", ")))
          ->type_name("NAME")
          ->capture_default_str();
  context.facts.offer(colormap, displayMapNames());
  command->add_flag("--no-letters", a->no_letters, "Leave out the letters of the patient's sides at the edges.");
  addMemory(*command, a->memory, "the picture, a brick and the index")->capture_default_str();
  addForeignArguments(*command, context.facts, a->source);
  addExamples(*command, {"kiln slice head.kiln -o sheet.png --sheet",
                         "kiln slice head.kiln -o slice_###.png --axis z --index 0-63x16",
                         "kiln slice head.kiln -o oblique.png --plane 0,1,1,-1730 --thickness 10 --mode mip"});
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool

#include "view/view_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/file/file.h"
#include "base/shell_text.h"
#include "base/text.h"
#include "frame/slice.h"
#include "image/file/image_file.h"
#include "image/image_rows.h"
#include "job/command/job_command.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "job/job_names.h"
#include "job/job_options.h"
#include "job/stated_job.h"
#include "job/stereo.h"
#include "job/transfer_function_choice.h"
#include "scene/transfer/label_styles.h"
#include "scene/transfer/presets.h"
#include "sequence/dry_run.h"
#include "sequence/frame_files.h"
#include "sequence/sequence_frames.h"
#include "store/codec/brick_block.h"
#include "store/manifest/json_text.h"
#include "view/request_body.h"
#include "view/view_job.h"
#include "view/volume_facts.h"

namespace kiln {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
namespace fs = std::filesystem;

// Time between two reports of progress, and between two looks whether the client still reads. unit: seconds.
constexpr double kReportEvery = 0.1, kLookEvery = 0.01;
// A picture that takes no longer is drawn at once, without previews. unit: seconds.
constexpr double kAtOnce = 0.06;
// A frame that arrives so soon after a newer one, on another connection, was overtaken. unit: seconds.
constexpr double kOvertaken = 0.1;
// A picture of a render that frames have interrupted for so long goes before frames. unit: seconds.
constexpr double kPatience = 2;
// A slice that waits for an exact picture goes before the picture. unit: seconds.
constexpr double kSlicePatience = 0.2;

// Height of the smallest picture for which a session has memory. unit: pixels.
constexpr int kLeastSide = 256;

double nowSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void sendJson(ViewClient& client, const ordered_json& value) {
  const std::string text = jsonText(value, -1);
  client.document("application/json", bytesOf(text));
}

void sendRecord(ViewClient& client, const ordered_json& value, std::span<const std::byte> payload = {}) {
  client.record(jsonText(value, -1), payload);
}

ordered_json cameraJson(const Camera& camera) {
  ordered_json out = {{"projection", nameIn(kProjectionNames, camera.projection)},
                      {"eye", vectorJson(camera.eye)},
                      {"target", vectorJson(camera.target)},
                      {"up", vectorJson(camera.up)}};
  if (camera.projection == Projection::kPerspective) out["fov"] = camera.fov_deg;
  if (camera.projection == Projection::kOrthographic) out["height"] = camera.height;
  return out;
}

// Camera and functions of a scene, with every choice made.
ordered_json resolvedScene(const FrameScene& scene) {
  ordered_json functions = ordered_json::array();
  for (const VolumeScene& volume : scene.volumes) functions.push_back(statedJson(volume.transfer_function));
  if (scene.volumes.empty()) functions.push_back(statedJson(TransferFunctionChoice(scene.transfer_function)));
  return {{"camera", cameraJson(scene.camera)}, {"transferFunctions", functions}};
}

// Returns the name of the pictures of a job's file. throws: Error kUsage for a name that would be read as a pattern.
fs::path picturesBeside(fs::path job_file, bool several, const char* ending = ".png") {
  if (hasFramePlace(job_file) || hasEyePlace(job_file))
    throw Error(
        ErrorCode::kUsage, job_file, "",
        "#, %V and %v in a picture's name are replaced by numbers and eyes; give the job another name by --job");
  job_file.replace_extension("");
  if (several) job_file += "_####";
  return job_file += ending;
}

// The values that a look stands for.
ordered_json lookJson(const char* look) {
  RenderJob job = parseJob(json{{"kiln", kJobFormat}, {"volume", "volume"}, {"look", look}}.dump(), "look");
  const Shading& shading = job.picture.shading;
  const Display& display = job.picture.display;
  return {{"shading", resolvedJson(shadingOptions(), shading)},
          {"lights", lightList().write(shading.lights)},
          {"display", {{"exposure", display.exposure}, {"tone", nameIn(kToneNames, display.tone)}}}};
}

ordered_json pictureRecord(std::int64_t seq, const char* stage, const ViewPicture& picture) {
  const std::vector<LevelStatistics>& levels = picture.statistics.levels;
  int finest = -1, coarsest = -1;
  for (int level = 0; level < static_cast<int>(levels.size()); ++level) {
    if (levels[static_cast<std::size_t>(level)].bricks == 0) continue;
    if (finest < 0) finest = level;
    coarsest = level;
  }
  return {{"kind", "picture"},
          {"seq", seq},
          {"stage", stage},
          {"type", picture.type},
          {"width", picture.width},
          {"height", picture.height},
          {"level", {std::max(finest, 0), std::max(coarsest, 0)}},
          {"bricks", picture.statistics.bricks_read},
          {"bytesRead", picture.statistics.bricks_read_bytes},
          {"seconds", picture.seconds},
          {"asRendered", std::string_view(stage) == "final"}};
}

OpenedVolumes openedVolumes(const ViewSource& source) {
  if (source.volumes.empty()) return OpenedVolumes(source.drawn);
  std::vector<const BrickedVolume*> volumes;
  for (const std::shared_ptr<const BrickedVolume>& volume : source.volumes) volumes.push_back(volume.get());
  return OpenedVolumes(source.drawn, volumes);
}

}  // namespace

// A frame stops for a newer frame, and after the client has gone.
class ViewSession::FrameStops final : public Progress {
 public:
  FrameStops(const ViewSession& session, const DrawingTurns::Page& page, std::uint64_t number, std::int64_t seq,
             ViewClient& client)
      : session_(session), page_(page), number_(number), seq_(seq), client_(client) {}

  std::uint64_t number() const { return number_; }
  /// True once the frame has ended for good.
  bool ended() const {
    if (session_.stopped_ || page_.superseded(number_) || gone_) return true;
    // Several threads may look at once, which does no harm.
    if (const double now = nowSeconds(); now >= next_look_s_) {
      next_look_s_ = now + kLookEvery;
      gone_ = client_.gone();
    }
    return gone_;
  }
  /// True also if a stage gives way to a newer frame of another page.
  bool cancelled() const override { return ended() || (gives_way_ && session_.turns_.newerWaits(number_)); }
  void giveWay(bool gives_way) { gives_way_ = gives_way; }
  void advance(const char*, const char* unit, std::uint64_t done, std::uint64_t total) override {
    const double now = nowSeconds();
    if (now < next_report_s_) return;
    next_report_s_ = now + kReportEvery;
    sendRecord(client_, {{"kind", "progress"}, {"seq", seq_}, {"done", done}, {"total", total}, {"unit", unit}});
  }

 private:
  const ViewSession& session_;
  const DrawingTurns::Page& page_;
  const std::uint64_t number_;
  const std::int64_t seq_;
  ViewClient& client_;
  mutable std::atomic<double> next_look_s_ = 0;
  mutable std::atomic<bool> gone_ = false;
  bool gives_way_ = false;
  double next_report_s_ = nowSeconds() + kReportEvery;
};

// Other work stops after the client has gone. Frames interrupt the work until its patience ends. unit: seconds.
class ViewSession::OtherStops final : public Progress {
 public:
  OtherStops(const ViewSession& session, const ViewClient& client, double patience)
      : session_(session), client_(client), patient_until_s_(nowSeconds() + patience) {}
  bool ends() const { return session_.stopped_ || client_.gone(); }
  bool cancelled() const override { return session_.turns_.newerWaits(number()) || ends(); }
  bool isUrgent() const { return nowSeconds() > patient_until_s_; }
  /// The number for the next turn.
  std::uint64_t number() const { return number_; }
  void chooseNumber() { number_ = isUrgent() ? DrawingTurns::kUrgent : DrawingTurns::kOther; }

 private:
  const ViewSession& session_;
  const ViewClient& client_;
  const double patient_until_s_;
  std::atomic<std::uint64_t> number_ = DrawingTurns::kOther;
};

template <class Work>
auto ViewSession::inTurn(ViewClient& client, const Work& work, double patience) {
  OtherStops stops(*this, client, patience);
  for (;;) {
    stops.chooseNumber();
    const bool waits = stops.number() == DrawingTurns::kOther;
    const DrawingTurns::Turn turn(turns_, stops.number(), [&] { return stops.ends() || (waits && stops.isUrgent()); });
    if (stops.ends()) throw Error(ErrorCode::kCancelled, "nobody reads the answer");
    if (!turn.given()) continue;
    try {
      return work(stops);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kCancelled || stops.ends()) throw;
    }
  }
}

ViewSession::ViewSession(ViewSource source, Progress& progress)
    : source_(std::move(source)),
      threads_(source_.drawn.speed.threads),
      painter_(source_.drawn, openedVolumes(source_), progress) {
  RenderJob job = source_.drawn;
  job.picture.aovs = {};
  job.output = {};
  // A session whose memory holds no small picture would show nothing but errors.
  const bool panorama = projectionOf(job) == Projection::kEquirectangular;
  job.picture.size = {panorama ? 2 * kLeastSide : kLeastSide, kLeastSide};
  job.picture.crop.reset();
  painter_.makeRoom(*painter_.prepare(job, progress));
}

const ViewSession::Row* ViewSession::rowOf(std::string_view name) {
  static constexpr std::array kRows = {Row{"session", &ViewSession::sessionFacts, false},
                                       Row{"frame", &ViewSession::frame},
                                       Row{"resolve", &ViewSession::resolve},
                                       Row{"slice", &ViewSession::slice},
                                       Row{"probe", &ViewSession::probe},
                                       Row{"thumbnail", &ViewSession::thumbnail},
                                       Row{"function", &ViewSession::function},
                                       Row{"command", &ViewSession::command},
                                       Row{"estimate", &ViewSession::estimate},
                                       Row{"save", &ViewSession::save},
                                       Row{"render", &ViewSession::render}};
  const auto row = std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return r.name == name; });
  return row == kRows.end() ? nullptr : &*row;
}

ViewService::Request ViewSession::kindOf(std::string_view name) const {
  const Row* const row = rowOf(name);
  return row == nullptr ? Request::kUnknown : row->has_body ? Request::kPosts : Request::kReads;
}

void ViewSession::answer(std::string_view name, const std::string& body, ViewClient& client) {
  const Row* const row = rowOf(name);
  if (row == nullptr) throw Error(ErrorCode::kNotFound, fmt::format("there is no request '{}'", name));
  if (stopped_) throw Error(ErrorCode::kCancelled, "the session has ended");
  (this->*row->answer)(RequestBody::parse(body), client);
}

void ViewSession::stop() {
  stopped_ = true;
  turns_.wake();
}

RenderJob ViewSession::jobOf(const RequestBody& body) const {
  RenderJob out = jobOfBrowser(body.job(), body.sizeIfThere().value_or(source_.drawn.picture.size), source_.drawn);
  out.picture.aovs = {};  // a page shows and writes PNGs, which hold no planes
  out.frames = source_.named.frames;
  const bool series = isSeries(source_.named);
  if (series) out.frames = {framesOf(source_.named).front()};
  if (body.find("frame") == nullptr) return out;
  const int frame = static_cast<int>(body.integer("frame", 0, kLastFrame));
  if (series && frame != out.frames.front())
    throw Error(ErrorCode::kUsage, fmt::format("frame: a viewed time series has its first frame alone, {} (found {}); "
                                               "draw other frames with kiln render",
                                               out.frames.front(), frame));
  out.frames = {frame};
  return out;
}

RenderJob ViewSession::frameJobOf(const RequestBody& body) const {
  RenderJob out = jobOf(body);
  out.frames = {framesOf(out).front()};
  return out;
}

RenderJob ViewSession::savedJobOf(const RequestBody& body) const {
  RenderJob out = jobOfBrowser(body.job(), body.size(), source_.named);
  out.frames = source_.named.frames;
  if (isSeries(out) && !isSeries(source_.named))
    throw Error(ErrorCode::kUsage, source_.named.volume, "",
                "with frames, # in a volume's name is the place of their number; rename the volume");
  for (const fs::path& volume : inputVolumesOf(out)) {
    if (utf8Of(volume.native()) != volume.native())
      throw Error(ErrorCode::kUsage, volume, "", "has a name that is no UTF-8, which no job can hold; rename it");
  }
  return out;
}

// Refuses a job that a batch render would refuse.
void ViewSession::requireDrawable(const RenderJob& job, ViewClient& client) {
  inTurn(client, [&](OtherStops& stops) { painter_.requireDrawable(job, stops); });
}

const fs::path& ViewSession::jobFile() const {
  if (source_.job_file.empty()) throw Error(ErrorCode::kUsage, "this session has no file for its job; give --job");
  return source_.job_file;
}

std::size_t ViewSession::volumeOf(const RequestBody& body) const {
  const auto last = static_cast<std::int64_t>(painter_.volumes().all().size()) - 1;
  return static_cast<std::size_t>(body.integer("volume", 0, last, 0));
}

void ViewSession::sessionFacts(const RequestBody&, ViewClient& client) {
  const OpenedVolumes& volumes = painter_.volumes();
  ordered_json out = {
      {"version", KILN_VERSION},
      {"title", source_.title},
      {"jobFile", source_.job_file.empty() ? ordered_json() : ordered_json(source_.job_file.filename().string())},
      {"job", jobForBrowser(source_.drawn, volumes.manifests())},
      {"frame", framesOf(source_.named).front()},
      {"volumes", volumeFacts(volumes)},
      {"box", worldBox(volumes)},
      {"presets", presetNames()},
      {"looks", {{"plain", lookJson("plain")}, {"studio", lookJson("studio")}}},
      {"memory", source_.drawn.speed.memory_bytes},
      {"threads", ThreadLimit::active()},
      {"largest", kLargestViewSide}};
  for (std::size_t i = 0; i < source_.named.volumes.size(); ++i)
    out["volumes"][i]["name"] = source_.named.volumes[i].volume.filename().string();
  if (source_.named.volumes.empty()) out["volumes"][0]["name"] = source_.named.volume.filename().string();
  sendJson(client, out);
}

struct ViewSession::Page {
  explicit Page(std::string of_page) : name(std::move(of_page)) {}
  const std::string name;
  DrawingTurns::Page frames;
  std::int64_t newest_seq = 0;
  double newest_at_s = -1;
};

// Returns the page that the request names. A frame under way keeps its page, even if the session forgets it.
std::shared_ptr<ViewSession::Page> ViewSession::pageOf(const RequestBody& body) {
  constexpr std::size_t kMostPages = 64, kLongestName = 64;
  const std::string name = body.find("page") == nullptr ? "" : body.text("page");
  if (name.size() > kLongestName) RequestBody::refuse("page", fmt::format("a text of at most {} bytes", kLongestName));
  const std::lock_guard lock(frames_);
  auto found = std::find_if(pages_.begin(), pages_.end(), [&](const auto& page) { return page->name == name; });
  if (found == pages_.end()) {
    if (pages_.size() == kMostPages) pages_.erase(pages_.begin());
    pages_.push_back(std::make_shared<Page>(name));
  } else {
    std::rotate(found, found + 1, pages_.end());
  }
  return pages_.back();
}

// Two connections may change the order of a page's frames: an older frame must not end a newer frame.
bool ViewSession::stale(Page& page, std::int64_t seq) {
  const std::lock_guard lock(frames_);
  const double now = nowSeconds();
  if (seq < page.newest_seq && now < page.newest_at_s + kOvertaken) return true;
  page.newest_seq = seq;
  page.newest_at_s = now;
  return false;
}

void ViewSession::frame(const RequestBody& body, ViewClient& client) {
  constexpr std::int64_t kMostSeq = std::int64_t{1} << 53;
  const std::int64_t seq = body.integer("seq", 0, kMostSeq, 0);
  body.size();
  const RenderJob job = frameJobOf(body);
  const bool moving = body.flag("moving");
  const std::shared_ptr<Page> page = pageOf(body);
  if (stale(*page, seq)) {
    sendRecord(client, {{"kind", "cancelled"}, {"seq", seq}});
    return;
  }
  FrameStops stops(*this, page->frames, turns_.arrive(page->frames), seq, client);
  turns_.wake();
  try {
    drawStages(job, moving, seq, stops, client);
    sendRecord(client, {{"kind", "end"}, {"seq", seq}});
  } catch (const Error& error) {
    if (client.gone()) throw;
    if (error.code() == ErrorCode::kCancelled)
      sendRecord(client, {{"kind", "cancelled"}, {"seq", seq}});
    else
      sendRecord(client, {{"kind", "error"}, {"seq", seq}, {"error", error.what()}});
  }
}

void ViewSession::drawStages(const RenderJob& job, bool moving, std::int64_t seq, FrameStops& stops,
                             ViewClient& client) {
  // A stage that gives way to a frame of another page begins again afterwards. Previews are short and give no way.
  const auto in_turn = [&](bool gives_way, const auto& work) {
    for (;;) {
      const DrawingTurns::Turn turn(turns_, stops.number(), [&] { return stops.ended(); });
      if (!turn.given()) throw Error(ErrorCode::kCancelled, "a newer frame has come");
      stops.giveWay(gives_way);
      try {
        return work();
      } catch (const Error& error) {
        if (error.code() != ErrorCode::kCancelled || stops.ended()) throw;
      }
    }
  };
  const auto send = [&](const char* stage, const ViewPicture& picture) {
    if (stops.ended()) throw Error(ErrorCode::kCancelled, "a newer frame has come");
    sendRecord(client, pictureRecord(seq, stage, picture), picture.bytes);
  };
  std::unique_ptr<ViewedJob> viewed;
  bool at_once = false;
  int coarser = 0;
  const std::optional<ViewPicture> preview = in_turn(false, [&]() -> std::optional<ViewPicture> {
    viewed = painter_.prepare(job, stops);
    if (!moving) {
      coarser = painter_.coarserToReadLittle(*viewed, stops);
      at_once = coarser == 0 && painter_.exactSeconds(viewed->job.picture.size) <= kAtOnce;
    }
    if (at_once) return std::nullopt;
    return painter_.moving(*viewed, stops);
  });
  ordered_json resolved = {{"kind", "resolved"}, {"seq", seq}};
  resolved.update(resolvedScene(viewed->scene));
  sendRecord(client, resolved);
  if (preview) send("preview", *preview);
  if (moving) return;
  for (; !at_once && coarser >= 0; --coarser)
    send("refined", in_turn(true, [&] { return painter_.refined(*viewed, coarser, stops); }));
  send("final", in_turn(true, [&] { return painter_.png(*viewed, painter_.exact(*viewed, stops), stops); }));
}

void ViewSession::resolve(const RequestBody& body, ViewClient& client) {
  const RenderJob job = frameJobOf(body);
  sendJson(client,
           inTurn(client, [&](OtherStops& stops) { return resolvedScene(painter_.prepare(job, stops)->scene); }));
}

void ViewSession::slice(const RequestBody& body, ViewClient& client) {
  const std::size_t volume = volumeOf(body);
  const BrickedVolume& store = *painter_.volumes().all()[volume];
  const std::string axis = body.text("axis");
  constexpr std::string_view kAxes = "xyz";
  if (axis.size() != 1 || kAxes.find(axis) == std::string_view::npos) RequestBody::refuse("axis", "x, y or z");
  SliceRequest request;
  request.axis = static_cast<int>(kAxes.find(axis));
  const std::int64_t index = body.integer("index", 0, store.manifest().geometry().dims[request.axis] - 1);
  if (const json* const window = body.find("window")) {
    if (!window->is_array() || window->size() != 2 || !(*window)[0].is_number() || !(*window)[1].is_number())
      RequestBody::refuse("window", "[centre, width]");
    request.window = Window{(*window)[0].get<double>(), (*window)[1].get<double>()};
  }
  // The page sends the function with its edits.
  if (const json* const function = body.find("transferFunction"))
    request.labels = transferFunctionOfText(function->dump(), store.manifest(), "transferFunction").labels;
  else if (store.manifest().volume_class == VolumeClass::kLabels)
    request.labels = labelPalette(store.manifest()).labels;
  const std::optional<ImageSize> wanted = body.sizeIfThere();
  const auto fits = [&](int level) {
    const auto [width, height] = sliceSize(store.level(level).geometry, request.axis);
    return width <= kLargestViewSide && height <= kLargestViewSide &&
           (!wanted || (width < 2 * wanted->width && height < 2 * wanted->height));
  };
  const int levels = static_cast<int>(store.manifest().levels.size());
  while (request.level + 1 < levels && !fits(request.level)) ++request.level;
  const VolumeGeometry& level = store.level(request.level).geometry;
  request.index = std::min(index / store.manifest().spanOf(request.level)[request.axis], level.dims[request.axis] - 1);
  request.memory_bytes = source_.drawn.speed.memory_bytes;
  const std::vector<std::byte> png = inTurn(
      client,
      [&](OtherStops& stops) {
        const auto brick = [&](const BrickKey& key) { return painter_.brick({key, static_cast<int>(volume)}); };
        const Image image = renderSlice(store, request, brick, stops);
        RowsOfImage rows(image);
        return encodedPng(rows, {});
      },
      kSlicePatience);
  const auto [width, height] = sliceSize(level, request.axis);
  const glm::dvec3 spacing = level.spacing();
  const SliceView view = sliceViewAcross(level, request.axis);
  const double edge = std::min(spacing[view.right.index], spacing[view.down.index]);
  sendRecord(client,
             {{"kind", "slice"},
              {"axis", axis},
              {"index", index},
              {"level", request.level},
              {"type", "image/png"},
              {"width", width},
              {"height", height},
              {"voxelSize", {edge, edge}}},
             png);
  sendRecord(client, {{"kind", "end"}});
}

void ViewSession::probe(const RequestBody& body, ViewClient& client) {
  const std::size_t volume = volumeOf(body);
  const BrickedVolume& store = *painter_.volumes().all()[volume];
  const VolumeGeometry& geometry = store.manifest().geometry();
  const json* const given = body.find("voxel");
  VoxelCoord voxel;
  if (given == nullptr || !given->is_array() || given->size() != 3) RequestBody::refuse("voxel", "[x, y, z]");
  for (int axis = 0; axis < 3; ++axis) {
    const auto place = RequestBody::whole((*given)[static_cast<std::size_t>(axis)], 0, geometry.dims[axis] - 1);
    if (!place)
      RequestBody::refuse("voxel", fmt::format("[x, y, z] inside {} x {} x {} voxels", geometry.dims.x, geometry.dims.y,
                                               geometry.dims.z));
    voxel[axis] = *place;
  }
  const std::int64_t edge = store.manifest().brick_size;
  const BrickKey key{0,
                     {static_cast<std::int32_t>(voxel.x / edge), static_cast<std::int32_t>(voxel.y / edge),
                      static_cast<std::int32_t>(voxel.z / edge)}};
  double value = std::numeric_limits<double>::quiet_NaN();
  if (const auto block = inTurn(client, [&](OtherStops&) { return painter_.brick({key, static_cast<int>(volume)}); })) {
    withVoxelType(block->type, [&]<class T>(std::type_identity<T>) {
      if (block->shown.shows(voxel)) value = static_cast<double>(block->data<T>()[block->offsetOf(voxel)]);
    });
  }
  sendJson(client, {{"value", std::isfinite(value) ? ordered_json(value) : ordered_json()},
                    {"world", vectorJson(geometry.worldOf({voxel.x, voxel.y, voxel.z}))}});
}

void ViewSession::thumbnail(const RequestBody& body, ViewClient& client) {
  const std::string preset = body.text("preset");
  if (!isPreset(preset)) RequestBody::refuse("preset", presetList());
  body.size();
  RenderJob job = frameJobOf(body);
  job.picture.window.reset();
  job.animation.functions.clear();
  job.picture.transfer_function = preset;
  if (!job.volumes.empty()) {
    VolumeOptions& volume = job.volumes[volumeOf(body)];
    volume.transfer_function = preset;
    volume.functions.clear();
    volume.window.reset();
  }
  job.picture.background.reset();
  const ViewPicture picture = inTurn(client, [&](OtherStops& stops) {
    const std::unique_ptr<ViewedJob> viewed = painter_.prepare(job, stops);
    return painter_.refined(*viewed, painter_.coarserToReadLittle(*viewed, stops), stops);
  });
  client.document(picture.type, picture.bytes);
}

void ViewSession::function(const RequestBody& body, ViewClient& client) {
  const Manifest& manifest = painter_.volumes().all()[volumeOf(body)]->manifest();
  const TransferFunction read = transferFunctionOfText(body.text("text"), manifest, "the dropped file");
  sendJson(client, {{"transferFunction", statedJson(TransferFunctionChoice(read))}});
}

void ViewSession::command(const RequestBody& body, ViewClient& client) {
  const ImageSize size = body.size();
  requireDrawable(jobOf(body), client);
  RenderJob job = savedJobOf(body);
  // A PNG holds no planes.
  const bool is_png = !job.picture.aovs.any();
  if (is_png) {
    const int bits = std::exchange(job.output, {}).png_bits;
    job.output.png_bits = bits;
  }
  std::string text = "kiln render ";
  if (const auto options = optionsOf(job)) {
    text += shellText(source_.named.volume.string());
    for (const std::string& option : *options) text.append(" ").append(shellText(option));
    if (!job.frames.empty()) text += " --frames " + framesText(job.frames);
  } else {
    text += shellText(jobFile().string());
  }
  const fs::path named = source_.job_file.empty() ? fs::path(source_.title + ".json") : source_.job_file;
  const char* const ending = is_png ? ".png" : ".exr";
  text += fmt::format(" -o {}", shellText(picturesBeside(named, framesOf(job).size() > 1, ending).string()));
  sendJson(client, {{"command", text + fmt::format(" --size {}x{}", size.width, size.height)}});
}

void ViewSession::estimate(const RequestBody& body, ViewClient& client) {
  body.size();
  const RenderJob job = jobOf(body);
  const auto out = inTurn(client, [&](OtherStops& stops) -> ordered_json {
    // A render of the session keeps copies of a picture, which a batch render does not.
    const std::unique_ptr<ViewedJob> viewed = painter_.prepare(job, stops);
    const DryRun run = dryRun(job, painter_.volumes(), 0, stops);
    const double seconds = painter_.renderSeconds(*viewed);
    return {{"memory", viewed->memory.smallest()},
            {"bricks", run.bricks_in_view},
            {"bytes", run.file_bytes_in_view},
            {"seconds", std::isfinite(seconds) ? ordered_json(seconds) : ordered_json()}};
  });
  sendJson(client, out);
}

void ViewSession::save(const RequestBody& body, ViewClient& client) {
  const fs::path& file = jobFile();
  savedJobOf(body);
  const std::string text = savedJobText(body.job(), body.size(), source_.named, source_.kept_keys, file);
  requireDrawable(jobOf(body), client);
  FileSystem::real().writeAtomic(file, text);
  sendJson(client, {{"path", file.string()}, {"bytes", text.size()}});
}

// Draws all frames of the job into files beside the job's. Frames of the session come between.
void ViewSession::render(const RequestBody& body, ViewClient& client) {
  body.size();
  RenderJob job = jobOf(body);
  const std::vector<int> frames = framesOf(job);
  RenderJob to_file = job;
  to_file.output.path = picturesBeside(jobFile(), frames.size() > 1);
  requirePlaces(to_file, frames.front());
  std::uint64_t bytes = 0, done = 0;
  try {
    for (const int frame : frames) {
      job.frames = {frame};
      for (const OutputFile& file : filesOf(to_file, frame)) source_.require_free(file.path);
      inTurn(
          client,
          [&](OtherStops& stops) {
            const std::unique_ptr<ViewedJob> viewed = painter_.prepare(job, stops);
            DrawnFrame drawn = painter_.exact(*viewed, stops);
            writeFrame(to_file, frame, drawn, painter_.volumes().first(), viewed->memory.files);
          },
          kPatience);
      bytes += fs::file_size(filesOf(to_file, frame).front().path);
      sendRecord(client, {{"kind", "progress"}, {"done", ++done}, {"total", frames.size()}, {"unit", "frames"}});
    }
    sendRecord(client, {{"kind", "written"},
                        {"path", filesOf(to_file, frames.front()).front().path.string()},
                        {"frames", frames.size()},
                        {"bytes", bytes}});
  } catch (const Error& error) {
    if (client.gone()) throw;
    sendRecord(client, {{"kind", "error"}, {"error", error.what()}});
  }
}

}  // namespace kiln

#include "view/view_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <string_view>
#include <variant>

#include "base/error.h"
#include "base/file/file.h"
#include "job/job_facts.h"
#include "job/stated_job.h"
#include "job/transfer_function_choice.h"
#include "sequence/sequence_frames.h"
#include "store/manifest/json_text.h"

namespace kiln {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
namespace fs = std::filesystem;

// Keys of files, of the machine, and of parts of a render.
constexpr std::array<std::string_view, 17> kSessionsOwn = {
    "volume", "mask", "colorBy", "output",  "outputs", "video",      "exr",        "png", "jpeg",
    "frames", "part", "memory",  "threads", "trace",   "distribute", "shareReads", "aov"};
// Keys that a saved job keeps of the opened job.
constexpr std::array<std::string_view, 13> kKept = {"$schema", "output",     "outputs", "video",      "frames",
                                                    "exr",     "png",        "jpeg",    "distribute", "memory",
                                                    "threads", "shareReads", "trace"};
// Keys of files in each of several volumes.
constexpr std::array<std::string_view, 3> kFilesOfVolume = {"volume", "mask", "colorBy"};

void inObject(TransferFunctionChoice& choice, const Manifest& manifest) {
  if (const auto* const file = std::get_if<fs::path>(&choice)) choice = readTransferFunction(*file, manifest);
}

void inObjects(TransferFunctionChoice& still, std::vector<Key<TransferFunctionChoice>>& keys,
               const Manifest& manifest) {
  inObject(still, manifest);
  for (Key<TransferFunctionChoice>& key : keys) inObject(key.value, manifest);
}

void requireNoFile(const TransferFunctionChoice& choice) {
  if (std::holds_alternative<fs::path>(choice))
    throw Error(ErrorCode::kUsage,
                "transferFunction: expected a preset, points or an object (found the name of a file); send the "
                "function itself");
}

void requireNoFiles(const TransferFunctionChoice& still, const std::vector<Key<TransferFunctionChoice>>& keys) {
  requireNoFile(still);
  for (const Key<TransferFunctionChoice>& key : keys) requireNoFile(key.value);
}

void requireNoCameraFile(const json& job) {
  const auto refuse = [](const json& camera) {
    if (camera.is_object() && camera.contains("file"))
      throw Error(ErrorCode::kUsage, "job.camera.file: no file is read for a browser; send eye, target and up");
  };
  const auto camera = job.find("camera");
  if (camera == job.end() || !camera->is_object()) return;
  refuse(*camera);
  const auto keys = camera->find("keyframes");
  if (keys == camera->end() || !keys->is_array()) return;
  for (const json& key : *keys) refuse(key);
}

void requireBrowserKeys(const json& job, const RenderJob& session) {
  if (!job.is_object()) throw Error(ErrorCode::kUsage, "job: expected an object; send the job of api/session, changed");
  for (const std::string_view key : kSessionsOwn) {
    if (job.contains(key))
      throw Error(ErrorCode::kUsage, fmt::format("job.{}: is the session's own; leave it out", key));
  }
  requireNoCameraFile(job);
  const auto list = job.find("volumes");
  const std::size_t count = list != job.end() && list->is_array() ? list->size() : 0;
  if ((list != job.end() && !list->is_array()) || count != session.volumes.size())
    throw Error(ErrorCode::kUsage, fmt::format("job.volumes: expected as many entries as the session has in its list "
                                               "({}, found {}); change no number of volumes",
                                               session.volumes.size(), count));
  for (std::size_t i = 0; i < count; ++i) {
    const auto names = [&](std::string_view key) { return (*list)[i].contains(key); };
    if (!(*list)[i].is_object() || std::any_of(kFilesOfVolume.begin(), kFilesOfVolume.end(), names))
      throw Error(ErrorCode::kUsage, fmt::format("job.volumes[{}]: expected an object without the names of files; "
                                                 "the session knows them",
                                                 i));
  }
}

// Adds mask and colours of the session to the object of a volume.
void putCompanions(const Companions& companions, const std::function<std::string(const fs::path&)>& name, json& out) {
  if (const auto& mask = companions.mask) out["mask"] = {{"volume", name(mask->volume)}, {"labels", mask->labels}};
  if (const auto& colors = companions.color_by)
    out["colorBy"] = {{"volume", name(colors->volume)}, {"transferFunction", statedJson(colors->transfer_function)}};
}

// The browser's job with the names of files.
json withFiles(json job, const ImageSize& size, const RenderJob& session,
               const std::function<std::string(const fs::path&)>& name) {
  requireBrowserKeys(job, session);
  json& image = job["image"];
  if (!image.is_object() && !image.is_null())
    throw Error(ErrorCode::kUsage, "job.image: expected an object; leave it out, or send {}");
  image["width"] = size.width;
  image["height"] = size.height;
  if (session.volumes.empty()) job["volume"] = name(session.volume);
  putCompanions(session.companions, name, job);
  for (std::size_t i = 0; i < session.volumes.size(); ++i) {
    job["volumes"][i]["volume"] = name(session.volumes[i].volume);
    if (session.volumes[i].labels) job["volumes"][i]["labels"] = true;
    putCompanions(session.volumes[i].companions, name, job["volumes"][i]);
  }
  return job;
}

}  // namespace

void requireViewable(const RenderJob& job) {
  if (drawsPart(job.picture))
    throw Error(ErrorCode::kUsage, "--part: a part of a volume has no background to be seen on; leave it out");
  requireVolumes(job);
  requireViews(job);
}

ordered_json jobForBrowser(const RenderJob& session, const std::vector<const Manifest*>& manifests) {
  RenderJob job = session;
  if (job.volumes.empty()) inObjects(job.picture.transfer_function, job.animation.functions, *manifests.front());
  for (std::size_t i = 0; i < job.volumes.size(); ++i)
    inObjects(job.volumes[i].transfer_function, job.volumes[i].functions, *manifests.at(i));
  ordered_json out = statedJson(job);
  for (const std::string_view key : kSessionsOwn) out.erase(std::string(key));
  if (!out.contains("volumes")) return out;
  for (ordered_json& volume : out["volumes"]) {
    for (const std::string_view key : kFilesOfVolume) volume.erase(std::string(key));
  }
  return out;
}

RenderJob jobOfBrowser(const json& job, const ImageSize& size, const RenderJob& session) {
  // Any name serves: the session's files are put in place of the names that are read.
  const json whole = withFiles(job, size, session, [](const fs::path&) { return std::string("volume"); });
  RenderJob out = parseJob(jsonText(whole, -1), "job");
  requireNoFiles(out.picture.transfer_function, out.animation.functions);
  for (const VolumeOptions& volume : out.volumes) requireNoFiles(volume.transfer_function, volume.functions);
  out.volume = session.volume;
  out.companions = session.companions;
  for (std::size_t i = 0; i < out.volumes.size(); ++i) {
    out.volumes[i].volume = session.volumes[i].volume;
    out.volumes[i].companions = session.volumes[i].companions;
  }
  const VisibilityOptions visibility = out.speed.visibility;
  out.speed = session.speed;
  out.speed.visibility = visibility;
  out.series = session.series;
  out.output = encodingsOf(session.output);
  return out;
}

std::string keptKeys(const fs::path& job_file) {
  readJob(job_file);
  const json job = json::parse(readTextFile(job_file, fs::file_size(job_file)), nullptr, true, true);
  json out = json::object();
  for (const std::string_view key : kKept) {
    if (const auto found = job.find(std::string(key)); found != job.end()) out[std::string(key)] = *found;
  }
  const fs::path folder = fs::absolute(job_file).parent_path();
  const auto absolute = [&](json& name) {
    const auto text_of = name.get<std::string>();
    // Standard output is no file.
    if (text_of != "-" && text_of != "-.exr") name = (folder / text_of).lexically_normal().generic_string();
  };
  for (const char* const key : {"output", "trace"}) {
    if (out.contains(key)) absolute(out[key]);
  }
  if (out.contains("outputs")) {
    for (json& file : out["outputs"]) absolute(file["path"]);
  }
  return jsonText(out, -1);
}

std::string savedJobText(const json& job, const ImageSize& size, const RenderJob& session, const std::string& kept,
                         const fs::path& file) {
  jobOfBrowser(job, size, session);
  const fs::path folder = fs::absolute(file).lexically_normal().parent_path();
  const auto name = [&](const fs::path& volume) {
    const fs::path whole = fs::absolute(volume).lexically_normal();
    const fs::path inside = whole.lexically_relative(folder);
    const bool below = !inside.empty() && *inside.begin() != "..";
    return (below ? inside : whole).generic_string();
  };
  json files = withFiles(job, size, session, name);
  files.update(json::parse(kept));
  const auto rename = [&](json& path) {
    if (const fs::path whole = path.get<std::string>(); whole.is_absolute()) path = name(whole);
  };
  for (const char* const key : {"output", "trace"}) {
    if (files.contains(key)) rename(files[key]);
  }
  if (files.contains("outputs")) {
    for (json& output : files["outputs"]) rename(output["path"]);
  }
  // Keys of volume and picture come first.
  ordered_json out = {{"kiln", files.value("kiln", json(2))}};
  for (const char* const key : {"volume", "mask", "colorBy", "volumes", "image", "camera", "transferFunction"}) {
    if (files.contains(key)) out[key] = files[key];
  }
  for (const auto& [key, value] : files.items()) {
    if (!out.contains(key)) out[key] = value;
  }
  const std::string text = jsonText(out, 2) + "\n";
  // A kept key may contradict an edit.
  parseJob(text, file);
  return text;
}

}  // namespace kiln

#include "sequence/series_volumes.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "base/file/folder.h"
#include "base/file/path_status.h"
#include "base/text.h"
#include "cluster/shared_lists.h"
#include "grid/shared_world.h"
#include "image/file/image_file.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "sequence/frame_files.h"
#include "store/manifest/read_manifest.h"
#include "store/store_reader.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr const char* kDigits = "0123456789";

// The place of a frame's number in a path.
struct NumberPlace {
  fs::path folder;            // the folder whose entries differ by the number
  std::string before;         // the name's beginning, up to the number
  std::string digits_behind;  // of the name, right behind the number
};

// Compares two frames' paths: the first unequal component has the number.
std::optional<NumberPlace> numberPlace(const fs::path& pattern) {
  const fs::path one = pathOfFrame(pattern, 1), two = pathOfFrame(pattern, 2);
  NumberPlace out;
  auto a = one.begin(), b = two.begin();
  for (; a != one.end() && b != two.end() && *a == *b; ++a, ++b) out.folder /= *a;
  if (a == one.end() || b == two.end()) return std::nullopt;
  const std::string first = a->string(), second = b->string();
  const std::size_t differ = static_cast<std::size_t>(
      std::mismatch(first.begin(), first.end(), second.begin(), second.end()).first - first.begin());
  out.before = first.substr(0, differ);
  while (out.before.ends_with('0')) out.before.pop_back();
  out.digits_behind = first.substr(differ + 1, first.find_first_not_of(kDigits, differ + 1) - differ - 1);
  if (out.folder.empty()) out.folder = ".";
  return out;
}

// Returns the number at its place in a name.
std::optional<int> numberIn(const std::string& name, const NumberPlace& place) {
  if (!name.starts_with(place.before)) return std::nullopt;
  std::string_view digits = std::string_view(name).substr(place.before.size());
  digits = digits.substr(0, digits.find_first_not_of(kDigits));
  if (!digits.ends_with(place.digits_behind)) return std::nullopt;
  digits.remove_suffix(place.digits_behind.size());
  const std::optional<int> number = numberOf<int>(digits);
  return number && *number <= kLastFrame ? number : std::nullopt;
}

// The frames named in the header of a picture from an earlier run of the job; empty without such a picture.
std::vector<int> framesOfEarlierRun(const RenderJob& job) {
  for (const int frame : framesOf(job)) {
    for (const OutputFile& file : filesOf(job, frame)) {
      std::error_code ignored;
      if (!fs::exists(file.path, ignored)) continue;
      try {
        const std::map<std::string, std::string> text = readImageText(file.path);
        if (const auto found = text.find(kSeriesKey); found != text.end()) return parseFrames(found->second);
      } catch (const Error&) {
        // A damaged picture is drawn again.
      }
    }
  }
  return {};
}

// The frames on the disk, common to all patterns of the job.
std::vector<int> framesOfAll(const std::vector<fs::path>& patterns) {
  std::optional<std::vector<int>> out;
  for (const fs::path& pattern : patterns) {
    if (!hasFramePlace(pattern)) continue;
    const std::vector<int> there = framesOnDisk(pattern);
    std::vector<int> both;
    if (out) std::set_intersection(out->begin(), out->end(), there.begin(), there.end(), std::back_inserter(both));
    out = out ? both : there;
    if (out->empty()) throw Error(ErrorCode::kNotFound, pattern, "", "no frame of this time series is there");
  }
  return out.value_or(std::vector<int>());
}

// Manifests of stores, each read once.
class Manifests {
 public:
  /// throws: as readManifest.
  const Manifest& of(const fs::path& store) {
    const auto found = read_.find(store);
    return found != read_.end() ? found->second : read_.emplace(store, readManifest(store)).first->second;
  }
  /// Returns true for a store with a readable manifest. Any other store fails as its own frame.
  bool has(const fs::path& store) {
    if (!isStore(store)) return false;
    try {
      of(store);
      return true;
    } catch (const Error&) {
      return false;
    }
  }

 private:
  std::map<fs::path, Manifest> read_;
};

// All frames with readable stores, because manifests hold boxes and values; the first frame of foreign files; none
// where masks alone have frames.
std::vector<int> decidingFrames(const RenderJob& job, bool resume, Manifests& manifests) {
  const std::vector<fs::path> patterns = volumesOf(job);
  std::vector<int> there = framesOfAll(patterns);
  if (const std::vector<int> earlier = resume ? framesOfEarlierRun(job) : std::vector<int>();
      !earlier.empty() && std::includes(there.begin(), there.end(), earlier.begin(), earlier.end()))
    return earlier;
  std::vector<int> readable;
  std::copy_if(there.begin(), there.end(), std::back_inserter(readable), [&](int frame) {
    return std::all_of(patterns.begin(), patterns.end(), [&](const fs::path& pattern) {
      return !hasFramePlace(pattern) || manifests.has(pathOfFrame(pattern, frame));
    });
  });
  if (!readable.empty()) return readable;
  there.resize(std::min<std::size_t>(there.size(), 1));
  return there;
}

// The stores of the deciding frames, a list for each of the job's volumes.
std::vector<std::vector<std::string>> decidingStores(const RenderJob& job, const std::vector<int>& frames,
                                                     const StoreFor& store_for) {
  std::vector<std::vector<std::string>> out;
  for (const fs::path& pattern : volumesOf(job)) {
    std::vector<std::string>& stores = out.emplace_back();
    const auto add = [&](const fs::path& volume) {
      stores.push_back((store_for ? store_for(volume) : volume).string());
    };
    if (!hasFramePlace(pattern))
      add(pattern);
    else
      for (const int frame : frames) add(pathOfFrame(pattern, frame));
  }
  return out;
}

// Collective. The first rank's lists, on all.
void broadcastStores(Ranks& ranks, std::vector<std::vector<std::string>>& stores) {
  std::vector<char> letters;
  for (const std::vector<std::string>& of_volume : stores) {
    for (const std::string& store : of_volume) {
      letters.insert(letters.end(), store.begin(), store.end());
      letters.push_back('\0');
    }
    letters.push_back('\0');
  }
  broadcastList(ranks, letters);
  stores = {{}};
  std::string name;
  for (const char letter : letters) {
    if (letter != '\0')
      name += letter;
    else if (!name.empty())
      stores.back().push_back(std::exchange(name, {}));
    else
      stores.emplace_back();
  }
  stores.pop_back();
}

}  // namespace

std::vector<int> framesOnDisk(const fs::path& pattern) {
  if (!hasFramePlace(pattern)) return {};
  const std::optional<NumberPlace> place = numberPlace(pattern);
  if (!place) return {};
  std::set<int> out;
  if (!isThere(place->folder)) return {};
  forEachEntry(place->folder, [&](const fs::directory_entry& entry) {
    const std::optional<int> number = numberIn(entry.path().filename().string(), *place);
    if (number && isThere(pathOfFrame(pattern, *number))) out.insert(*number);
    return Walk::kGoOn;
  });
  return {out.begin(), out.end()};
}

std::set<fs::path> namesInFrames(const RenderJob& job, const fs::path& pattern) {
  std::set<fs::path> out = {pattern};
  for (const int frame : framesOf(job)) out.insert(pathOfFrame(pattern, frame));
  if (const std::vector<int> there = framesOnDisk(pattern); !there.empty())
    out.insert(pathOfFrame(pattern, there.front()));
  return out;
}

std::set<fs::path> labelVolumesOf(const RenderJob& job) {
  std::set<fs::path> out;
  const auto addMask = [&](const Companions& companions) {
    if (companions.mask) out.merge(namesInFrames(job, companions.mask->volume));
  };
  addMask(job.companions);
  for (const VolumeOptions& volume : job.volumes) {
    if (volume.labels) out.merge(namesInFrames(job, volume.volume));
    addMask(volume.companions);
  }
  return out;
}

std::shared_ptr<const SeriesLook> seriesLook(const RenderJob& job, const StoreFor& store_for, bool resume,
                                             Ranks* ranks) {
  if (!isSeries(job)) return nullptr;
  const bool shared = ranks != nullptr && !ranks->alone();
  Manifests manifests;
  std::vector<int> frames;
  std::vector<std::vector<std::string>> stores;
  if (!shared || ranks->first()) {
    frames = decidingFrames(job, resume, manifests);
    stores = decidingStores(job, frames, store_for);
  }
  if (shared) {
    broadcastList(*ranks, frames);
    broadcastStores(*ranks, stores);
  }
  std::vector<std::vector<Manifest>> volumes;
  std::vector<VolumeGeometry> first;
  for (const std::vector<std::string>& of_volume : stores) {
    std::vector<Manifest>& of_frames = volumes.emplace_back();
    for (const std::string& store : of_volume) of_frames.push_back(manifests.of(store));
    first.push_back(of_frames.front().geometry());
  }
  auto out = std::make_shared<SeriesLook>();
  const VolumeGeometry world = sharedWorld(first);
  for (std::vector<Manifest>& of_frames : volumes) {
    for (Manifest& manifest : of_frames) manifest.placeIn(world);
    out->volumes.push_back(unionOf(of_frames));
  }
  out->frames = framesText(frames);
  const std::string of_frames = fmt::format("by the box{} and values of frame{} {}{}", frames.size() == 1 ? "" : "es",
                                            frames.size() == 1 ? "" : "s", out->frames,
                                            frames.size() == 1 ? " (of frames converted to stores, by all)" : "");
  out->choice = "one camera and one transfer function for all frames: " +
                (frames.empty() ? "by the volume, which all frames share" : of_frames);
  return out;
}

}  // namespace kiln

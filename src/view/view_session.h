// A viewing session: open volumes, one cache, requests by name. It knows jobs and pictures, and no HTTP.
//
// The requests are those of the manual page view.md. A frame is answered by a stream: a preview at once, refinements,
// and the picture that `kiln render` draws of the job, bit for bit. A newer frame of a page ends its older one.
// Threads. Each request has the thread of its connection; DrawingTurns lets one draw at a time.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/thread/parallel.h"
#include "view/drawing_turns.h"
#include "view/view_client.h"
#include "view/view_painter.h"

namespace kiln {

class RequestBody;

struct ViewSource {
  RenderJob drawn;                                            // its volumes are stores, or `volumes`
  std::vector<std::shared_ptr<const BrickedVolume>> volumes;  // open volumes of the job; empty: the session opens them
  RenderJob named;                                            // with the volumes as the user named them, for saved jobs
  std::filesystem::path job_file;                             // the only file that `save` writes
  std::string kept_keys = "{}";                               // JSON; what saved jobs keep, as keptKeys
  /// Throws Error kUsage if writing `output` would replace a file that the session reads. thread: any.
  std::function<void(const std::filesystem::path& output)> require_free = [](const std::filesystem::path&) {};
  std::string title;
};

class ViewSession final : public ViewService {
 public:
  /// Opens the volumes, and checks that the job can be drawn. requires: `progress` outlives the object. throws: as
  /// OpenedJob.
  ViewSession(ViewSource source, Progress& progress);

  Request kindOf(std::string_view name) const override;
  void answer(std::string_view name, const std::string& body, ViewClient& client) override;
  void stop() override;

 private:
  class FrameStops;
  class OtherStops;
  using Answer = void (ViewSession::*)(const RequestBody&, ViewClient&);
  struct Row {
    std::string_view name;
    Answer answer;
    bool has_body = true;
  };
  static const Row* rowOf(std::string_view name);

  void sessionFacts(const RequestBody& body, ViewClient& client);
  void frame(const RequestBody& body, ViewClient& client);
  void resolve(const RequestBody& body, ViewClient& client);
  void slice(const RequestBody& body, ViewClient& client);
  void probe(const RequestBody& body, ViewClient& client);
  void thumbnail(const RequestBody& body, ViewClient& client);
  void function(const RequestBody& body, ViewClient& client);
  void command(const RequestBody& body, ViewClient& client);
  void estimate(const RequestBody& body, ViewClient& client);
  void save(const RequestBody& body, ViewClient& client);
  void render(const RequestBody& body, ViewClient& client);

  void drawStages(const RenderJob& job, bool moving, std::int64_t seq, FrameStops& stops, ViewClient& client);
  /// Calls work() in this thread's turn. Work is begun anew after a frame has interrupted it; after `patience` seconds
  /// no frame interrupts.
  template <class Work>
  auto inTurn(ViewClient& client, const Work& work, double patience = std::numeric_limits<double>::infinity());
  RenderJob jobOf(const RequestBody& body) const;
  /// The job as `save` saves it, with the volumes as the user named them, all frames and planes. throws: Error kUsage
  /// for a volume's name that the saved job would read as a pattern, or cannot hold.
  RenderJob savedJobOf(const RequestBody& body) const;
  /// The job with a single frame, the first if the request names none: other frames take time to prepare.
  RenderJob frameJobOf(const RequestBody& body) const;
  void requireDrawable(const RenderJob& job, ViewClient& client);
  std::size_t volumeOf(const RequestBody& body) const;
  /// throws: Error kUsage without a file.
  const std::filesystem::path& jobFile() const;
  struct Page;
  std::shared_ptr<Page> pageOf(const RequestBody& body);
  bool stale(Page& page, std::int64_t seq);

  const ViewSource source_;
  const ThreadLimit threads_;
  ViewPainter painter_;
  DrawingTurns turns_;
  std::atomic<bool> stopped_ = false;
  std::mutex frames_;                         // guards the pages, but for their frames
  std::vector<std::shared_ptr<Page>> pages_;  // the last to send a frame is last
};

}  // namespace kiln

// The viewer of an open volume: its server has a thread, until it is stopped.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <atomic>
#include <mutex>
#include <thread>
#include <utility>

#include "base/file/file.h"
#include "job/job_facts.h"
#include "python/modules.h"
#include "python/volume.h"
#include "view/view_job.h"
#include "view/view_server.h"
#include "view/view_session.h"

namespace kiln::python {
namespace {

class Viewer {
 public:
  Viewer(ViewSource source, const ViewServerOptions& options)
      : session_(std::move(source), silent_),
        server_(makeViewServer(session_, options)),
        address_(server_->address()),
        thread_([this] { server_->run([this] { return stopped_.load(); }); }) {}
  ~Viewer() { stop(); }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  const std::string& address() const { return address_; }
  // Ends the server and closes its port. thread: any.
  void stop() {
    stopped_ = true;
    const std::lock_guard lock(ending_);
    if (thread_.joinable()) thread_.join();
    server_.reset();
  }

 private:
  Progress silent_;
  ViewSession session_;
  std::unique_ptr<ViewServer> server_;
  const std::string address_;
  std::atomic<bool> stopped_ = false;
  std::mutex ending_;
  std::thread thread_;  // last: begins with all other members made
};

ViewSource sourceOf(const Volume& volume, const JobWords& words, const MoreVolumes& more,
                    const std::filesystem::path& job_file, const std::string& title) {
  if (!job_file.empty() && extensionOf(job_file) != ".json")
    throw Error(ErrorCode::kUsage, job_file, "job", "is no job's name; it must end in .json");
  if (!job_file.empty()) requireOutsideStores(job_file, "job");
  ViewSource out;
  out.drawn = jobOf(volume.bricks()->path(), words, more.names());
  requireViewable(out.drawn);
  out.drawn.trace.clear();
  out.drawn.output = encodingsOf(out.drawn.output);
  out.named = out.drawn;
  out.volumes = more.behind(volume);
  out.job_file = job_file;
  out.require_free = [](const std::filesystem::path& output) { requireOutsideStores(output); };
  out.title = title;
  return out;
}

}  // namespace

void bindViewer(py::module_& module) {
  py::class_<Viewer, UnlockedPointer<Viewer>>(module, "Viewer")
      .def(py::init([](const Volume& volume, const JobWords& words, const MoreVolumes& more,
                       const std::filesystem::path& job_file, const std::string& title, int port) {
        ViewServerOptions options;
        options.port = static_cast<std::uint16_t>(port);
        options.framed = true;
        ViewSource source = sourceOf(volume, words, more, job_file, title);
        std::unique_ptr<Viewer> out;
        runForCall(py::none(), [&](Progress&) { out = std::make_unique<Viewer>(std::move(source), options); });
        return UnlockedPointer<Viewer>(out.release());
      }))
      .def_property_readonly("address", &Viewer::address)
      .def("stop", &Viewer::stop, py::call_guard<py::gil_scoped_release>());
}

}  // namespace kiln::python

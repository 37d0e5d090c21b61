#include <fmt/format.h>

#include <optional>

#include "base/file/file.h"
#include "base/memory/memory.h"
#include "base/shell_text.h"
#include "commands.h"
#include "examples.h"
#include "input_job.h"
#include "job/job_facts.h"
#include "job_arguments.h"
#include "open_browser.h"
#include "say.h"
#include "scene_arguments.h"
#include "sequence/sequence_frames.h"
#include "sequence/series_volumes.h"
#include "view/view_job.h"
#include "view/view_server.h"
#include "view/view_session.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

struct ViewArguments {
  std::string input, socket;
  std::optional<std::string> job_file;
  int port = 0;
  std::vector<std::string> hosts;
  bool no_browser = false;
  JobArguments job;
  AddedArguments volumes;
  ForeignArguments source;
};

// A header Host or Origin is compared by its name alone.
std::string refusalOfHost(const std::string& text) {
  const bool of_six = text.starts_with('[') && text.ends_with(']');  // an address of IPv6
  const bool plain = text.find('/') == std::string::npos && (text.find(':') == std::string::npos || of_six);
  return plain ? "" : fmt::format("expected a name without scheme, port and path, found '{}'", text);
}

// "head.view.json" of "scans/head.nrrd", of "head.kiln/" and of "head.json".
fs::path defaultJobFile(const std::string& input) {
  fs::path name = fs::path(input).lexically_normal();
  if (!name.has_filename()) name = name.parent_path();
  const std::string stem = name.filename().stem().string();
  return stem.ends_with(".view") ? stem + ".json" : stem + ".view.json";
}

// Returns the file for the job, empty if there is no place for it and none was asked for.
fs::path jobFileOf(const ViewArguments& a) {
  const fs::path file = a.job_file ? fs::path(*a.job_file) : defaultJobFile(a.input);
  if (extensionOf(file) != ".json")
    throw Error(ErrorCode::kUsage, file, "--job", "is no job's name; it must end in .json");
  try {
    FileSystem::real().requirePlaceFor(file);
  } catch (const Error&) {
    if (a.job_file) throw;
    return {};
  }
  return file;
}

RenderJob jobOf(const ViewArguments& a) {
  RenderJob job = jobOfInput(a.input, a.job.given(), a.volumes);
  requireViewable(job);
  job.trace.clear();
  job.output = encodingsOf(job.output);
  return job;
}

void requireFree(const std::vector<fs::path>& inputs, const fs::path& output) {
  OutputFiles outputs;
  outputs.add(output, "--job");
  std::error_code ignored;
  for (const fs::path& input : inputs) {
    // A new file beside the slices of a folder replaces none of them.
    if (isStore(input) || !fs::is_directory(input, ignored) || fs::exists(output, ignored)) outputs.requireNone(input);
  }
}

ViewSource sourceOf(const ViewArguments& a, Context& context) {
  ViewSource out;
  out.named = jobOf(a);
  out.job_file = jobFileOf(a);
  if (extensionOf(a.input) == ".json") out.kept_keys = keptKeys(a.input);
  OutputFiles outputs;
  if (!out.job_file.empty() && extensionOf(a.input) != ".json") outputs.add(out.job_file, "--job");
  const InputOptions input(a.source, out.named);
  const StoreFor store_for = [&](const fs::path& volume) {
    const bool labels = input.areLabels(volume);
    return requiredClass(storeOfInput(input.of(volume), out.named.speed.memory_bytes, outputs, context, labels),
                         labels);
  };
  out.drawn = jobAtFrame(out.named, framesOf(out.named).front());
  out.drawn.series = seriesLook(out.named, store_for);
  forEachVolume(out.drawn, store_for);
  // A job has no options of volume files: it names the store.
  if (a.source.any()) {
    if (out.named.volumes.empty())
      out.named.volume = out.drawn.volume;
    else
      out.named.volumes.front().volume = out.drawn.volumes.front().volume;
  }
  std::vector<fs::path> inputs = inputsOf(out.named);
  for (const fs::path& store : inputVolumesOf(out.drawn)) inputs.push_back(store);
  std::error_code ignored;
  // A viewed job may be saved again.
  if (!fs::equivalent(a.input, out.job_file, ignored)) inputs.emplace_back(a.input);
  if (!out.job_file.empty()) requireFree(inputs, out.job_file);
  out.require_free = [inputs](const fs::path& output) { requireFree(inputs, output); };
  out.title = fs::path(a.input).lexically_normal().filename().string();
  return out;
}

void printAddress(const ViewArguments& a, const ViewServer& server) {
  if (a.socket.empty()) {
    say("  {}\n", server.address());
  } else {
    say("  http://localhost:8000/#{}\n  after: ssh -L 8000:{} THIS_MACHINE\n", server.token(),
        shellText(fs::absolute(a.socket).string()));
  }
  flush();
}

void run(const ViewArguments& a, Context& context) {
  if (!a.socket.empty() && a.port != 0)
    throw Error(ErrorCode::kUsage, "--socket: contradicts --port; give one of them");
  shareHeaps();
  ViewSession session(sourceOf(a, context), context.progress);
  ViewServerOptions options;
  options.port = static_cast<std::uint16_t>(a.port);
  options.socket = a.socket;
  options.hosts = a.hosts;
  const std::unique_ptr<ViewServer> server = makeViewServer(session, options);
  context.progress.clear();
  printAddress(a, *server);
  std::optional<OpenedBrowser> browser;
  if (!a.no_browser && a.socket.empty()) browser.emplace(server->address());
  server->run([&] { return context.progress.cancelled() || terminalIsGone(); });
}

}  // namespace

void addView(CLI::App& app, Context& context) {
  auto a = std::make_shared<ViewArguments>();
  CLI::App* command = app.add_subcommand("view", "Look at a volume in a browser, and save the job that draws it.");
  command
      ->add_option("INPUT", a->input,
                   "A store, a volume file (converted to a store beside it first), JOB.json, or a picture of Kiln, "
                   ".exr or .png.")
      ->required();
  command
      ->add_option("--job", a->job_file,
                   "The only file that is written: the job that the page saves, and pictures beside it. Default: "
                   "NAME.view.json in the working directory.")
      ->type_name("FILE");
  command->add_option("--port", a->port, "Port of 127.0.0.1; 0 takes a free one.")
      ->check(wholeNumberFrom(0, 65535))
      ->capture_default_str()
      ->type_name("N");
  command
      ->add_option("--socket", a->socket,
                   "Listen on a UNIX socket of this name, which only its owner may open, instead of a port: for "
                   "machines with other users.")
      ->type_name("FILE");
  command
      ->add_option("--allow-host", a->hosts,
                   "Answer requests to this name, too: of a proxy in front of the server. Repeatable.")
      ->type_name("NAME")
      ->check(CLI::Validator(refusalOfHost, ""))
      ->allow_extra_args(false);
  command->add_flag("--no-browser", a->no_browser,
                    "Print the address, and open no browser. Without a desktop or a terminal none is opened.");
  for (const OptionGroup group :
       {OptionGroup::kCamera, OptionGroup::kTransferFunction, OptionGroup::kLight, OptionGroup::kShown,
        OptionGroup::kAnnotations, OptionGroup::kQuality, OptionGroup::kCost}) {
    a->job.addTo(*command, context.facts, group, "--trace");
    if (group == OptionGroup::kShown) a->volumes.addTo(*command, context.facts);
  }
  addForeignArguments(*command, context.facts, a->source);
  addExamples(*command, {"kiln view head.kiln --tf ct-bone", "kiln view head.kiln --job look.json --socket view.sock"});
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool

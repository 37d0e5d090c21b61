// The program: reads the command line, runs one command, and turns every failure into one line and an exit code.
// Exit codes: 0 done, 1 data or system, 2 command line. Under mpirun one rank prints, and a failing rank ends all
// ranks.
#include "tool_main.h"

#include <execinfo.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <future>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/duration_text.h"
#include "base/error.h"
#include "base/process.h"
#include "base/refusal.h"
#include "base/shell_text.h"
#include "cluster/agreement.h"
#include "commands.h"
#include "say.h"
#include "source_arguments.h"
#include "unknown_option.h"

namespace {

using kiln::tool::complain;

// True under Open MPI's mpirun and other launchers (srun --mpi=pmix, Hydra), which set variables of the environment.
bool startedAsRank() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_SIZE"}) {
    if (std::getenv(name) != nullptr) return true;
  }
  return false;
}

// Every rank gets the same command line; only rank 0 reports errors in it.
int refuseCommandLine(const CLI::App& app, const CLI::ParseError& error, const kiln::Ranks& ranks) {
  if (!ranks.first()) return 2;
  if (app.get_subcommands().empty() && !app.remaining().empty()) {
    complain("kiln: {}\n", kiln::tool::unknownCommandText(app, app.remaining().front()));
    return 2;
  }
  if (const std::string unknown = kiln::tool::unknownOptionText(app); !unknown.empty())
    complain("kiln: {}\n", unknown);
  else if (const std::string repeated = kiln::tool::repeatedOptionText(app); !repeated.empty())
    complain("kiln: {}\n", repeated);
  else
    complain("kiln: {}{}\n", error.what(),
             // A question proposes the remedy itself.
             std::string_view(error.what()).ends_with('?') ? "" : "; run 'kiln --help' or 'kiln COMMAND --help'");
  return 2;
}

// Replaces "--option=" by "--option" and "", for options that take a value: CLI11 would take a value for missing.
void splitEmptyValues(const CLI::App& app, std::vector<std::string>& arguments) {
  const auto named = app.get_subcommands(
      [&](const CLI::App* command) { return !arguments.empty() && command->get_name() == arguments.front(); });
  if (named.empty()) return;
  for (std::size_t i = 1; i < arguments.size() && arguments[i] != "--"; ++i) {
    if (!arguments[i].starts_with("--") || arguments[i].find('=') != arguments[i].size() - 1) continue;
    const std::string name = arguments[i].substr(0, arguments[i].size() - 1);
    const CLI::Option* const option = named.front()->get_option_no_throw(name);
    if (option == nullptr || option->get_items_expected_max() == 0) continue;
    arguments[i] = name;
    arguments.insert(arguments.begin() + static_cast<std::ptrdiff_t>(++i), "");
  }
}

// Returns the arguments from the last to the first, as CLI11 takes them. "help COMMAND" becomes "COMMAND --help".
std::vector<std::string> reversedArguments(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> out(argv + 1, argv + argc);
  if (!out.empty() && out.front() == "help") {
    out.erase(out.begin());
    out.push_back("--help");
  }
  splitEmptyValues(app, out);
  std::reverse(out.begin(), out.end());
  return out;
}

// Returns the name of an option of the command with an empty argument, as a script with an unset variable gives.
std::string emptyArgument(const CLI::App& app, const kiln::tool::OptionFacts& facts) {
  for (const CLI::App* const command : app.get_subcommands()) {
    for (const CLI::Option* const option : command->get_options()) {
      if (facts.mayBeEmpty(*option)) continue;
      for (const std::string& text : option->results())
        if (text.empty()) return option->get_name();
    }
  }
  return {};
}

constexpr const char* kNoMemory = "the machine has no more memory to give; lower --memory or the image's size";
constexpr const char* kNoThread =
    "the system gives this process no more threads or memory (ulimit -u, -v); lower --threads, or raise the limit";

// The sentence of a refusal; null for kNone.
const char* sentenceOf(kiln::Refusal refusal) {
  switch (refusal) {
    case kiln::Refusal::kMemory:
      return kNoMemory;
    case kiln::Refusal::kThreads:
      return kNoThread;
    case kiln::Refusal::kNone:
      break;
  }
  return nullptr;
}

// Ends the process in one line if a thread, or a library before `main`, is refused memory or a thread.
[[noreturn]] void endUnhandled() {
  try {
    if (const std::exception_ptr unhandled = std::current_exception()) std::rethrow_exception(unhandled);
  } catch (const std::exception& error) {
    if (const char* const sentence = sentenceOf(kiln::refusalOf(error))) {
      kiln::tool::complainPlainly(sentence);
      std::_Exit(1);
    }
  } catch (...) {
  }
  std::abort();
}

void handleUnhandled(int /*argc*/, char** /*argv*/, char** /*environment*/) { std::set_terminate(endUnhandled); }
// Runs before the constructors of shared libraries, because some libraries of OpenVDB start threads there.
[[gnu::used, gnu::section(".preinit_array")]] void (*const before_libraries)(int, char**, char**) = handleUnhandled;

std::string unexpected(const std::exception& error) {
  return std::string("unexpected: ") + error.what() + "; this is a defect, please report it";
}

// Ends all ranks. The first rank to claim the failure reports it; a rank that notices later prints nothing.
[[noreturn]] void endAll(kiln::Ranks& ranks, const std::string& sentence, int exit_code) {
  if (ranks.claimFailure())
    complain("kiln: rank {} of {}: {}\n", ranks.rank(), ranks.count(), sentence);
  else
    std::this_thread::sleep_for(std::chrono::seconds(3));
  ranks.abort(exit_code);
  std::_Exit(exit_code);  // not reached; a compiler may expect `abort`, a virtual function, to return
}

int fail(kiln::tool::Context& context, const std::string& sentence, int exit_code) {
  context.progress.clear();
  if (!context.ranks->alone()) endAll(*context.ranks, sentence, exit_code);
  complain("kiln: {}\n", sentence);
  return exit_code;
}

// Output on a closed or full standard output is an error, because a script may have read half of it.
constexpr const char* kUnsaid = "standard output: could not be written to its end; is the disk full?";
bool saidAll() { return std::fflush(stdout) == 0 && std::ferror(stdout) == 0; }

// Options that may differ between ranks: speed, and files of one rank.
bool isOfOneRank(const CLI::Option& option) {
  static constexpr const char* kNames[] = {"--threads",  "--memory", "--stats",       "--trace",
                                           "--progress", "--store",  "--store-local", "--rank-timeout"};
  return std::any_of(std::begin(kNames), std::end(kNames), [&](const char* name) { return option.check_name(name); });
}

// Returns the facts of the command line that all ranks must share, with the error found in it.
std::vector<kiln::RankFact> commandFacts(const CLI::App& app, const std::string& refused) {
  std::vector<kiln::RankFact> out = {{"the version of kiln", KILN_VERSION}, {"the command line's error", refused}};
  std::string chosen;
  for (const CLI::App* const command : app.get_subcommands()) chosen += command->get_name();
  out.push_back({"the command", chosen});
  for (const CLI::App* const command : app.get_subcommands()) {
    for (const CLI::Option* const option : command->get_options()) {
      if (isOfOneRank(*option)) continue;
      std::string values;
      for (const std::string& value : option->results()) values += (values.empty() ? "" : " ") + value;
      out.push_back({option->get_name(), values});
    }
  }
  return out;
}

// Ends all ranks for a silent one. The sentence is printed unless another rank has claimed the failure, or if the claim
// gets no answer in time, as from a first rank that has died on another machine.
[[noreturn]] void endAllForOne(kiln::Ranks& ranks, const std::string& sentence) {
  const auto claim = std::make_shared<std::promise<bool>>();
  std::thread([&ranks, claim] { claim->set_value(ranks.claimFailure()); }).detach();
  std::future<bool> first = claim->get_future();
  const bool answered = first.wait_for(std::chrono::milliseconds(500)) == std::future_status::ready;
  if (!answered || first.get()) complain("kiln: {}\n", sentence);
  ranks.abort(1);
  std::_Exit(1);  // not reached; see endAll
}

// Ends all ranks if one of them hangs.
void watch(kiln::Ranks& ranks, double seconds) {
  if (seconds > 0) ranks.watch(seconds, [&ranks](const std::string& sentence) { endAllForOne(ranks, sentence); });
}

// The number of this rank before MPI starts, from the launcher.
int expectedRank() {
  for (const char* const name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}) {
    if (const char* const rank = std::getenv(name)) return std::atoi(rank);
  }
  return 0;
}

// Limits calls of MPI that wait for other ranks. Each rank waits longer than the rank before, so a single rank
// reports.
kiln::CallLimit limitOfMpi(double seconds) {
  if (seconds <= 0) return {};
  constexpr double kTurn_s = 0.5;
  return {seconds + kTurn_s * expectedRank(), [seconds] {
            complain(
                "kiln: MPI has waited for another rank for {}; it is stopped, or its machine or network is gone; "
                "--rank-timeout {:g} ends the run\n",
                kiln::roughDurationText(seconds), seconds);
            std::_Exit(1);
          }};
}

std::unique_ptr<kiln::Ranks> startRanks(double timeout_s) {
  return startedAsRank() ? kiln::mpiRanks(limitOfMpi(timeout_s)) : kiln::oneRank();
}

int run(int argc, char** argv) {
  using namespace kiln::tool;
  CLI::App app("Kiln renders scalar volumes larger than memory, on CPUs, from the command line.", "kiln");
  app.set_version_flag("--version", std::string("kiln ") + KILN_VERSION);
  app.require_subcommand(1);
  Context context;
  for (int i = 0; i < argc; ++i)
    context.command_line += (i == 0 ? "" : " ") + (i == 0 ? "kiln" : kiln::shellText(argv[i]));
  addConvert(app, context);
  addInfo(app, context);
  addVerify(app, context);
  addExport(app, context);
  addSlice(app, context);
  addGallery(app, context);
  addTf(app, context);
  addRender(app, context);
  addView(app, context);
  addSplit(app, context);
  addComposite(app, context);
  addCompare(app, context);
  addSchema(app, context);
  addBench(app, context);
  addManual(app, context);
  std::optional<CLI::Success> answered;
  std::optional<CLI::ParseError> refused;
  try {
    app.parse(reversedArguments(app, argc, argv));
    if (const std::string empty = emptyArgument(app, context.facts); !empty.empty())
      refused = CLI::ValidationError(empty, "is empty; write its value");
  } catch (const CLI::Success& asked) {
    // Help for a command that does not exist.
    if (app.get_subcommands().empty() && !app.remaining().empty())
      refused = CLI::ExtrasError(app.remaining());
    else
      answered = asked;
  } catch (const CLI::ParseError& error) {
    refused = error;
  }
  const std::unique_ptr<kiln::Ranks> started = startRanks(context.rank_timeout_s);
  kiln::Ranks& ranks = *started;
  context.ranks = &ranks;
  if (!ranks.first()) context.progress.speakAsRank(ranks.rank());
  watch(ranks, context.rank_timeout_s);
  try {
    kiln::requireAgreement(ranks, commandFacts(app, refused ? refused->what() : ""));
    if (answered) return ranks.first() ? app.exit(*answered) : 0;
    if (refused) return refuseCommandLine(app, *refused, ranks);
    installInterruptHandler();
    if (ranks.first() || context.by_all_ranks) context.action();
    return 0;
  } catch (const kiln::Error& error) {
    return fail(context, error.what(), error.exitCode());
  } catch (const std::exception& error) {
    if (const char* const sentence = sentenceOf(kiln::refusalOf(error))) return fail(context, sentence, 1);
    return fail(context, saidAll() ? unexpected(error) : kUnsaid, 1);
  }
}

// Loads libgcc, which unwinding through a function of the C library needs. Without memory the C library cannot load
// libgcc and ends the process.
void loadUnwinder() {
  void* frame = nullptr;
  ::backtrace(&frame, 1);
}

// Opens closed standard streams on /dev/null. Else the next opened files would get the numbers of the streams, and the
// program would print into them.
void occupyStandardFiles() {
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(file, F_GETFD) >= 0) continue;
    // Printing to such a stream still fails and is reported.
    const int opened = ::open("/dev/null", file == STDERR_FILENO ? O_WRONLY : O_RDONLY);
    if (opened >= 0 && opened != file) ::close(opened);
  }
}

// Refuses to start with too few open files, because a command could then fail anywhere, even during its clean-up.
void requireOpenFiles() {
  constexpr std::uint64_t kLeast = 16;
  if (const std::uint64_t most = kiln::mostOpenFiles(); most < kLeast)
    throw kiln::Error(kiln::ErrorCode::kIo,
                      fmt::format("this process may have {} files open, and at least {} are needed; allow more "
                                  "(ulimit -n 1024 is enough)",
                                  most, kLeast));
}

}  // namespace

CLI::Option* kiln::tool::addRankTimeout(CLI::App& command, Context& context) {
  return command
      .add_option("--rank-timeout", context.rank_timeout_s,
                  "Under mpirun: end the run with an error once a rank has neither answered nor read, written or "
                  "computed for this long (a stopped process, a disk that does not answer). 0 waits without end.")
      ->check(kiln::tool::numberFrom(0, 1e6))
      ->capture_default_str()
      ->type_name("SECONDS");
}

int kilnToolMain(int argc, char** argv) {
  loadUnwinder();
  occupyStandardFiles();
  // Beyond a limit of file sizes a write fails, and is told of, as on a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    requireOpenFiles();
    const int exit_code = run(argc, argv);
    if (exit_code != 0 || saidAll()) return exit_code;
    complain("kiln: {}\n", kUnsaid);
    return 1;
  } catch (const kiln::Error& error) {
    complain("kiln: {}\n", error.what());
    return error.exitCode();
  } catch (const std::exception& error) {
    if (const char* const sentence = sentenceOf(kiln::refusalOf(error))) {
      kiln::tool::complainPlainly(sentence);
      return 1;
    }
    complain("kiln: {}\n", unexpected(error));
    return 1;
  }
}

#include "convert/resume_state.h"

#include <fmt/format.h>

#include <optional>

#include "base/byte_record.h"
#include "cluster/agreement.h"
#include "convert/resume/source_state.h"
#include "store/codec/brick_codec.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Identifies the bricks of a conversion as text, with the names and the state of the source files: equal texts give
// equal bricks.
std::string identityOf(Manifest draft) {
  draft.source.command.clear();
  draft.source.time.clear();
  draft.source.state = portableState(draft.source.state);
  return containerVersion() + "\n" + manifestText(draft);
}

// Returns the identity of an interrupted conversion of this volume, if present; clears anything else.
std::optional<ConversionIdentity> resumable(OutputDirectory& destination, const Manifest& draft,
                                            const ConvertOptions& options) {
  std::optional<ConversionIdentity> found = Journal::identityIn(destination.building());
  if (found && found->volume != identityOf(draft)) {
    if (!options.overwrite) {
      throw Error(ErrorCode::kExists, destination.building(), "",
                  "was begun from another source, an older state of it, or with other options; give --overwrite to "
                  "begin anew");
    }
    found.reset();
  }
  if (!found) destination.clear();
  return found;
}

}  // namespace

void requireSameSource(const SourceInfo& info, const Manifest& draft, Ranks& ranks) {
  const std::string file = info.files.empty() ? std::string("the volume") : info.files.front().string();
  const RankFact facts[] = {{"the volume", identityOf(draft), [&](const std::string&, const std::string&) {
                               return file + " is not the same file there and here";
                             }}};
  requireAgreement(ranks, facts);
}

void share(ResumeState& state, Ranks& ranks) {
  if (ranks.alone()) return;
  std::vector<std::byte> bytes;
  appendValue(bytes, state.finished);
  appendValue(bytes, state.noted);
  ConversionIdentity& identity = state.identity;
  for (const std::string& text : {state.directory.string(), identity.volume, identity.command, identity.time})
    appendText(bytes, text);
  ranks.broadcast(bytes);
  ByteTaker taker{bytes};
  state.finished = taker.take<bool>();
  state.noted = taker.take<std::uint64_t>();
  state.directory = taker.takeText();
  for (std::string* text : {&identity.volume, &identity.command, &identity.time}) *text = taker.takeText();
}

ResumeState beginAt(OutputDirectory& destination, const Manifest& draft, const ConvertOptions& options,
                    const Ranks& ranks, FileSystem& disk) {
  ResumeState out{destination.finished(), destination.building(), {identityOf(draft), options.command, options.time}};
  if (out.finished) return out;
  if (options.resume) {
    if (std::optional<ConversionIdentity> found = resumable(destination, draft, options)) {
      out.identity = *std::move(found);
      Journal::forEachBrick(out.directory, [&](const FinishedBrick&) { ++out.noted; });
    }
  }
  destination.make();
  // Each rank clears its own folder below `parts`; an earlier run may have had more ranks.
  if (!ranks.alone()) disk.removeAll(out.directory / "parts");
  return out;
}

}  // namespace kiln

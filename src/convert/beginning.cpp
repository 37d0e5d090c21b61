#include "convert/beginning.h"

#include <fmt/format.h>

#include <optional>

#include "base/byte_record.h"
#include "cluster/agreement.h"
#include "convert/earlier_bricks.h"
#include "convert/source_state.h"
#include "store/brick_codec.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// What bricks are made of, as text: the same text, with the names and the state of files in it, gives the same bricks.
std::string identityOf(Manifest draft) {
  draft.source.command.clear();
  draft.source.time.clear();
  draft.source.state = portableState(draft.source.state);
  return containerVersion() + "\n" + manifestText(draft);
}

// What an interrupted conversion of the same volume left, where there is any; anything else that it left is cleared.
std::optional<JournalContent> resumable(Destination& destination, const Manifest& draft,
                                        const ConvertOptions& options) {
  std::optional<JournalContent> found = Journal::read(destination.building());
  if (found && found->identity.volume != identityOf(draft)) {
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

void share(Beginning& beginning, Ranks& ranks) {
  if (ranks.alone()) return;
  std::vector<std::byte> bytes;
  appendValue(bytes, beginning.finished);
  for (const std::string& text : {beginning.directory.string(), beginning.earlier.identity.volume,
                                  beginning.earlier.identity.command, beginning.earlier.identity.time})
    appendText(bytes, text);
  ranks.broadcast(bytes);
  ByteTaker taker{bytes};
  beginning.finished = taker.take<bool>();
  beginning.directory = taker.takeText();
  ConversionIdentity& identity = beginning.earlier.identity;
  for (std::string* text : {&identity.volume, &identity.command, &identity.time}) *text = taker.takeText();
  shareBricks(beginning.earlier.bricks, ranks);
}

Beginning beginAt(Destination& destination, const Manifest& draft, const ConvertOptions& options, const Ranks& ranks,
                  FileSystem& disk) {
  Beginning out{destination.finished(), destination.building(), {}};
  if (out.finished) return out;
  if (options.resume) {
    if (std::optional<JournalContent> found = resumable(destination, draft, options)) out.earlier = *std::move(found);
  }
  if (out.earlier.identity.volume.empty()) out.earlier.identity = {identityOf(draft), options.command, options.time};
  destination.make();
  // Each rank clears a folder of its own in it; there may have been more of them.
  if (!ranks.alone()) disk.removeAll(out.directory / "parts");
  return out;
}

}  // namespace kiln

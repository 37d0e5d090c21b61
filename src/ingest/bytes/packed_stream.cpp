// The libraries decode and verify the checksums; this file feeds them and turns their verdicts into errors that name
// the byte.
#include "ingest/bytes/packed_stream.h"

#include <fmt/format.h>

#include "base/error.h"

namespace kiln {

void PackedStream::fail(const std::string& where, const std::string& what) const {
  throw Error(ErrorCode::kFormat, file_.path(), fmt::format("byte {}, {}", offset(), where), what);
}

void PackedStream::failForMemory() const {
  throw Error(ErrorCode::kIo, file_.path(), "", "no memory for decompression");
}

bool PackedStream::refill() {
  if (!unread_.empty()) return true;
  if (next_offset_bytes_ >= file_.size()) return false;
  const std::size_t got = file_.readSomeAt(next_offset_bytes_, std::span(input_.get(), input_bytes_));
  next_offset_bytes_ += got;
  unread_ = std::span(input_.get(), got);
  return got > 0;
}

// Tests only the first byte of a next stream: the second byte may lie in the next chunk, and the library checks it.
void PackedStream::endStream() {
  if (refill() && beginAgain(unread_.front())) return;
  ended_ = true;
  while (mayBePadded() && refill() && unread_.front() == std::byte{0}) unread_ = unread_.subspan(1);
}

std::size_t PackedStream::step(std::span<std::byte> out, const std::string& where) {
  constexpr std::size_t kMostAtOnce = 1 << 30;
  const bool more = refill();
  const Step step = decode(unread_, out.first(std::min(out.size(), kMostAtOnce)));
  unread_ = unread_.subspan(step.used);
  if (step.verdict == Verdict::kNoMemory) failForMemory();
  if (step.verdict == Verdict::kDamaged)
    fail(where, fmt::format("the compressed data are damaged{}; get the file again",
                            step.complaint.empty() ? "" : " (" + step.complaint + ")"));
  if (step.verdict == Verdict::kEnded) {
    endStream();
  } else if (step.made == 0 && !more) {
    // A library may still hold output when the input is used up: the stream is cut once a step produces nothing.
    fail(where, "the compressed data end here before their end mark; the file is cut short, get it again");
  }
  return step.made;
}

std::size_t PackedStream::readSome(std::span<std::byte> out, const std::string& where) {
  std::size_t done = 0;
  while (done < out.size() && !ended_) done += step(out.subspan(done), where);
  return done;
}

void PackedStream::read(std::span<std::byte> out, const std::string& where) {
  if (readSome(out, where) < out.size())
    fail(where,
         "the compressed data end here, before the last voxel; the header's dimensions are too large or data are "
         "missing");
}

std::vector<std::string> PackedStream::finish() {
  std::vector<std::byte> dropped(kSkipBytes);
  std::uint64_t beyond = 0;
  while (const std::size_t got = readSome(dropped, "after the last slice")) beyond += got;
  std::vector<std::string> notes;
  const std::string name = file_.path().filename().string();
  const auto bytes = [](std::uint64_t count) { return fmt::format("{} byte{}", count, count == 1 ? "" : "s"); };
  if (beyond > 0)
    notes.push_back(
        fmt::format("the compressed data of {} hold {} more than the header's dimensions need, which are not "
                    "read",
                    name, bytes(beyond)));
  if (const std::uint64_t rest = file_.size() - offset(); rest > 0)
    notes.push_back(fmt::format("{}: {} behind the compressed data not read", name, bytes(rest)));
  return notes;
}

}  // namespace kiln

// A stack of TIFF pages in natural order of the file names: one file per slice, one file with many pages, or several of
// either. Boxes in any order. Uncompressed rows are read in place, whatever the size of a strip. Compressed strips and
// tiles are decoded one by one and cached for neighbouring boxes.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>

#include "base/error.h"
#include "base/memory/memory.h"
#include "ingest/bytes/block_cache.h"
#include "ingest/bytes/gather_rows.h"
#include "ingest/bytes/handle_pool.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/bytes/value_map.h"
#include "ingest/source/brick_order.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "ingest/tiff/tiff_file.h"
#include "ingest/tiff/tiff_spacing.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

struct Slice {
  std::size_t file = 0;
  int page = 0;
  std::uint64_t directory = 0;
  /// Offset of an image that follows the page without a directory of its own. unit: bytes behind the page's first byte.
  std::uint64_t behind = 0;
};

struct Stack {
  std::vector<Slice> slices;
  TiffPage first;
  std::optional<StackNotes> notes;
  /// The number of pages of each file.
  std::vector<std::size_t> pages;
  std::uint64_t decoding_bytes = 0;  // of the largest packed block
  TiffColours colours = TiffColours::kRefused;
  /// True if the names of the files chose a channel or time.
  bool chosen_by_name = false;
  /// ", channel 1": the part of several for SourceInfo::format.
  std::string part;
  /// Sentences for the user.
  std::vector<std::string> remarks;

  /// True for signed numbers as ImageJ writes them: unsigned and 32768 larger, although TIFF has a signed type.
  bool storesLargerBy32768() const { return notes && notes->offset_signed && first.type.voxel() == VoxelType::u16; }
};

// Describes the properties that pages of one volume must share.
std::string describe(const TiffPage& page) {
  return fmt::format("{} x {} of {}{}{}", page.width, page.height, nameOf(page.type),
                     page.smallest_is_white ? ", its smallest value white" : "",
                     page.orientation == 1 ? "" : fmt::format(", of orientation {}", page.orientation));
}

// `index` is the file's index in `files`. If the first two files differ, a third file decides which of them is
// wrong.
void requireAlike(const TiffPage& first, const std::vector<fs::path>& files, std::size_t index, const TiffFile& file,
                  std::size_t slice) {
  const TiffPage& page = file.page();
  if (page.isLike(first)) return;
  const auto fail = [](const fs::path& path, int number, const std::string& what) {
    throw Error(ErrorCode::kFormat, path, fmt::format("page {}", number), what + "; slices of one volume are alike");
  };
  if (index == 1 && files.size() > 2 && TiffFile(files[2], file.colours()).page().isLike(page))
    fail(files[0], first.number,
         fmt::format("slice 0 is {}, but the next, in {}, is {}", describe(first), files[1].filename().string(),
                     describe(page)));
  fail(files[index], page.number,
       fmt::format("slice {} is {}, but the first, in {}, is {}", slice, describe(page), files[0].filename().string(),
                   describe(first)));
}

// A file of several pages among single-page files is probably not a slice, and would move the slices above it.
void requirePagesAlike(Stack& stack, const std::vector<fs::path>& files, const SourceOptions& options) {
  const auto several = std::find_if(stack.pages.begin(), stack.pages.end(), [](std::size_t n) { return n > 1; });
  const auto single = std::find(stack.pages.begin(), stack.pages.end(), 1u);
  if (several == stack.pages.end() || single == stack.pages.end()) return;
  const auto file = [&](auto at) { return files[static_cast<std::size_t>(at - stack.pages.begin())]; };
  const std::string what =
      fmt::format("has {} pages, but {} has 1; slices are files of one page each, or of several each", *several,
                  inQuotes(file(single).filename().string()));
  if (!options.allow_irregular)
    throw Error(ErrorCode::kFormat, file(several), "", what + "; --allow-irregular takes every page as a slice");
  stack.remarks.push_back(inQuotes(file(several).filename().string()) + " " + what + "; took every page as a slice");
}

void noteForViewers(const TiffPage& page, std::vector<std::string>& notes) {
  if (page.smallest_is_white)
    notes.push_back(
        "the TIFF files show their smallest values white (WhiteIsZero); the values are taken as stored, and a transfer "
        "function decides what is bright");
  if (page.orientation != 1)
    notes.push_back(fmt::format(
        "the TIFF files have Orientation {}, by which viewers turn or mirror them; the rows and columns are "
        "taken as stored",
        page.orientation));
}

// Keeps the slices of the chosen channel and time among the planes from `first` on. Returns the part for
// SourceInfo::format.
std::string choosePlanes(Stack& stack, std::size_t first, const std::optional<StackNotes>& told,
                         const SourceOptions& options, const fs::path& path) {
  const StackNotes notes = told.value_or(StackNotes());
  const bool several = notes.channels > 1 || notes.frames > 1;
  if (several && !notes.disorder.empty()) throw Error(ErrorCode::kUnsupported, path, "", notes.disorder);
  const auto found = static_cast<std::int64_t>(stack.slices.size() - first);
  if (several && (found % notes.frames != 0 || notes.slices * notes.channels != found / notes.frames))
    throw Error(ErrorCode::kFormat, path, "",
                fmt::format("{}'s description says {} slices, {} channels and {} times, but {} images are found",
                            notes.writer, notes.slices, notes.channels, notes.frames, found));
  std::vector<std::string> names = notes.channel_names;
  names.resize(static_cast<std::size_t>(notes.channels));
  const std::int64_t channel = chosenChannel(options, names, path), time = chosenTime(options, notes.frames, path);
  if (!several) return "";
  std::vector<Slice> chosen;
  for (std::int64_t z = 0; z < notes.slices; ++z)
    chosen.push_back(stack.slices[first + static_cast<std::size_t>(z * notes.slice_step + channel * notes.channel_step +
                                                                   time * notes.frame_step)]);
  stack.slices.resize(first);
  stack.slices.insert(stack.slices.end(), chosen.begin(), chosen.end());
  return partOf("channel", channel, notes.channels) + partOf("time", time, notes.frames);
}

// Returns the number of images behind the first directory: beyond 4 GB ImageJ writes a single directory, and tifffile
// does on request.
std::int64_t imagesBehind(const TiffFile& file, const StackNotes& notes) {
  const TiffPage& page = file.page();
  if (notes.counts_all_files || notes.images == 1 || page.packed || page.tiled || page.blocksDown() != 1) return 0;
  const std::uint64_t room = file.file().size() - file.blockOffset(0);
  if (static_cast<std::uint64_t>(notes.images) > room / page.bytes()) {
    file.fail(fmt::format("{}'s description says {} images, but the file ends after {}", notes.writer, notes.images,
                          room / page.bytes()));
  }
  return notes.images - 1;
}

// A zeroed link to the next page ends the file early; only the description still has the true number of images.
void requireImages(Stack& stack, const StackNotes& notes, std::size_t found, const fs::path& path,
                   const SourceOptions& options) {
  if (static_cast<std::uint64_t>(notes.images) <= found) return;
  const std::string what = fmt::format("{}'s description says {} images, but {} {} found; slices are missing",
                                       notes.writer, notes.images, found, found == 1 ? "is" : "are");
  if (!options.allow_irregular)
    throw Error(ErrorCode::kFormat, path, "", what + "; --allow-irregular takes the images that are there");
  stack.remarks.push_back(what);
}

void addFile(Stack& stack, const std::vector<fs::path>& files, std::size_t index, const SourceOptions& options) {
  TiffFile file(files[index], stack.colours);
  const std::optional<StackNotes> notes = stackNotes(file.description(), file.page().samples);
  if (index == 0) {
    stack.first = file.page();
    stack.notes = notes;
  }
  if ((notes && notes->offset_signed) != (stack.notes && stack.notes->offset_signed))
    throw Error(ErrorCode::kFormat, files[index], "",
                "describes its sign in another way than the first file; slices of one volume are alike");
  const std::size_t before = stack.slices.size();
  do {
    const TiffPage& page = file.page();
    requireAlike(stack.first, files, index, file, stack.slices.size());
    if (page.packed) stack.decoding_bytes = std::max(stack.decoding_bytes, page.decodingBytes());
    stack.slices.push_back({index, page.number, page.directory, 0});
  } while (file.next());
  stack.pages.push_back(stack.slices.size() - before);
  const Slice last = stack.slices.back();
  const std::int64_t behind = notes && stack.slices.size() == before + 1 ? imagesBehind(file, *notes) : 0;
  const std::size_t images = stack.slices.size() + static_cast<std::size_t>(behind);
  const std::uint64_t table_bytes = images * sizeof(Slice);
  if (table_bytes > options.memory_bytes)
    throw Error(ErrorCode::kBudget, files[index], "",
                fmt::format("the table of {} images takes {} (allowed: {}); give --memory {} or more", images,
                            formatBytes(table_bytes), formatBytes(options.memory_bytes), formatBytes(2 * table_bytes)));
  stack.slices.reserve(images);
  for (std::int64_t k = 1; k <= behind; ++k) {
    stack.slices.push_back({last.file, last.page, last.directory, static_cast<std::uint64_t>(k) * file.page().bytes()});
  }
  if (notes && notes->counts_all_files) return;
  if (notes) requireImages(stack, *notes, stack.slices.size() - before, files[index], options);
  if (!stack.chosen_by_name) stack.part = choosePlanes(stack, before, notes, options, files[index]);
}

class TiffSource : public VolumeSource {
 public:
  TiffSource(SourceInfo info, std::vector<fs::path> files, Stack stack)
      : info_(std::move(info)), files_(std::move(files)), stack_(std::move(stack)) {}

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  std::uint64_t decodeBytes() const override { return stack_.decoding_bytes; }
  std::uint64_t heldBytes() const override { return stack_.slices.capacity() * sizeof(Slice); }
  std::optional<DecodedBlocks> decodedBlocks() const override;
  void willRead(const BrickOrder& order) override { cache_.setOrder(order); }
  void keepDecoded(std::uint64_t bytes) override { cache_.setCapacity(bytes); }

 private:
  /// `first` is the first voxel of the box of which this is a slice or part.
  void readSlice(const VoxelBox& box, const VoxelCoord& first, std::byte* out);
  void readPart(TiffFile& file, const Slice& slice, const BlockCache::Use& use, const VoxelBox& part, std::byte* out);

  SourceInfo info_;
  std::vector<fs::path> files_;
  Stack stack_;
  HandlePool<TiffFile> open_;
  BlockCache cache_;
};

std::optional<DecodedBlocks> TiffSource::decodedBlocks() const {
  const TiffPage& page = stack_.first;
  if (!page.packed) return std::nullopt;
  return DecodedBlocks{{page.block_width, page.block_height, 1}, page.blockBytes(), cache_.decodings()};
}

void TiffSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  assert(out.size() == static_cast<std::size_t>(box.count()) * sizeOf(info_.type));
  if (box.empty()) return;
  const std::size_t slice_bytes = out.size() / static_cast<std::size_t>(box.extent().z);
  const ValueMap map = {stack_.first.type, stack_.first.type.voxel()};
  const auto count = static_cast<std::size_t>(box.extent().x * box.extent().y);
  std::vector<std::byte> stored(map.copies() ? 0 : count * sizeOf(map.from));
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    const VoxelBox in_slice = {{box.lo.x, box.lo.y, z}, {box.hi.x, box.hi.y, z + 1}};
    std::byte* const to = out.data() + static_cast<std::size_t>(z - box.lo.z) * slice_bytes;
    readSlice(in_slice, box.lo, map.copies() ? to : stored.data());
    if (map.copies()) continue;
    requireFits(map, stored.data(), count, files_[stack_.slices[static_cast<std::size_t>(z)].file], z);
    map.apply(stored.data(), count, to);
  }
  if (!stack_.storesLargerBy32768()) return;
  for (std::size_t i = 0; i < out.size(); i += sizeof(std::uint16_t)) {
    std::uint16_t value;
    std::memcpy(&value, &out[i], sizeof(value));
    value ^= 0x8000;
    std::memcpy(&out[i], &value, sizeof(value));
  }
}

// Reads a box of one slice block by block.
void TiffSource::readSlice(const VoxelBox& box, const VoxelCoord& first, std::byte* out) {
  const Slice& slice = stack_.slices[static_cast<std::size_t>(box.lo.z)];
  const auto file =
      open_.take(slice.file, [&] { return std::make_unique<TiffFile>(files_[slice.file], stack_.colours); });
  file->select(slice.page, slice.directory);
  const std::int64_t bw = file->page().block_width, bh = file->page().block_height;
  const std::size_t size = sizeOf(stack_.first.type), line = static_cast<std::size_t>(box.extent().x) * size;
  std::vector<std::byte> packed;
  for (std::int64_t y = box.lo.y / bh * bh; y < box.hi.y; y += bh) {
    for (std::int64_t x = box.lo.x / bw * bw; x < box.hi.x; x += bw) {
      const VoxelBox block = {{x, y, box.lo.z}, {x + bw, y + bh, box.hi.z}};
      const VoxelBox part = intersection(block, box);
      std::byte* to = out + static_cast<std::size_t>(part.lo.y - box.lo.y) * line +
                      static_cast<std::size_t>(part.lo.x - box.lo.x) * size;
      const std::size_t row = static_cast<std::size_t>(part.extent().x) * size;
      if (row == line) {
        readPart(*file, slice, {block, first}, part, to);
        continue;
      }
      packed.resize(static_cast<std::size_t>(part.count()) * size);
      readPart(*file, slice, {block, first}, part, packed.data());
      for (std::size_t y0 = 0; y0 * row < packed.size(); ++y0) std::memcpy(to + y0 * line, &packed[y0 * row], row);
    }
  }
}

// Reads the rows of `part`, densely packed.
void TiffSource::readPart(TiffFile& file, const Slice& slice, const BlockCache::Use& use, const VoxelBox& part,
                          std::byte* out) {
  const VoxelBox& block = use.block;
  const TiffPage& page = file.page();
  const std::uint64_t size = sizeOf(page.type), stride = static_cast<std::uint64_t>(page.block_width) * size;
  const std::uint64_t row = static_cast<std::uint64_t>(part.extent().x) * size;
  const std::uint64_t rows = static_cast<std::uint64_t>(part.extent().y);
  const std::uint64_t first = static_cast<std::uint64_t>(part.lo.y - block.lo.y) * stride +
                              static_cast<std::uint64_t>(part.lo.x - block.lo.x) * size;
  const std::int64_t index = block.lo.y / page.block_height * page.blocksAcross() + block.lo.x / page.block_width;
  if (page.packed) {
    const auto bytes = cache_.get(
        {block.lo.z, index}, [&](BlockCache::Bytes) { return file.decodeBlock(index); }, use);
    for (std::uint64_t y = 0; y < rows; ++y) std::memcpy(out + y * row, bytes->data() + first + y * stride, row);
    return;
  }
  gatherRows(file.file(), file.blockOffset(index) + slice.behind + first, rows, row, stride, out);
  if (page.swapped) swapBytes(out, static_cast<std::size_t>(part.count()), static_cast<std::size_t>(size));
}

}  // namespace

std::unique_ptr<VolumeSource> openTiff(const SliceFiles& input, const SourceOptions& options) {
  Stack stack;
  stack.part = input.part;
  if (options.luminance) stack.colours = TiffColours::kLuminance;
  stack.chosen_by_name = !input.part.empty();
  for (std::size_t i = 0; i < input.files.size(); ++i) addFile(stack, input.files, i, options);
  if (stack.notes && stack.notes->counts_all_files) {
    requireImages(stack, *stack.notes, stack.slices.size(), input.input, options);
    if (!stack.chosen_by_name) stack.part = choosePlanes(stack, 0, stack.notes, options, input.input);
  } else {
    requirePagesAlike(stack, input.files, options);
  }
  SourceInfo info;
  info.notes = input.notes;
  noteForViewers(stack.first, info.notes);
  info.notes.insert(info.notes.end(), stack.remarks.begin(), stack.remarks.end());
  info.type = stack.storesLargerBy32768() ? VoxelType::i16 : stack.first.type.voxel();
  const Extent3 dims = {stack.first.width, stack.first.height, static_cast<std::int64_t>(stack.slices.size())};
  checkedBytes(dims, info.type, input.input);
  const auto log = loggedSpacing(input, dims.x, dims.y, info.notes);
  info.geometry = tiffGeometry(dims, stack.first, stack.notes, log, options, info.notes);
  if (stack.notes && !stack.notes->line.empty())
    info.notes.push_back(fmt::format("by {}'s description values are {} what is stored; they are taken as stored",
                                     stack.notes->writer, stack.notes->line));
  info.format = fmt::format("TIFF, {} {}{}{}", dims.z, dims.z == 1 ? "slice" : "slices", stack.part,
                            options.luminance ? ", luminance" : "");
  if (input.files.size() != 1 || input.files.front() != input.input) info.files.push_back(input.input);
  info.files.insert(info.files.end(), input.files.begin(), input.files.end());
  if (log) info.files.push_back(log->log);
  return std::make_unique<TiffSource>(std::move(info), input.files, std::move(stack));
}

}  // namespace kiln

// Lists TIFF pages: of a file, runs of equal pages; of a stack, its files as slices, judged by the first file.
#include <fmt/format.h>

#include "base/error.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "ingest/tiff/tiff_file.h"
#include "ingest/tiff/tiff_spacing.h"

namespace kiln {
namespace {

// Describes the stacks of a file of several channels or times: one stack, and the options that choose one.
void describeStacks(const StackNotes& notes, ListedVolume& out) {
  if (notes.channels > 1) {
    out.kind += fmt::format(", {} channels", notes.channels);
    out.option = "--channel N";
  }
  if (notes.frames > 1) {
    out.kind += fmt::format(", {} times", notes.frames);
    out.option += out.option.empty() ? "--time N" : " --time N";
  }
  if (out.option.empty()) return;
  if (notes.slices > 0) out.dims->z = notes.slices;
  out.refusal = notes.disorder;
}

// A run of equal pages, named by their numbers from 1 on.
ListedVolume runOf(const TiffPage& first, int last) {
  ListedVolume out;
  out.name = first.number == last ? fmt::format("page {}", last) : fmt::format("pages {} to {}", first.number, last);
  out.kind = "TIFF";
  out.dims = Extent3{first.width, first.height, last - first.number + 1};
  out.type = first.type.voxel();
  return out;
}

std::vector<ListedVolume> pagesOf(TiffFile& file, const std::optional<StackNotes>& notes) {
  std::vector<ListedVolume> out;
  TiffPage first = file.page();
  int last = first.number;
  while (file.next()) {
    if (!file.page().isLike(first)) {
      out.push_back(runOf(first, last));
      first = file.page();
    }
    last = file.page().number;
  }
  out.push_back(runOf(first, last));
  if (out.size() > 1)
    for (ListedVolume& run : out) run.refusal = "pages of one volume are alike; save these pages alone";
  // ImageJ beyond 4 GB, and tifffile with truncate=True, write a single directory for all images.
  if (notes && out.size() == 1 && !notes->counts_all_files && notes->images > out.front().dims->z)
    out.front().dims->z = notes->images;
  if (notes && out.size() == 1) describeStacks(*notes, out.front());
  return out;
}

}  // namespace

std::vector<ListedVolume> listTiff(const std::vector<std::filesystem::path>& stack) {
  ListedVolume out;
  try {
    TiffFile file(stack.front());
    const std::optional<StackNotes> notes = stackNotes(file.description(), file.page().samples);
    std::vector<ListedVolume> pages = pagesOf(file, notes);
    if (pages.size() > 1 && stack.size() == 1) return pages;
    out = std::move(pages.front());
    // The description of one file may count the slices of all.
    const bool counted = notes && notes->counts_all_files && !out.option.empty();
    if (!counted) out.dims->z *= static_cast<std::int64_t>(stack.size());
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUnsupported) throw;
    out.kind = "TIFF";
    out.refusal = error.what();
  }
  out.name = nameOfStack(stack);
  return {out};
}

}  // namespace kiln

#include "output/image_file.h"

#include <cassert>

#include "base/error.h"
#include "base/file.h"
#include "output/exr_deep.h"
#include "output/exr_file.h"
#include "output/png_file.h"

namespace kiln {

bool isExrPath(const std::filesystem::path& path) { return extensionOf(path) == ".exr"; }

void requireImagePath(const std::filesystem::path& path, bool with_planes) {
  const std::string extension = extensionOf(path);
  if (extension == ".png" && with_planes)
    throw Error(ErrorCode::kUsage, path, "",
                "a PNG holds colours only; what is beside them (--aov) needs a name in .exr");
  if (extension == ".exr" || extension == ".png") return;
  throw Error(ErrorCode::kUsage, path, "", "is not a name for a picture; it must end in .exr or .png");
}

void writeImage(const Image& image, const ImageMetadata& metadata, const ImageFileOptions& options,
                const std::filesystem::path& path, FileSystem& disk) {
  assert(image.width > 0 && image.height > 0);
  assert(image.rgba.size() == static_cast<std::size_t>(image.width) * image.height * 4 || image.rgba.empty());
  assert(options.png_bits == 8 || options.png_bits == 16);
  requireImagePath(path, !image.planes.empty());
  disk.writeAtomic(path, isExrPath(path) ? encodeExr(image, metadata, options, path)
                                         : encodePng(image, options.png_bits, path, metadata.text));
}

void writeImageViews(std::span<const ImageView> views, const ImageFileOptions& options,
                     const std::filesystem::path& path, FileSystem& disk) {
  disk.writeAtomic(path, encodeExrViews(views, options, path));
}

void writeDeepImage(const DeepSamples& samples, const ImageMetadata& metadata, const ImageFileOptions& options,
                    const std::filesystem::path& path, FileSystem& disk) {
  disk.writeAtomic(path, encodeDeepExr(samples, metadata, options, path));
}

Image readImage(const std::filesystem::path& path, std::span<const std::string> planes, bool edges) {
  const std::vector<std::byte> data = readFile(path);
  if (looksLikeExr(data)) return decodeExr(data, path, planes, edges);
  if (!planes.empty()) throw Error(ErrorCode::kUnsupported, path, "channel " + planes[0], "is in an EXR only");
  if (looksLikePng(data)) return decodePng(data, path);
  throw Error(ErrorCode::kFormat, path, "byte 0", "the file is neither OpenEXR nor PNG");
}

void checkImage(const std::filesystem::path& path) {
  const std::vector<std::byte> data = readFile(path);
  if (looksLikeExr(data)) return checkExr(data, path);
  if (!looksLikePng(data)) throw Error(ErrorCode::kFormat, path, "byte 0", "the file is neither OpenEXR nor PNG");
  decodePng(data, path);
}

std::map<std::string, std::string> readImageText(const std::filesystem::path& path) {
  const std::vector<std::byte> data = readFile(path);
  if (looksLikeExr(data)) return decodeExrText(data, path);
  if (looksLikePng(data)) return decodePngText(data, path);
  throw Error(ErrorCode::kFormat, path, "byte 0", "the file is neither OpenEXR nor PNG");
}

}  // namespace kiln

// phantom:NAME:XxYxZ: a computed volume behind the interface of files. Voxels are a function of name, size and
// coordinates: any box can be read at any time, and a name always gives the same volume.
#include <charconv>
#include <limits>

#include "base/error.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "phantom/phantom.h"

namespace kiln {
namespace {

std::string knownNames() {
  std::string out;
  for (const phantom::PhantomKind& kind : phantom::phantomKinds()) {
    out += (out.empty() ? "" : ", ") + std::string(kind.name);
  }
  return out;
}

// Parses "XxYxZ"; empty if the text has another form.
std::optional<Extent3> extentIn(std::string_view text) {
  std::array<std::int64_t, 3> dims{};
  const char *at = text.data(), *const end = at + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    const auto [rest, status] = std::from_chars(at, end, dims[static_cast<std::size_t>(axis)]);
    if (status != std::errc() || rest == at) return std::nullopt;
    const bool last = axis == 2;
    if (last ? rest != end : rest == end || *rest != 'x') return std::nullopt;
    at = rest + 1;
  }
  return Extent3{dims[0], dims[1], dims[2]};
}

[[noreturn]] void refuse(const std::string& name, const std::string& what) {
  throw Error(ErrorCode::kUsage, inQuotes(name) + ": " + what);
}

std::string written(const Extent3& dims) {
  return std::to_string(dims.x) + "x" + std::to_string(dims.y) + "x" + std::to_string(dims.z);
}

Extent3 requireExtent(const std::string& name, std::string_view text, const phantom::PhantomKind& kind) {
  constexpr std::int64_t kMaxDim = 2147483647;
  const auto legal = [](std::int64_t n) { return n >= 1 && n <= kMaxDim; };
  const std::optional<Extent3> dims = extentIn(text);
  if (!dims || !legal(dims->x) || !legal(dims->y) || !legal(dims->z)) {
    refuse(name, "a phantom's size is three whole numbers from 1 to 2147483647, as in " + std::string(kPhantomScheme) +
                     std::string(kind.name) + ":" + written(kind.usual_dims));
  }
  const std::int64_t slice = dims->x * dims->y;
  if (slice > std::numeric_limits<std::int64_t>::max() / static_cast<std::int64_t>(sizeOf(kind.type)) / dims->z) {
    refuse(name, "the volume would have more than 2^63 bytes");
  }
  return *dims;
}

class PhantomSource : public VolumeSource {
 public:
  PhantomSource(const phantom::PhantomKind& kind, const Extent3& dims, SourceInfo info)
      : phantom_(kind, dims), info_(std::move(info)) {
    info_.geometry = phantom_.geometry();
    info_.type = kind.type;
  }

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override { phantom_.read(box, out); }

  // Changes only the world positions; the figure still fills the box of voxels.
  void setSpacing(const glm::dvec3& spacing) {
    for (int axis = 0; axis < 3; ++axis) {
      const double ratio = spacing[axis] / info_.geometry.world_from_index[axis][axis];
      info_.geometry.world_from_index[axis][axis] = spacing[axis];
      info_.geometry.world_from_index[3][axis] *= ratio;
    }
  }

 private:
  phantom::Phantom phantom_;
  SourceInfo info_;
};

}  // namespace

std::unique_ptr<VolumeSource> openPhantom(const std::filesystem::path& input, const SourceOptions& options) {
  const std::string name = input.string();
  const std::string_view rest = std::string_view(name).substr(kPhantomScheme.size());
  const std::size_t colon = rest.find(':');
  const phantom::PhantomKind* kind = phantom::findPhantom(rest.substr(0, colon));
  if (!kind) refuse(name, "there is no phantom of that name; there are " + knownNames());
  const Extent3 dims = requireExtent(name, colon == rest.npos ? std::string_view() : rest.substr(colon + 1), *kind);
  SourceInfo info;
  info.format = "phantom";
  info.files = {input};
  auto source = std::make_unique<PhantomSource>(*kind, dims, std::move(info));
  if (options.spacing) source->setSpacing(*options.spacing);
  return source;
}

}  // namespace kiln

#include "support/files/mrc_mgh_files.h"

#include "support/files/header_writer.h"

namespace kiln::test {

std::string mrcHeader(const Extent3& dims, int mode, bool big) {
  std::string out(1024, '\0');
  const auto n = [](std::int64_t value) { return static_cast<std::int32_t>(value); };
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = 4 * static_cast<std::size_t>(axis);
    putNumber(out, at, n(dims[axis]), big);
    putNumber(out, 28 + at, n(dims[axis]), big);
    putNumber(out, 40 + at, static_cast<float>(dims[axis]) * (axis == 0 ? 1.f : axis == 1 ? 1.5f : 4.f), big);
    putNumber(out, 52 + at, 90.f, big);
    putNumber(out, 64 + at, axis + 1, big);
  }
  putNumber(out, 12, mode, big);
  putNumber(out, 88, 1, big);
  out.replace(208, 8, big ? std::string("MAP \x11\x11\0\0", 8) : std::string("MAP \x44\x44\0\0", 8));
  return out;
}

std::string mrcFile(const ForeignVolume& volume, bool big, const HeaderChange& change) {
  constexpr int kModes[] = {0, 0, 6, 1, -1, -1, 2, -1};
  std::string header = mrcHeader(volume.dims, kModes[static_cast<int>(volume.type)], big);
  if (volume.type == VoxelType::u8) putNumber(header, 80, 255.f, big);
  if (change) change(header);
  return header + volume.stored(big);
}

std::string mghFile(const ForeignVolume& volume, std::int32_t frames, const HeaderChange& change) {
  constexpr std::int32_t kMghTypes[] = {0, -1, 10, 4, -1, 1, 3, -1};
  std::string out(284, '\0');
  const auto put = [&](std::size_t at, auto value) { putNumber(out, at, value, true); };
  put(0, 1);
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    put(4 + 4 * i, static_cast<std::int32_t>(axis == 2 ? volume.dims.z / frames : volume.dims[axis]));
    put(30 + 4 * i, 2.f + static_cast<float>(axis));
    put(78 + 4 * i, 10.f * static_cast<float>(axis + 1));
  }
  put(16, frames);
  put(20, kMghTypes[static_cast<int>(volume.type)]);
  put(28, std::int16_t{1});
  put(42 + 4, 1.f);  // x steps to the front
  put(54 + 8, 1.f);  // y steps up
  put(66, -1.f);     // z steps to the left
  if (change) change(out);
  return out + volume.stored(true);
}

}  // namespace kiln::test

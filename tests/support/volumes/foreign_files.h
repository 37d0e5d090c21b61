// Small foreign files whose every byte is known, for the tests of the readers. The writers share no code with the
// readers: bytes are put in order here by hand, and headers are plain text from the test.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "grid/coords.h"
#include "grid/voxel_type.h"
#include "ingest/source/volume_source.h"

namespace kiln::test {

/// A directory of its own for a test, removed with everything in it.
class ForeignFiles {
 public:
  ForeignFiles();
  ~ForeignFiles();
  ForeignFiles(const ForeignFiles&) = delete;
  ForeignFiles& operator=(const ForeignFiles&) = delete;
  const std::filesystem::path& directory() const { return directory_; }
  /// Writes `bytes` as `name` and returns its path.
  std::filesystem::path write(const std::string& name, std::string_view bytes) const;

 private:
  std::filesystem::path directory_;
};

/// The bytes of a file.
std::string bytesOf(const std::filesystem::path& path);

/// Voxels in the machine's order, every bit pattern that is a number among them.
struct ForeignVolume {
  Extent3 dims;
  VoxelType type;
  std::vector<std::byte> voxels;

  /// The bytes of a file in little- or big-endian order.
  std::string stored(bool big_endian) const;
  /// The voxels of a box, x fastest.
  std::vector<std::byte> box(const VoxelBox& box) const;
};

/// Random voxels, with the type's smallest and largest value first. shape: no NaN, so that equal means equal bytes.
ForeignVolume randomVolume(const Extent3& dims, VoxelType type, std::uint64_t seed);

std::string gzipped(std::string_view bytes);
std::string zlibbed(std::string_view bytes);
/// Without the head and the checksum of either.
std::string deflatedAlone(std::string_view bytes);

/// The size of volumes that are written and read back.
inline constexpr Extent3 kFewVoxels = {5, 4, 3};

inline constexpr VoxelType kAllTypes[] = {VoxelType::u8,  VoxelType::i8,  VoxelType::u16, VoxelType::i16,
                                          VoxelType::u32, VoxelType::i32, VoxelType::f32, VoxelType::f64};

/// All voxels of a source in one read, and `finish`. throws: Error as the source does.
std::vector<std::byte> readWhole(VolumeSource& source);
/// A failed expectation where the source does not give back exactly `volume`: as a whole, and by random boxes, or
/// slices and rows in their order. requires: nothing has been read from the source that `open` returns.
void expectReadsBack(const ForeignVolume& volume, const std::function<std::unique_ptr<VolumeSource>()>& open,
                     std::uint64_t seed);
/// The same of the file or folder at `path`.
void expectReadsBack(const ForeignVolume& volume, const std::filesystem::path& path, std::uint64_t seed);
/// A failed expectation where opening and reading `path` does not fail with `code` and one line that holds `part`.
void expectRefused(const std::filesystem::path& path, ErrorCode code, const std::string& part,
                   const SourceOptions& options = {});
/// Writes `bytes` as `victim` cut to every length and opens `open`: each cut must throw Error, and one that does not
/// must give exactly `volume` (a cut that takes nothing but an optional end of line).
void expectNoCutGoesUnnoticed(const ForeignVolume& volume, const ForeignFiles& files, const std::string& victim,
                              std::string_view bytes, const std::filesystem::path& open,
                              const SourceOptions& options = {});
/// Flips random bits in the first `header_bytes` of `bytes`; opening and reading must return or throw Error.
void expectBitFlipsAreHarmless(const ForeignFiles& files, const std::string& victim, std::string_view bytes,
                               std::size_t header_bytes, const std::filesystem::path& open, std::uint64_t seed,
                               const SourceOptions& options = {});

/// The real volumes, or empty where they are not here.
std::filesystem::path realData(const std::string& name);

}  // namespace kiln::test

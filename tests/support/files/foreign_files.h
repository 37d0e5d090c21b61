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
#include "support/system/expect_error.h"
#include "support/system/sanitized.h"

namespace kiln::test {

/// Writes a file in place of an older one. throws: std::runtime_error.
void writeAnew(const std::filesystem::path& path, std::string_view bytes);

/// A directory for a single test, removed with all its files.
class ForeignFiles {
 public:
  ForeignFiles();
  ~ForeignFiles();
  ForeignFiles(const ForeignFiles&) = delete;
  ForeignFiles& operator=(const ForeignFiles&) = delete;
  const std::filesystem::path& directory() const { return directory_; }
  /// Writes `bytes` to the file `name` and returns the path.
  std::filesystem::path write(const std::string& name, std::string_view bytes) const;

 private:
  std::filesystem::path directory_;
};

/// The bytes of a file.
std::string bytesOf(const std::filesystem::path& path);

/// Voxels in the machine's byte order, including every bit pattern that is a number.
struct ForeignVolume {
  Extent3 dims;
  VoxelType type;
  std::vector<std::byte> voxels;

  /// The bytes of a file in little- or big-endian order.
  std::string stored(bool big_endian) const;
  /// The voxels of a box, x fastest.
  std::vector<std::byte> box(const VoxelBox& box) const;
  /// A box as a volume.
  ForeignVolume part(const VoxelBox& box) const;
  /// The slices of these numbers, in this order, as a volume.
  ForeignVolume slices(const std::vector<std::int64_t>& numbers) const;
};

/// Random voxels; the type's smallest and largest value come first. shape: no NaN, so that equality means equal bytes.
ForeignVolume randomVolume(const Extent3& dims, VoxelType type, std::uint64_t seed);

std::string gzipped(std::string_view bytes);
std::string zlibbed(std::string_view bytes);
/// Returns the raw deflate stream, without the header and checksum of gzip or zlib.
std::string deflatedAlone(std::string_view bytes);

/// The voxels as decimal numbers, each with `separator` behind.
std::string decimalsOf(const ForeignVolume& volume, std::string_view separator);

/// Returns `text` with its first `from` replaced by `to`; a text without `from` fails the test.
std::string replaced(std::string text, std::string_view from, std::string_view to);

/// Size of volumes in round trips.
inline constexpr Extent3 kFewVoxels = {5, 4, 3};

inline constexpr VoxelType kAllTypes[] = {VoxelType::u8,  VoxelType::i8,  VoxelType::u16, VoxelType::i16,
                                          VoxelType::u32, VoxelType::i32, VoxelType::f32, VoxelType::f64};

/// Reads all voxels of a source in one call, then calls `finish`. throws: Error from the source.
std::vector<std::byte> readWhole(VolumeSource& source);
/// Expects that the source returns exactly `volume`: as a whole, and by random boxes, or by slices and rows in order.
/// requires: nothing has been read from the source that `open` returns.
void expectReadsBack(const ForeignVolume& volume, const std::function<std::unique_ptr<VolumeSource>()>& open,
                     std::uint64_t seed);
/// Expects that the file or folder at `path` returns exactly `volume`.
void expectReadsBack(const ForeignVolume& volume, const std::filesystem::path& path, std::uint64_t seed);
/// Expects that four threads reading boxes of the same source at once all read the voxels of `volume`.
/// requires: any box can be read from the source, and `volume` has at least 33 × 29 × 1 voxels.
void expectThreadsReadBack(const ForeignVolume& volume, VolumeSource& source);
/// Expects that opening and reading `path` fails with `code` and a single line that contains `part`.
void expectRefused(const std::filesystem::path& path, ErrorCode code, const std::string& part,
                   const SourceOptions& options = {});
/// Truncates `bytes` to every length, writes the result to `victim` and opens `open`. Each cut must throw Error or
/// return exactly `volume` (if only an optional end of line is missing).
void expectNoCutGoesUnnoticed(const ForeignVolume& volume, const ForeignFiles& files, const std::string& victim,
                              std::string_view bytes, const std::filesystem::path& open,
                              const SourceOptions& options = {});
/// Flips random bits in the first `header_bytes` of `bytes`, in `cases` files; opening and reading must return or throw
/// Error. Formats whose reader starts a process for each file take fewer cases.
void expectBitFlipsAreHarmless(const ForeignFiles& files, const std::string& victim, std::string_view bytes,
                               std::size_t header_bytes, const std::filesystem::path& open, std::uint64_t seed,
                               const SourceOptions& options = {}, int cases = casesOf(2000, 700));

/// Returns the path of a real volume, or an empty path if the data are not installed.
std::filesystem::path realData(const std::string& name);

}  // namespace kiln::test

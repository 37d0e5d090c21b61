// Numbers of 64 bits. Known because each file holds the numbers of a volume of 32 bits, with their sign in the upper
// half: a reader that takes the lower half only would notice no other number, so a number that does not fit is tested,
// too.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>

#include "support/files/foreign_files.h"
#include "support/files/header_writer.h"
#include "support/files/nifti_files.h"

namespace kiln::test {
namespace {

std::vector<std::int64_t> numbersOf(const ForeignVolume& volume) {
  std::vector<std::int64_t> out(volume.voxels.size() / 4);
  for (std::size_t i = 0; i < out.size(); ++i) {
    std::uint32_t bits;
    std::memcpy(&bits, &volume.voxels[4 * i], 4);
    out[i] = volume.type == VoxelType::i32 ? static_cast<std::int32_t>(bits) : std::int64_t{bits};
  }
  return out;
}

std::string wideBytes(const std::vector<std::int64_t>& numbers, bool big) {
  std::string out(8 * numbers.size(), '\0');
  for (std::size_t i = 0; i < numbers.size(); ++i) putNumber(out, 8 * i, numbers[i], big);
  return out;
}

std::string asText(const std::vector<std::int64_t>& numbers) {
  std::string out;
  for (const std::int64_t number : numbers) out += fmt::format("{}\n", number);
  return out;
}

// A volume of kFewVoxels with numbers of 64 bits, in each format.
class WideFiles {
 public:
  WideFiles(std::vector<std::int64_t> numbers, bool is_signed) : numbers_(std::move(numbers)), signed_(is_signed) {}

  std::vector<std::filesystem::path> write(const ForeignFiles& files) const {
    const std::string little = wideBytes(numbers_, false), big = wideBytes(numbers_, true);
    return {files.write("raw.nrrd", nrrd("raw") + big),
            files.write("gzip.nrrd", nrrd("gzip") + gzipped(big)),
            files.write("text.nrrd", nrrd("ascii") + asText(numbers_)),
            files.write("a.mha", metaImage() + little),
            files.write("a.vtk", legacyVtk() + big + "\n"),
            files.write("raw.vti", vti("", "appended\" offset=\"0\"/>", lengthOf(little) + little)),
            files.write("text.vti", vti("", "ascii\">" + asText(numbers_) + "</DataArray>", "")),
            files.write("packed.vti",
                        vti(" compressor=\"vtkZLibDataCompressor\"", "appended\" offset=\"0\"/>", packed(little))),
            nifti(files)};
  }

 private:
  std::string nrrd(const std::string& encoding) const {
    return fmt::format("NRRD0004\ntype: {}int64\ndimension: 3\nsizes: 5 4 3\nendian: big\nencoding: {}\n\n",
                       signed_ ? "" : "u", encoding);
  }
  std::string metaImage() const {
    return fmt::format(
        "ObjectType = Image\nNDims = 3\nDimSize = 5 4 3\nElementType = MET_{}LONG_LONG\n"
        "ElementDataFile = LOCAL\n",
        signed_ ? "" : "U");
  }
  std::string legacyVtk() const {
    return fmt::format(
        "# vtk DataFile Version 3.0\na title\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 5 4 3\n"
        "SPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 60\nSCALARS v vtktype{}int64\nLOOKUP_TABLE default\n",
        signed_ ? "" : "u");
  }
  std::string vti(const std::string& compressor, const std::string& array, const std::string& appended) const {
    return fmt::format(
        "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\"{}>\n<ImageData>\n"
        "<Piece Extent=\"0 4 0 3 0 2\"><PointData><DataArray type=\"{}Int64\" Name=\"v\" format=\"{}\n"
        "</PointData></Piece></ImageData>\n<AppendedData encoding=\"raw\">_{}</AppendedData></VTKFile>\n",
        compressor, signed_ ? "" : "U", array, appended);
  }
  static std::string lengthOf(const std::string& bytes) {
    std::string out(4, '\0');
    putNumber(out, 0, static_cast<std::uint32_t>(bytes.size()));
    return out;
  }
  // Blocks of 100 bytes cut numbers.
  static std::string packed(const std::string& bytes) {
    std::string blocks, table(12, '\0');
    putNumber(table, 0, static_cast<std::uint32_t>((bytes.size() + 99) / 100));
    putNumber(table, 4, std::uint32_t{100});
    putNumber(table, 8, static_cast<std::uint32_t>(bytes.size() % 100));
    for (std::size_t at = 0; at < bytes.size(); at += 100) {
      const std::string block = zlibbed(bytes.substr(at, 100));
      table += lengthOf(block);
      blocks += block;
    }
    return table + blocks;
  }
  std::filesystem::path nifti(const ForeignFiles& files) const {
    NiftiHeader header;
    header.datatype = signed_ ? 1024 : 1280, header.bitpix = 64;
    const std::string voxels = wideBytes(numbers_, false);
    const Bytes bytes = niftiFile(header, Bytes(voxels.begin(), voxels.end()));
    return files.write("a.nii", std::string(bytes.begin(), bytes.end()));
  }

  std::vector<std::int64_t> numbers_;
  bool signed_;
};

TEST(IngestWideIntegers, NumbersThatFit_areRead) {
  const ForeignFiles files;
  for (const VoxelType type : {VoxelType::i32, VoxelType::u32}) {
    const ForeignVolume volume = randomVolume(kFewVoxels, type, 711);
    for (const auto& path : WideFiles(numbersOf(volume), type == VoxelType::i32).write(files)) {
      SCOPED_TRACE(path.filename());
      expectReadsBack(volume, path, 712);
    }
  }
}

// Known: the lower half of 2^32 is 0, a legal number.
TEST(IngestWideIntegers, NumberThatDoesNotFit_isAnErrorWithItsSlice) {
  const ForeignFiles files;
  std::vector<std::int64_t> numbers(60, 7);
  numbers[25] = std::int64_t{1} << 32;
  for (const auto& path : WideFiles(numbers, true).write(files)) {
    SCOPED_TRACE(path.filename());
    expectRefused(path, ErrorCode::kFormat, "slice 1");
    expectRefused(path, ErrorCode::kFormat, "4294967296");
  }
}

}  // namespace
}  // namespace kiln::test

// A volume of 128 MB of voxels is drawn within 32 MB, half of them image, and the picture equals the picture drawn with
// 2 GB: the promise in the first line of the README. Known from the picture with more memory than the volume needs, and
// from the peak memory counted by the operating system.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/file/file.h"
#include "support/files/amira_files.h"
#include "support/files/dicom_files.h"
#include "support/files/foreign_files.h"
#include "support/files/hdf5_files.h"
#include "support/files/mrc_mgh_files.h"
#include "support/files/nifti_files.h"
#include "support/files/npy_files.h"
#include "support/files/packed_bytes.h"
#include "support/files/picture_files.h"
#include "support/files/tiff_files.h"
#include "support/files/vgi_files.h"
#include "support/files/vti_files.h"
#include "support/files/zarr_files.h"
#include "support/system/run_tool.h"
#include "support/system/sanitized.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

namespace fs = std::filesystem;

nlohmann::json statisticsIn(const fs::path& path) { return nlohmann::json::parse(readTextFile(path)); }

TEST(MemoryBudget, ALargeHeadDrawsInThirtyTwoMegabytes) {
  const fs::path input = fs::path(KILN_TEST_DATA_DIR) / "vhm_head_512x512x245_i16le.nrrd";
  if (!fs::exists(input)) GTEST_SKIP() << input << " is not here; rendering beyond memory is not tested on real data";
  const fs::path directory = freshDirectory("memory_budget");
  const fs::path store = directory / "head.kiln";
  ASSERT_EQ(runTool({"convert", input, store}).exit_code, 0);
  const auto draw = [&](const std::string& memory) {
    const fs::path picture = directory / (memory + ".exr");
    const ToolResult result = runTool({"render", store, "-o", picture, "--size", "1024x1024", "--exr-type", "float",
                                       "--memory", memory, "--stats", directory / (memory + ".json")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return readFile(picture);
  };
  EXPECT_EQ(draw("32M"), draw("2G"));
  const nlohmann::json statistics = statisticsIn(directory / "32M.json");
  const std::uint64_t budget = 32ull << 20;
  EXPECT_LE(statistics["memory"]["peak_cache_bytes"].get<std::uint64_t>() +
                statistics["memory"]["framebuffer_bytes"].get<std::uint64_t>() +
                statistics["memory"]["peak_slabs_bytes"].get<std::uint64_t>(),
            budget);
  EXPECT_EQ(statistics["memory"]["budget_bytes"], budget);
  std::printf("budget 32 MiB: peak cache %.1f MiB, peak resident %.1f MiB, image %.1f MiB\n",
              statistics["memory"]["peak_cache_bytes"].get<double>() / 1048576,
              statistics["memory"]["peak_rss_bytes"].get<double>() / 1048576,
              statistics["memory"]["framebuffer_bytes"].get<double>() / 1048576);
  // A sanitizer keeps freed memory and shadows every byte: its resident memory is meaningless.
  if (!kSanitized) {
    EXPECT_LT(statistics["memory"]["peak_rss_bytes"], budget + (80ull << 20));
  }
  // Each visible brick is read once, however small the budget.
  EXPECT_EQ(statistics["bricks"]["read"], statisticsIn(directory / "2G.json")["bricks"]["read"]);
  fs::remove_all(directory);
}

// Slabs of several volumes have sums for each thread.
TEST(MemoryBudget, SumsOfSeveralVolumesAreInTheAccount) {
  const fs::path directory = freshDirectory("sums");
  const fs::path store = directory / "head.kiln";
  ASSERT_EQ(runTool({"convert", "phantom:head:64x64x64", store}).exit_code, 0);
  const ToolResult result =
      runTool({"render", store, "-o", directory / "p.exr", "--size", "256x256", "--tf", "fire", "--add", store, "--aov",
               "depth,normal", "--threads", "1", "--stats", directory / "s.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json memory = statisticsIn(directory / "s.json")["memory"];
  EXPECT_LE(memory["peak_slabs_bytes"], memory["slabs_bytes"]);
  EXPECT_GE(memory["peak_slabs_bytes"].get<double>(), 0.3 * memory["slabs_bytes"].get<double>());
  fs::remove_all(directory);
}

// Every kind of picture and conversion against budgets. The limit is the budget plus 50 MiB for the program itself and
// the allocator's reserve, as counted by the system. From `least_mib` on, a row must succeed; below, it must be refused
// in one line.
struct BudgetRow {
  std::string name;
  int least_mib;                       // the smallest sufficient value of kBudgetsMib
  std::vector<std::string> arguments;  // IN/ is replaced by the test's folder
};

constexpr int kBudgetsMib[] = {16, 24, 32, 48, 64, 128, 512, 1500};
constexpr double kOwnMib = 50;
// Less than any row needs.
constexpr int kTooLittleMib = 1;

BudgetRow rendered(const char* name, int least_mib, std::vector<std::string> options, const char* file = "IN/o.exr",
                   const char* input = "IN/head.kiln") {
  options.insert(options.begin(), {"render", input, "-o", file, "--tf", "ct-bone-and-skin"});
  return {name, least_mib, options};
}

BudgetRow threeSizes(const char* name, int least_mib, std::vector<std::string> options) {
  options.insert(options.end(), {"--add", "IN/edge64.kiln", "--add", "IN/edge32.kiln"});
  return rendered(name, least_mib, options, "IN/o.exr", "IN/edge128.kiln");
}

BudgetRow converted(const char* name, int least_mib, const char* input, std::vector<std::string> options = {}) {
  options.insert(options.begin(), {"convert", input, "IN/c.kiln", "--overwrite"});
  return {name, least_mib, options};
}

// Uses more threads than the budget has room for.
BudgetRow compressed(const std::string& compression, const std::string& type, int least_mib,
                     const std::string& size = "900x900", std::vector<std::string> options = {}) {
  options.insert(options.end(), {"--size", size, "--samples", "1", "--threads", "8", "--exr-type", type,
                                 "--compression", compression});
  BudgetRow out = rendered("", least_mib, options);
  out.name = "EXR " + compression + " " + type;
  return out;
}

// Least budgets: drawing buffers of the threads take 3 MiB, a brick of 64³ voxels 2 MiB, a brick of 128³ 10 MiB. The
// image and its planes take the rest: 16 to 24 bytes a pixel, for each eye, band, face or tile; a deep image 24 samples
// a pixel.
std::vector<BudgetRow> pictureRows() {
  return {
      rendered("pixel lattice", 16, {"--size", "500x500", "--samples", "1"}),
      rendered("four rays a pixel", 16, {"--size", "400x400", "--samples", "4"}),
      rendered("voxel lattice", 16, {"--size", "400x400", "--lattice", "voxel", "--samples", "4"}),
      rendered("16 samples", 16, {"--size", "120x120", "--samples", "16"}),
      rendered("depth and normals", 16, {"--size", "400x400", "--samples", "1", "--aov", "depth,normal"}),
      rendered("16-bit PNG", 24, {"--size", "900x900", "--samples", "1", "--png-bits", "16"}, "IN/o.png"),
      rendered("annotated EXR", 24,
               {"--size", "400x400", "--samples", "1", "--scale-bar", "--box", "--legend", "--axes", "--text", "text"}),
      rendered("annotated PNG", 24,
               {"--size", "400x400", "--samples", "1", "--scale-bar", "--box", "--legend", "--axes", "--text", "text"},
               "IN/o.png"),
      rendered("TIFF", 24, {"--size", "900x900", "--samples", "1"}, "IN/o.tif"),
      rendered("JPEG", 32, {"--size", "900x900", "--samples", "1", "--background", "white"}, "IN/o.jpg"),
      rendered("stereo EXR", 16, {"--size", "250x250", "--samples", "1", "--stereo", "both", "--interocular", "20"}),
      rendered("stereo PNG", 16, {"--size", "250x250", "--samples", "1", "--stereo", "both", "--interocular", "20"},
               "IN/o.png"),
      rendered("panorama", 16, {"--size", "240x120", "--projection", "equirectangular"}),
      rendered("deep", 24, {"--size", "150x150", "--deep"}),
      rendered("two volumes", 24, {"--size", "150x150", "--samples", "1", "--add", "IN/head.kiln"}),
      rendered(
          "shadows and ambient occlusion", 34,
          {"--size", "200x200", "--samples", "1", "--light", "dir:1,1,1", "--shadows", "--ambient-occlusion", "1"}),
      rendered("partial image", 16, {"--size", "200x200", "--part", "1/4"}),
      rendered("sequence", 16, {"--size", "250x250", "--turntable", "3", "--samples", "1"}, "IN/o_#.png"),
      rendered("checkpoint", 32, {"--size", "900x900", "--samples", "1", "--checkpoint"}),
      {"projected values", 16, {"render", "IN/head.kiln", "-o", "IN/o.exr", "--mode", "mip", "--size", "500x500"}},
      {"projected values of four volumes",
       96,
       {"render", "IN/head.kiln", "-o", "IN/o.exr", "--mode", "average", "--size", "1200x1200", "--samples", "1",
        "--add", "IN/head.kiln", "--add", "IN/head.kiln", "--add", "IN/head.kiln"}},
      {"table of 4096 points",
       16,
       {"render", "IN/head.kiln", "-o", "IN/o.exr", "--size", "100x100", "--tf", "IN/points.json"}},
      {"slice", 16, {"slice", "IN/head.kiln", "-o", "IN/o.png"}},
      {"slice, sheet", 16, {"slice", "IN/head.kiln", "-o", "IN/o.png", "--sheet"}},
      {"gallery", 24, {"gallery", "IN/head.kiln", "-o", "IN/o.png", "--thumbnail", "64"}},
      compressed("dwab", "float", 48),
      compressed("piz", "half", 32),
  };
}

// Commands on a store of so many bricks that their index is the largest buffer: 5 MiB for 32,767 bricks.
std::vector<BudgetRow> manyBricksRows() {
  const std::string store = "IN/thin.kiln";
  return {
      {"render, many bricks", 16, {"render", store, "-o", "IN/o.png", "--size", "64x64", "--tf", "grayscale"}},
      {"means, many thin bricks", 16, {"render", store, "-o", "IN/o.png", "--size", "64x64", "--mode", "average"}},
      {"slice, many bricks", 16, {"slice", store, "-o", "IN/o.png", "--axis", "x"}},
      {"export, many bricks", 16, {"export", store, "IN/o.vdb", "--overwrite"}},
      {"export NRRD, many bricks", 16, {"export", store, "IN/o.nrrd", "--overwrite"}},
      {"info, many bricks", 16, {"info", store}},
      {"verify, many bricks", 16, {"verify", store}},
      {"split, many bricks", 16, {"split", store, "-o", "IN/thin_#.kiln", "--parts", "2", "--tf", "grayscale"}},
      {"convert, many bricks",
       16,
       {"convert", "IN/thin.raw", "IN/c.kiln", "--overwrite", "--dims", "2097152,1,1", "--type", "u8"}},
  };
}

// A picture of 36 bytes a pixel in compressions that buffer much of the picture, with more threads than the memory
// allows.
std::vector<BudgetRow> compressedRows() {
  std::vector<BudgetRow> out;
  for (const char* const type : {"half", "float"}) {
    for (const char* const compression : {"none", "rle", "zips", "zip", "piz", "dwaa", "dwab"}) {
      out.push_back(compressed(compression, type, 512, "2000x2000", {"--zoom", "0.5", "--aov", "depth,normal"}));
    }
  }
  return out;
}

// Pictures and volumes that fill larger budgets.
std::vector<BudgetRow> largePictureRows() {
  return {
      rendered("16 samples, large", 64, {"--size", "1500x1500", "--samples", "16", "--zoom", "0.2"}),
      rendered("stereo EXR, large", 128,
               {"--size", "1500x1500", "--zoom", "0.5", "--samples", "1", "--stereo", "both", "--interocular", "20"}),
      rendered("panorama, large", 48, {"--size", "1600x800", "--projection", "equirectangular"}),
      rendered("deep, large", 512, {"--size", "600x600", "--zoom", "0.5", "--deep"}),
      rendered("two volumes, large", 128, {"--size", "900x900", "--samples", "1", "--add", "IN/large.kiln"}),
      rendered("poster", 512, {"--size", "4000x4000", "--zoom", "0.2", "--samples", "1", "--background", "1,0.5,0"}),
      {"maxima, large bricks", 24, {"render", "IN/large.kiln", "-o", "IN/o.exr", "--mode", "mip", "--size", "500x500"}},
      {"means, many bricks",
       24,
       {"render", "IN/huge.kiln", "-o", "IN/o.exr", "--mode", "average", "--size", "400x400", "--level", "0"}},
      {"maxima, many threads",
       32,
       {"render", "IN/noise.kiln", "-o", "IN/o.exr", "--mode", "mip", "--size", "500x500", "--level", "0", "--threads",
        "16"}},
      {"rays, many bricks",
       24,
       {"render", "IN/huge.kiln", "-o", "IN/o.exr", "--tf", "grayscale", "--lattice", "ray", "--size", "400x400",
        "--level", "0"}},
      {"slice, large bricks", 16, {"slice", "IN/large.kiln", "-o", "IN/o.png"}},
      threeSizes("bricks of three sizes, large", 128, {"--size", "900x900", "--samples", "1", "--level", "0"}),
  };
}

// Least budgets: a thread holds 38 MiB for bricks of 128³ voxels of 16 bits, 5 MiB for bricks of 64³, and 74 MiB for
// bricks of 128³ floats. An OpenVDB grid is in memory whole, besides a thread's memory: 17 MiB for the small grid, 99
// MiB for the large grid.
std::vector<BudgetRow> conversionRows() {
  const std::vector<std::string> raw = {"--dims", "160,160,160", "--type", "u16"};
  return {
      converted("convert computed", 48, "phantom:head:160x160x160"),
      converted("convert raw", 48, "IN/noise.raw", raw),
      converted("convert raw, small bricks", 16, "IN/noise.raw",
                {"--dims", "160,160,160", "--type", "u16", "--brick-size", "64"}),
      converted("convert raw, tiny bricks", 16, "IN/small.raw",
                {"--dims", "64,64,64", "--type", "u16", "--brick-size", "8", "--threads", "8"}),
      converted("convert gzip NRRD", 48, "IN/packed.nrrd"),
      converted("convert OpenVDB", 128, "IN/head.vdb"),
      converted("convert OpenVDB of a pipe", 128, "IN/piped.vdb"),
      // A store is made first, within the same budget.
      rendered("foreign raw", 48, {"--size", "200x200", "--dims", "160,160,160", "--type", "u16"}, "IN/o.exr",
               "IN/noise.raw"),
      rendered("foreign OpenVDB", 128, {"--size", "200x200"}, "IN/o.exr", "IN/head.vdb"),
      {"export", 24, {"export", "IN/head.kiln", "IN/o.vdb", "--overwrite"}},
      {"export NRRD", 16, {"export", "IN/head.kiln", "IN/o.nrrd", "--overwrite"}},
      {"export gzip NIfTI", 16, {"export", "IN/head.kiln", "IN/o.nii.gz", "--overwrite"}},
      {"export OME-Zarr", 32, {"export", "IN/head.kiln", "IN/o.zarr", "--overwrite"}},
      {"export slices", 16, {"export", "IN/head.kiln", "IN/o_###.tif", "--overwrite"}},
  };
}

std::vector<BudgetRow> moreConversionRows() {
  const std::vector<std::string> spacing = {"--spacing", "1,1,1"};
  return {
      converted("convert computed, large", 48, "phantom:head:288x288x288"),
      converted("convert NRRD", 48, "IN/noise.nrrd"),
      converted("convert MetaImage", 48, "IN/noise.mha"),
      converted("convert zlib MetaImage", 48, "IN/packed.mha"),
      converted("convert NIfTI", 48, "IN/noise.nii"),
      converted("convert gzip NIfTI", 48, "IN/packed.nii.gz"),
      converted("convert NumPy", 48, "IN/noise.npy", spacing),
      converted("convert NumPy in Fortran order", 48, "IN/fortran.npy", spacing),
      converted("convert Zarr", 48, "IN/noise.zarr", spacing),
      converted("convert bzip2 NRRD", 48, "IN/bzip2.nrrd"),
      converted("convert MRC", 48, "IN/noise.mrc"),
      converted("convert gzip MGH", 48, "IN/packed.mgz"),
      converted("convert AmiraMesh", 48, "IN/noise.am"),
      converted("convert VGI", 48, "IN/noise.vgi"),
      converted("convert VTK", 48, "IN/noise.vti"),
      converted("convert zlib VTK", 48, "IN/packed.vti"),
      converted("convert legacy VTK", 48, "IN/noise.vtk"),
      converted("convert PNG stack", 48, "IN/pictures", spacing),
#ifdef KILN_TEST_OPENJPEG
      converted("convert JPEG 2000 stack", 24, "IN/jpeg2000", spacing),
#endif
#ifdef KILN_TEST_HDF5
      converted("convert HDF5", 48, "IN/noise.h5:/contiguous", spacing),
      converted("convert deflated HDF5", 48, "IN/noise.h5:/chunked", spacing),
#endif
      converted("convert TIFF stack", 48, "IN/tiffs", spacing),
      converted("convert multi-page TIFF", 48, "IN/noise.tif", spacing),
      // An unknown spacing is a note, except when the budget is refused.
      converted("convert deflated TIFF", 48, "IN/packed.tif"),
      converted("convert DICOM", 48, "IN/slices"),
      converted("convert JPEG 2000 DICOM", 48, "IN/packed_slices"),
      converted("convert large OpenVDB", 512, "IN/large.vdb"),
      {"dry run of OpenVDB", 128, {"render", "IN/large.vdb", "--dry-run"}},
  };
}

class BudgetTable : public ::testing::Test {
 protected:
  void SetUp() override {
    if (kSanitized) GTEST_SKIP() << "a sanitizer shadows every byte, and its resident memory says nothing";
    directory_ = freshDirectory("budget_table");
  }
  void TearDown() override { fs::remove_all(directory_); }

  // Makes the files of pictureRows(), manyBricksRows() and conversionRows().
  void makeUsualFiles() const {
    made({"convert", "phantom:head:160x160x160", in("head.kiln"), "--brick-size", "64"});
    made({"export", in("head.kiln"), in("head.vdb")});
    // A file written to a pipe differs in one byte: the file has no offsets of its grids.
    std::string piped = bytesOf(in("head.vdb"));
    ASSERT_EQ(piped[kVdbHasPlaces], 1);
    piped[kVdbHasPlaces] = 0;
    writeText(in("piped.vdb"), piped);
    std::string points;
    for (int i = 0; i < 4096; ++i)
      points += fmt::format(R"({}{{"value": {}, "color": [0.1, 0.2, 0.3], "opacity": 0.5}})", i > 0 ? "," : "", i);
    writeText(in("points.json"), "{\"points\": [" + points + "]}");
    makeForeignFiles();
    writeThin();
    made({"convert", in("thin.raw"), in("thin.kiln"), "--dims", "2097152,1,1", "--type", "u8"});
  }

  // A sparse file of a single value.
  void writeThin() const {
    writeText(in("thin.raw"), "");
    fs::resize_file(in("thin.raw"), 2 << 20);
  }

  void check(const std::vector<BudgetRow>& rows, const std::vector<int>& budgets_mib) const {
    for (const BudgetRow& row : rows) {
      for (const int budget_mib : budgets_mib) check(row, budget_mib);
    }
  }

  void check(const BudgetRow& row, int budget_mib) const {
    const ToolResult result = run(row, budget_mib);
    const double peak_mib = static_cast<double>(result.peak_resident_bytes) / (1 << 20);
    const std::string place = fmt::format("{} in {} MiB: {}", row.name, budget_mib, result.err);
    EXPECT_LE(peak_mib, budget_mib + kOwnMib) << place;
    if (budget_mib >= row.least_mib) {
      EXPECT_EQ(result.exit_code, 0) << place;
    } else {
      EXPECT_EQ(result.exit_code, 1) << place;
      EXPECT_NE(result.err.find("--memory"), std::string::npos) << place;
      EXPECT_EQ(result.errorLines().size(), 1u) << place;
    }
    fmt::print("{:<28} {:>4} MiB: {}, peak {:.1f} MiB\n", row.name, budget_mib,
               result.exit_code == 0 ? "done" : "refused", peak_mib);
  }

  void makeLargeStores() const {
    // Bricks of 128 voxels use large pages, and the process keeps some of these pages.
    made({"convert", "phantom:head:288x288x288", in("large.kiln")});
    made({"convert", "phantom:head:512x512x512", in("huge.kiln")});
    made({"export", in("large.kiln"), in("large.vdb")});
    writeText(in("noise320.raw"), randomVolume({320, 320, 320}, VoxelType::u16, 2).stored(false));
    made({"convert", in("noise320.raw"), in("noise.kiln"), "--dims", "320,320,320", "--type", "u16"});
    made({"convert", in("large.vdb"), in("large.vdb.kiln")});
  }

  void makeStoresOfThreeSizes(const std::string& extent) const {
    for (const char* const edge : {"32", "64", "128"})
      made({"convert", "phantom:head:" + extent, in(std::string("edge") + edge + ".kiln"), "--brick-size", edge});
  }

  void makeMoreForeignFiles() const {
    const ForeignVolume volume = noise();
    const std::string voxels = volume.stored(false);
    writeText(in("noise.nrrd"), nrrdHeader("raw") + voxels);
    const std::string meta = "ObjectType = Image\nNDims = 3\nDimSize = 160 160 160\nElementType = MET_USHORT\n";
    writeText(in("noise.mha"), meta + "ElementDataFile = LOCAL\n" + voxels);
    writeText(in("packed.mha"), meta + "CompressedData = True\nElementDataFile = LOCAL\n" + zlibbed(voxels));
    NiftiHeader header;
    header.dim = {3, kEdge, kEdge, kEdge, 1, 1, 1, 1};
    header.datatype = 512;
    header.bitpix = 16;
    const Bytes nifti = niftiFile(header, Bytes(voxels.begin(), voxels.end()));
    writeBytes(in("noise.nii"), nifti);
    writeBytes(in("packed.nii.gz"), gzipped(nifti));
    writeText(in("noise.npy"), npyFile(volume));
    writeText(in("fortran.npy"), npyFile(volume, {.fortran_order = true}));
    ZarrLayout chunks{.codec = ZarrCodec::kBlosc};
    chunks.axes = {{'z', 64}, {'y', 64}, {'x', 64}};
    writeZarr(in("noise.zarr"), volume, chunks);
    writeText(in("bzip2.nrrd"), nrrdHeader("bzip2") + bzipped(voxels));
    writeText(in("noise.mrc"), mrcFile(volume));
    writeText(in("packed.mgz"), gzipped(mghFile(volume)));
    writeText(in("noise.am"), amiraFile(volume));
    writeText(in("noise.vgi"), vgiHeader(volume.dims, "unsigned integer", 16));
    writeText(in("a.vol"), voxels);
    writeText(in("noise.vti"), vtiFile(volume));
    VtiLayout blocks;
    blocks.codec = 1, blocks.block_bytes = 32768;
    writeText(in("packed.vti"), vtiFile(volume, blocks));
    writeText(in("noise.vtk"),
              "# vtk DataFile Version 3.0\na title\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 160 160 160\n"
              "SPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 4096000\nSCALARS v unsigned_short\nLOOKUP_TABLE default\n" +
                  volume.stored(true) + "\n");
#ifdef KILN_TEST_HDF5
    Hdf5File arrays(in("noise.h5"));
    arrays.add("/contiguous", volume);
    arrays.add("/chunked", volume, {.chunk = {64, 64, 64}, .deflate = 1});
#endif
    makeSlices(volume, voxels);
  }

  fs::path in(const std::string& name) const { return directory_ / name; }

 private:
  static void made(const std::vector<std::string>& arguments) {
    const ToolResult result = runTool(arguments);
    ASSERT_EQ(result.exit_code, 0) << result.err;
  }

  ToolResult run(const BudgetRow& row, int budget_mib) const {
    // Stores beside foreign files.
    for (const char* const name : {"noise.raw.kiln", "head.vdb.kiln"}) fs::remove_all(in(name));
    std::vector<std::string> arguments = row.arguments;
    for (std::string& argument : arguments)
      if (argument.starts_with("IN/")) argument = in(argument.substr(3)).string();
    arguments.insert(arguments.end(), {"--memory", std::to_string(budget_mib) + "M"});
    return runTool(arguments, {.fresh = true});
  }

  // Noise does not compress, so files and bricks have their largest size.
  static ForeignVolume noise() { return randomVolume({kEdge, kEdge, kEdge}, VoxelType::u16, 1); }
  static std::string nrrdHeader(const std::string& encoding) {
    return "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 160 160 160\nendian: little\nencoding: " + encoding + "\n\n";
  }

  void makeForeignFiles() const {
    const std::string voxels = noise().stored(false);
    writeText(in("noise.raw"), voxels);
    writeText(in("packed.nrrd"), nrrdHeader("gzip") + gzipped(voxels));
    writeText(in("small.raw"), voxels.substr(0, std::size_t{2} * 64 * 64 * 64));
  }

  void makeSlices(const ForeignVolume& volume, const std::string& voxels) const {
    for (const char* const folder : {"tiffs", "pictures", "slices", "packed_slices"}) fs::create_directory(in(folder));
    for (int z = 0; z < kEdge; ++z) writeText(in("pictures") / (std::to_string(z) + ".png"), pngSlice(volume, z));
#ifdef KILN_TEST_OPENJPEG
    fs::create_directory(in("jpeg2000"));
    for (int z = 0; z < kEdge / 4; ++z)
      writeText(in("jpeg2000") / (std::to_string(z) + ".jp2"), jpeg2000Slice(volume, z));
#endif
    TiffLayout layout;
    writeTiff(in("noise.tif"), volume, 0, kEdge, layout);
    for (int z = 0; z < kEdge; ++z) writeTiff(in("tiffs") / (std::to_string(z) + ".tif"), volume, z, z + 1);
    layout.compression = 8;
    writeTiff(in("packed.tif"), volume, 0, kEdge, layout);
    DicomSpec spec;
    spec.rows = spec.columns = kEdge;
    spec.is_signed = false;
    constexpr std::size_t kSliceBytes = std::size_t{2} * kEdge * kEdge;
    for (int z = 0; z < kEdge; ++z) {
      spec.position = "0\\0\\" + std::to_string(z);
      spec.pixel_bytes = voxels.substr(static_cast<std::size_t>(z) * kSliceBytes, kSliceBytes);
      const std::string file = dicomFile(spec), name = std::to_string(z) + ".dcm";
      writeText(in("slices") / name, file);
      writeText(in("packed_slices") / name, file);
      compressDicom(in("packed_slices") / name, DicomCodec::kJpeg2000);
    }
  }

  static constexpr int kEdge = 160;
  static constexpr std::size_t kVdbHasPlaces = 20;
  fs::path directory_;
};

// Tables of 16 million bricks are refused before any read or write, with the memory that suffices.
TEST_F(BudgetTable, ATableOfTooManyBricksIsRefused) {
  writeThin();
  fs::resize_file(in("thin.raw"), 1ull << 30);
  const std::vector<std::string> input = {"convert",        in("thin.raw"), in("c.kiln"), "--dims",
                                          "1073741824,1,1", "--type",       "u8"};
  for (const bool dry : {false, true}) {
    std::vector<std::string> arguments = input;
    arguments.insert(arguments.end(), {"--memory", "64M"});
    if (dry) arguments.push_back("--dry-run");
    const ToolResult result = runTool(arguments, {.fresh = true});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_LE(static_cast<double>(result.peak_resident_bytes) / (1 << 20), 64 + kOwnMib);
    ASSERT_EQ(result.errorLines().size(), 1u) << result.err;
    for (const char* const text :
         {"16777215 bricks take 1.50 GiB", "(allowed: 64.0 MiB)", "give --memory 15", "--brick-size larger than 128"})
      EXPECT_NE(result.err.find(text), std::string::npos) << result.err;
  }
  EXPECT_FALSE(fs::exists(in("c.kiln")));
}

// Bricks of one size leave gaps in the heap into which bricks of the other sizes do not fit.
TEST_F(BudgetTable, BricksOfThreeSizesInOnePictureStayWithinIt) {
  makeStoresOfThreeSizes("288x288x288");
  const std::vector<std::string> view = {"--size", "300x300", "--samples", "1", "--level", "0"};
  check({threeSizes("bricks of three sizes", 80, view)}, {64, 80, 90, 100, 157});
}

// Each row succeeds at its least budget, so that refusals cannot hide failures, and refuses a megabyte in one line.
TEST_F(BudgetTable, UsualPicturesAndConversions_succeedWithinTheLeastBudgetAndRefuseAMegabyte) {
  makeUsualFiles();
  for (const std::vector<BudgetRow>& rows : {pictureRows(), manyBricksRows(), conversionRows()}) {
    for (const BudgetRow& row : rows) {
      for (const int budget_mib : {kTooLittleMib, row.least_mib}) check(row, budget_mib);
    }
  }
}

TEST_F(BudgetTable, NightlyEveryPictureAndConversionStaysWithinIt) {
  makeUsualFiles();
  makeLargeStores();
  makeStoresOfThreeSizes("512x512x512");
  makeMoreForeignFiles();
  const std::vector<int> budgets_mib(std::begin(kBudgetsMib), std::end(kBudgetsMib));
  for (const std::vector<BudgetRow>& rows :
       {pictureRows(), largePictureRows(), compressedRows(), manyBricksRows(), conversionRows(), moreConversionRows()})
    check(rows, budgets_mib);
}

}  // namespace
}  // namespace kiln::test

// TIFF stacks. Known because libtiff wrote the files from random voxels, or, for the real stack, because a NRRD file
// holds equal slices.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <random>
#include <thread>

#include "base/error.h"
#include "convert/convert.h"
#include "export/vdb/export_vdb.h"
#include "ingest/open_source.h"
#include "ingest/slice_directory.h"
#include "store/store_reader.h"
#include "support/files/foreign_files.h"
#include "support/files/tiff_files.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

std::vector<TiffLayout> layouts() {
  std::vector<TiffLayout> out;
  for (const auto& [rows, tile] : {std::pair{0, 0}, {1, 0}, {5, 0}, {0, 16}, {0, 32}}) {
    for (const int compression : {1, 5, 8, 32773}) {
      TiffLayout layout;
      layout.strip_rows = rows;
      layout.tile = tile;
      layout.compression = compression;
      out.push_back(layout);
    }
  }
  return out;
}

TEST(IngestTiff, EveryTypeOrderAndLayoutGivesTheValuesBack) {
  const ForeignFiles files;
  std::uint64_t seed = 1;
  for (const VoxelType type : kAllTypes) {
    const ForeignVolume volume = randomVolume(kStackDims, type, seed);
    for (TiffLayout layout : layouts()) {
      layout.big_endian = seed % 2 == 0;
      layout.big_tiff = seed % 3 == 0;
      SCOPED_TRACE(testing::Message() << nameOf(type) << " strip " << layout.strip_rows << " tile " << layout.tile
                                      << " compression " << layout.compression << " big " << layout.big_endian);
      const fs::path path = files.directory() / "a.tif";
      writeTiff(path, volume, 0, kStackDims.z, layout);
      expectReadsBack(volume, path, seed++);
    }
  }
}

TEST(IngestTiff, PredictorsAreUndone) {
  const ForeignFiles files;
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16, VoxelType::i32, VoxelType::f32}) {
    const ForeignVolume volume = randomVolume(kStackDims, type, 7);
    for (const bool big : {false, true}) {
      if (big && isFloating(type)) continue;  // libtiff 4.5 writes these files incorrectly
      TiffLayout layout;
      layout.compression = 8;
      layout.predictor = isFloating(type) ? 3 : 2;
      layout.big_endian = big;
      writeTiff(files.directory() / "a.tif", volume, 0, kStackDims.z, layout);
      expectReadsBack(volume, files.directory() / "a.tif", 7);
    }
  }
}

TEST(IngestTiff, WhiteIsZeroTakesTheValuesAsTheyAre) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 8);
  TiffLayout layout;
  layout.photometric = 0;
  writeTiff(files.directory() / "a.tif", volume, 0, kStackDims.z, layout);
  expectReadsBack(volume, files.directory() / "a.tif", 8);
}

TEST(IngestTiff, TagsForViewers_MoveNoValueAndAreNoted) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 8);
  const fs::path path = files.directory() / "a.tif";
  const auto noteThatHas = [&](const std::string& text) {
    const std::vector<std::string> notes = openSource(path)->info().notes;
    return std::count_if(notes.begin(), notes.end(), [&](const std::string& n) { return n.find(text) != n.npos; });
  };
  TiffLayout layout;
  for (const int orientation : {1, 2, 3, 4, 5, 8}) {
    layout.orientation = orientation;
    writeTiff(path, volume, 0, kStackDims.z, layout);
    expectReadsBack(volume, path, 8);
    EXPECT_EQ(noteThatHas("have Orientation " + std::to_string(orientation)), orientation == 1 ? 0 : 1);
    EXPECT_EQ(noteThatHas("white"), 0);
  }
  layout.orientation = 0, layout.photometric = 0;
  writeTiff(path, volume, 0, kStackDims.z, layout);
  EXPECT_EQ(noteThatHas("the TIFF files show their smallest values white (WhiteIsZero)"), 1);
  // A stack whose slices are shown in different ways is no stack.
  writeTiff(files.directory() / "s1.tif", volume, 0, 1);
  writeTiff(files.directory() / "s2.tif", volume, 1, 2, layout);
  fs::remove(path);
  expectRefused(
      files.directory(), ErrorCode::kFormat,
      "s2.tif: page 1: slice 1 is 21 x 19 of u8, its smallest value white, but the first, in s1.tif, is 21 x");
  layout.photometric = 1, layout.orientation = 3;
  writeTiff(files.directory() / "s2.tif", volume, 1, 2, layout);
  expectRefused(files.directory(), ErrorCode::kFormat, "slice 1 is 21 x 19 of u8, of orientation 3, but the first");
}

TEST(IngestTiff, NamesAreSortedAsPeopleCount) {
  EXPECT_TRUE(naturallyBefore("slice2.tif", "slice10.tif"));
  EXPECT_FALSE(naturallyBefore("slice10.tif", "slice2.tif"));
  EXPECT_TRUE(naturallyBefore("a2b10", "a2b11"));
  EXPECT_TRUE(naturallyBefore("a1", "a1b"));
  EXPECT_TRUE(naturallyBefore("a9z", "b1"));
  EXPECT_TRUE(naturallyBefore("x99999999999999999999998", "x99999999999999999999999"));
  EXPECT_TRUE(naturallyBefore("a007", "a8"));
  EXPECT_TRUE(naturallyBefore("a01", "a1") != naturallyBefore("a1", "a01"));
  EXPECT_FALSE(naturallyBefore("a1", "a1"));
  EXPECT_TRUE(naturallyBefore("", "a"));
  EXPECT_TRUE(naturallyBefore("a-1", "a1") != naturallyBefore("a1", "a-1"));
}

// Twelve files without leading zeros; other files are ignored and named.
TEST(IngestTiff, ADirectoryIsAStackInNaturalOrder) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({21, 19, 12}, VoxelType::u16, 9);
  for (std::int64_t z = 0; z < 12; ++z) {
    TiffLayout layout;
    layout.big_endian = z % 2 == 0;  // slices need not be stored alike
    layout.compression = z % 3 == 0 ? 5 : 1;
    layout.tile = z % 4 == 0 ? 16 : 0;
    writeTiff(files.directory() / ("slice" + std::to_string(z + 1) + ".tif"), volume, z, z + 1, layout);
  }
  files.write("readme.txt", "taken on a Monday");
  files.write(".DS_Store", "hidden");
  fs::create_directory(files.directory() / "masks");
  expectReadsBack(volume, files.directory(), 9);
  const auto source = openSource(files.directory());
  EXPECT_EQ(source->info().format, "TIFF, 12 slices");
  ASSERT_EQ(source->info().notes.size(), 2u);
  EXPECT_NE(source->info().notes[0].find("'readme.txt'"), std::string::npos) << source->info().notes[0];
  EXPECT_NE(source->info().notes[1].find("taken to be 1 x 1 x 1"), std::string::npos) << source->info().notes[1];
  ASSERT_EQ(source->info().files.size(), 13u);
  EXPECT_EQ(source->info().files[0], files.directory());
  EXPECT_EQ(source->info().files[12].filename(), "slice12.tif");
}

TEST(IngestTiff, FilesOfSeveralPagesFollowEachOther) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({21, 19, 9}, VoxelType::i16, 10);
  writeTiff(files.directory() / "part1.tif", volume, 0, 4);
  writeTiff(files.directory() / "part2.tif", volume, 4, 9);
  expectReadsBack(volume, files.directory(), 10);
}

// Known: in a stack of single-page files, one file has three pages.
TEST(IngestTiff, FileOfSeveralPagesAmongSlices_IsAnError) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({21, 19, 6}, VoxelType::u8, 10);
  writeTiff(files.directory() / "s1.tif", volume, 0, 1);
  writeTiff(files.directory() / "s2.tif", volume, 1, 4);
  writeTiff(files.directory() / "s3.tif", volume, 4, 5);
  expectRefused(files.directory(), ErrorCode::kFormat,
                "s2.tif: has 3 pages, but 's1.tif' has 1; slices are files of one page each, or of several each; "
                "--allow-irregular takes every page as a slice");
  SourceOptions options;
  options.allow_irregular = true;
  EXPECT_EQ(openSource(files.directory(), options)->info().geometry.dims.z, 5);
}

// Known: a folder or pipe with a slice's name would otherwise be missed only at the end of the stack.
TEST(IngestTiff, FolderOrPipeNamedLikeASlice_IsAnError) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 10);
  for (std::int64_t z = 0; z < 3; ++z)
    writeTiff(files.directory() / ("s_" + std::to_string(z) + ".tif"), volume, z, z + 1);
  for (const char* name : {"s_3.tif", "s_1.tif"}) {
    const fs::path path = files.directory() / name;
    fs::remove(path);
    fs::create_directory(path);
    expectRefused(files.directory(), ErrorCode::kFormat,
                  std::string(name) + ": is named like the slices beside it, but is a folder; rename or remove it");
    fs::remove(path);
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    expectRefused(files.directory(), ErrorCode::kFormat, "but is a pipe or a device; rename or remove it");
    fs::remove(path);
  }
}

TEST(IngestTiff, SmallerCopiesAreNotSlices) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 11);
  TiffLayout layout;
  layout.reduced_pages = 1;
  writeTiff(files.directory() / "a.tif", volume, 0, kStackDims.z, layout);
  EXPECT_EQ(openSource(files.directory() / "a.tif")->info().geometry.dims.z, 3);
}

// Four threads read random boxes, from a source that caches almost nothing and from a source that caches everything.
TEST(IngestTiff, ThreadsReadBoxesInAnyOrder) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({70, 60, 9}, VoxelType::u16, 12);
  for (const int compression : {1, 8}) {
    TiffLayout layout;
    layout.compression = compression;
    layout.strip_rows = 7;
    writeTiff(files.directory() / "a1.tif", volume, 0, 4, layout);
    writeTiff(files.directory() / "a2.tif", volume, 4, 9, layout);
    for (const std::uint64_t kept : {0u, 1u << 20}) {
      const auto source = openSource(files.directory());
      source->keepDecoded(kept);
      EXPECT_EQ(source->decodeBytes(), compression == 1 ? 0u : 2u * 70 * 7 * 2);
      std::vector<std::thread> threads;
      std::array<int, 4> wrong{};
      for (std::size_t t = 0; t < wrong.size(); ++t) {
        threads.emplace_back([&, t] {
          std::mt19937_64 random(t);
          for (int i = 0; i < 100; ++i) {
            VoxelBox box;
            for (int axis = 0; axis < 3; ++axis) {
              const auto n = static_cast<std::uint64_t>(volume.dims[axis]);
              box.lo[axis] = static_cast<std::int64_t>(random() % n);
              box.hi[axis] = box.lo[axis] + 1 +
                             static_cast<std::int64_t>(random() % (n - static_cast<std::uint64_t>(box.lo[axis])));
            }
            std::vector<std::byte> out(static_cast<std::size_t>(box.count()) * 2);
            source->read(box, out);
            wrong[t] += out != volume.box(box);
          }
        });
      }
      for (std::thread& thread : threads) thread.join();
      for (const int w : wrong) EXPECT_EQ(w, 0);
    }
  }
}

// Returns the bytes of a file in which each directory follows the pixels of its page. Each directory ends with the link
// to the next page, as most programs write stacks. A cut may remove only a part of such a link.
std::string stackWithLinksLast(const ForeignVolume& volume, std::vector<std::size_t>& links) {
  const auto put = [](std::string& out, std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>(value >> (8 * i)));
  };
  std::string out("II*\0", 4);
  links = {out.size()};
  put(out, 0, 4);
  const std::string voxels = volume.stored(false);
  const std::size_t page = voxels.size() / static_cast<std::size_t>(volume.dims.z);
  for (std::int64_t z = 0; z < volume.dims.z; ++z) {
    const std::size_t strip = out.size();
    out += voxels.substr(static_cast<std::size_t>(z) * page, page);
    std::string link;
    put(link, out.size(), 4);
    out.replace(links.back(), 4, link);
    const auto width = static_cast<std::uint64_t>(volume.dims.x), height = static_cast<std::uint64_t>(volume.dims.y);
    const std::pair<int, std::uint64_t> tags[] = {{256, width}, {257, height}, {258, 8 * sizeOf(volume.type)},
                                                  {259, 1},     {262, 1},      {273, strip},
                                                  {277, 1},     {278, height}, {279, page}};
    put(out, std::size(tags), 2);
    for (const auto& [tag, value] : tags) {
      put(out, static_cast<std::uint64_t>(tag), 2);
      put(out, 4, 2);
      put(out, 1, 4);
      put(out, value, 4);
    }
    links.push_back(out.size());
    put(out, 0, 4);
  }
  return out;
}

TEST(IngestTiff, CutWithinAPageLink_IsAnError) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({7, 5, 3}, VoxelType::u16, 21);
  std::vector<std::size_t> links;
  const std::string whole = stackWithLinksLast(volume, links);
  const fs::path path = files.write("a.tif", whole);
  expectReadsBack(volume, path, 21);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    files.write("a.tif", whole.substr(0, length));
    try {
      readWhole(*openSource(path));
      ADD_FAILURE() << length << " of " << whole.size() << " bytes were taken for a whole file";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("a.tif"), std::string::npos) << error.what();
    }
  }
}

TEST(IngestTiff, PageLinkThatLeadsNowhere_IsAnError) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({7, 5, 3}, VoxelType::u16, 22);
  std::vector<std::size_t> links;
  const std::string whole = stackWithLinksLast(volume, links);
  const auto linked = [&](std::size_t from, std::uint32_t to) {
    std::string bytes = whole;
    for (std::size_t i = 0; i < 4; ++i) bytes[links[from] + i] = static_cast<char>(to >> (8 * i));
    files.write("a.tif", bytes);
    expectRefused(files.directory() / "a.tif", ErrorCode::kFormat, "TIFF directory");
  };
  const auto size = static_cast<std::uint32_t>(whole.size());
  for (const std::size_t link : {0u, 1u, 2u, 3u}) {
    for (const std::uint32_t to : {size, size - 1, size + 100, 0xfffffff0u, 1u}) linked(link, to);
  }
  const auto directory = static_cast<std::uint32_t>(links[2] - 9 * 12 - 2);
  linked(2, directory);  // into itself
  linked(3, directory);  // back
}

// ImageJ's number of images is the only evidence for a link overwritten with zero.
TEST(IngestTiff, FewerPagesThanImageJSays_IsAnError) {
  const ForeignFiles files;
  TiffLayout layout;
  layout.compression = 8;
  layout.description = "ImageJ=1.53c\nimages=4\nslices=4\n";
  const fs::path path = files.directory() / "a.tif";
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 23);
  for (const int pages : {1, 3}) {
    writeTiff(path, volume, 0, pages, layout);
    expectRefused(path, ErrorCode::kFormat, "says 4 images, but " + std::to_string(pages));
    SourceOptions options;
    options.allow_irregular = true;
    EXPECT_EQ(openSource(path, options)->info().geometry.dims.z, pages);
    EXPECT_NE(openSource(path, options)->info().notes.front().find("slices are missing"), std::string::npos);
  }
  layout.description = R"(<OME x="y"><Pixels SizeC="1" SizeZ="4"/></OME>)";
  writeTiff(path, volume, 0, 3, layout);
  expectRefused(path, ErrorCode::kFormat, "OME's description says 4 images, but 3 are found");
}

// A cut removes a directory, a value of a directory, or pixels; otherwise all voxels are there.
TEST(IngestTiff, EveryTruncationIsAnErrorOrTheData) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({11, 9, 3}, VoxelType::u16, 13);
  for (const bool big_tiff : {false, true}) {
    for (const int compression : {1, 5, 8, 32773}) {
      TiffLayout layout;
      layout.big_tiff = big_tiff;
      layout.compression = compression;
      layout.strip_rows = 4;
      layout.description = "a description that does not fit into the entry";
      const fs::path path = files.directory() / "a.tif";
      writeTiff(path, volume, 0, 3, layout);
      const std::string whole = bytesOf(path);
      testing::internal::CaptureStderr();
      for (std::size_t length = 0; length < whole.size(); ++length) {
        files.write("a.tif", whole.substr(0, length));
        try {
          EXPECT_TRUE(readWhole(*openSource(path)) == volume.voxels) << length << " of " << whole.size();
        } catch (const Error& error) {
          EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
          EXPECT_NE(std::string(error.what()).find("a.tif"), std::string::npos) << error.what();
        }
      }
      EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    }
  }
}

TEST(IngestTiff, FlippedBitsNeverCrash) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({11, 9, 3}, VoxelType::u16, 14);
  for (const int compression : {1, 5, 8}) {
    TiffLayout layout;
    layout.compression = compression;
    layout.strip_rows = compression == 8 ? 0 : 4;
    layout.tile = compression == 8 ? 16 : 0;
    const fs::path path = files.directory() / "a.tif";
    writeTiff(path, volume, 0, 3, layout);
    const std::string whole = bytesOf(path);
    testing::internal::CaptureStderr();
    expectBitFlipsAreHarmless(files, "a.tif", whole, whole.size(), path, 14);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  }
}

// Known by the weights of ITU-R BT.709 on each pixel. Equal samples are their own luminance.
TEST(IngestTiff, ColoursAreLuminanceWhereAsked) {
  const ForeignFiles files;
  const fs::path path = files.directory() / "a.tif";
  SourceOptions options;
  options.luminance = true;
  for (const VoxelType type : {VoxelType::u8, VoxelType::u16}) {
    for (const int samples : {3, 4}) {
      const ForeignVolume colours = randomVolume({21 * samples, 19, 3}, type, 71);
      ForeignVolume expected{{21, 19, 3}, type, {}};
      withVoxelType(type, [&]<class T>(std::type_identity<T>) {
        for (std::size_t at = 0; at < colours.voxels.size(); at += static_cast<std::size_t>(samples) * sizeof(T)) {
          T rgb[3];
          std::memcpy(rgb, &colours.voxels[at], sizeof rgb);
          const double tenthousandths = 2126.0 * rgb[0] + 7152.0 * rgb[1] + 722.0 * rgb[2];
          const auto luminance = static_cast<T>(std::floor(tenthousandths / 10000 + 0.5));
          const auto* const bytes = reinterpret_cast<const std::byte*>(&luminance);
          expected.voxels.insert(expected.voxels.end(), bytes, bytes + sizeof luminance);
        }
      });
      for (const auto& [compression, tile, big] :
           {std::tuple(1, 0, false), {1, 0, true}, {5, 16, true}, {8, 0, false}}) {
        SCOPED_TRACE(testing::Message() << nameOf(type) << " " << samples << " " << compression << " " << tile);
        TiffLayout layout;
        layout.photometric = 2, layout.samples = samples, layout.holds_samples = true;
        layout.compression = compression, layout.tile = tile, layout.big_endian = big;
        writeTiff(path, colours, 0, 3, layout);
        expectReadsBack(
            expected, [&] { return openSource(path, options); }, 72);
      }
    }
  }
  EXPECT_EQ(openSource(path, options)->info().format, "TIFF, 3 slices, luminance");
  expectRefused(path, ErrorCode::kUnsupported, "holds RGB colours, not one value a pixel; --luminance reads");
  writeTiff(path, randomVolume(kStackDims, VoxelType::u8, 73), 0, 1);
  expectRefused(path, ErrorCode::kUnsupported, "holds no colours, of which --luminance could be read", options);
}

TEST(IngestTiff, PagesOfOtherKindsAreRefusedByName) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 15);
  const fs::path path = files.directory() / "a.tif";
  const auto expect = [&](const TiffLayout& layout, const std::string& says) {
    writeTiff(path, volume, 0, 1, layout);
    expectRefused(path, ErrorCode::kUnsupported, says);
  };
  TiffLayout layout;
  layout.photometric = 2, layout.samples = 3;
  expect(layout, "page 1: holds RGB colours");
  layout = {}, layout.photometric = 3;
  expect(layout, "palette");
  layout = {}, layout.samples = 2;
  expect(layout, "2 samples a pixel");
  layout = {}, layout.bits = 12;
  expect(layout, "12-bit integers");
  layout = {}, layout.bits = 1;
  expect(layout, "1-bit integers");
}

struct Hyperstack {
  std::string description;
  int channels, times;
  /// The number of image z, channel c, time t.
  std::function<std::int64_t(std::int64_t z, std::int64_t c, std::int64_t t)> image;
};

// Known: each program's order of images, by its documentation. ImageJ: channels, slices, frames.
TEST(IngestTiff, ChannelAndTimeChooseOneStackOfSeveral) {
  const ForeignFiles files;
  const ForeignVolume all = randomVolume({21, 19, 12}, VoxelType::u16, 31);
  const auto ome = [](const std::string& order, int c, int t, const std::string& more = "/>") {
    return "<?xml version=\"1.0\"?><OME xmlns=\"x\"><Image><Pixels DimensionOrder=\"" + order + "\" SizeC=\"" +
           std::to_string(c) + "\" SizeT=\"" + std::to_string(t) + "\" SizeZ=\"" + std::to_string(12 / c / t) + "\"" +
           more + "</Image></OME>";
  };
  const Hyperstack stacks[] = {
      {"ImageJ=1.53c\nimages=12\nchannels=2\nslices=3\nframes=2\n", 2, 2,
       [](auto z, auto c, auto t) { return c + 2 * z + 6 * t; }},
      {"ImageJ=1.53c\nimages=12\nchannels=3\n", 3, 1, [](auto z, auto c, auto) { return c + 3 * z; }},
      {ome("XYZCT", 2, 3), 2, 3, [](auto z, auto c, auto t) { return z + 2 * c + 4 * t; }},
      {ome("XYCZT", 2, 3), 2, 3, [](auto z, auto c, auto t) { return c + 2 * z + 4 * t; }},
      {ome("XYTCZ", 2, 3), 2, 3, [](auto z, auto c, auto t) { return t + 3 * c + 6 * z; }},
      {R"({"shape": [4, 3, 19, 21]})", 4, 1, [](auto z, auto c, auto) { return z + 3 * c; }},
      {R"({"shape": [2, 1, 6, 19, 21]})", 2, 1, [](auto z, auto c, auto) { return z + 6 * c; }},
      {R"({"shape": [2, 3, 2, 19, 21], "axes": "TZCYX"})", 2, 2,
       [](auto z, auto c, auto t) { return c + 2 * z + 6 * t; }},
      {R"({"axes": "CZYX", "spacing": 2.0, "unit": "um", "shape": [2, 6, 19, 21]})", 2, 1,
       [](auto z, auto c, auto) { return z + 6 * c; }},
  };
  const fs::path path = files.directory() / "a.tif";
  for (const Hyperstack& stack : stacks) {
    SCOPED_TRACE(stack.description);
    TiffLayout layout;
    layout.description = stack.description;
    writeTiff(path, all, 0, 12, layout);
    for (int c = 0; c < stack.channels; ++c) {
      for (int t = 0; t < stack.times; ++t) {
        std::vector<std::int64_t> images(static_cast<std::size_t>(12 / stack.channels / stack.times));
        for (std::size_t z = 0; z < images.size(); ++z) images[z] = stack.image(static_cast<std::int64_t>(z), c, t);
        SourceOptions options;
        options.channel = std::to_string(c);
        if (stack.times > 1) options.time = t;
        expectReadsBack(
            all.slices(images), [&] { return openSource(path, options); }, 32);
      }
    }
    expectRefused(path, ErrorCode::kUsage, "choose one with --channel");
  }
  const auto expect = [&](const std::string& description, ErrorCode code, const std::string& says) {
    TiffLayout layout;
    layout.description = description;
    writeTiff(path, all, 0, 12, layout);
    SourceOptions options;
    options.channel = "1", options.time = 0;
    expectRefused(path, code, says, options);
  };
  expect(ome("XYZCT", 5, 1), ErrorCode::kFormat, "says 2 slices, 5 channels and 1 times, but 12 images are found");
  expect("ImageJ=1\nchannels=9000000000000000000\nframes=9000000000000000000\n", ErrorCode::kFormat,
         "1000000 channels and 1000000 times");
  expect(R"({"shape": [9000000000000000000, 9000000000000000000, 3, 19, 21]})", ErrorCode::kFormat, "1000000 channels");
  expect(ome("XYZCT", 2, 1, "><TiffData IFD=\"0\" FirstC=\"1\"/></Pixels>"), ErrorCode::kUnsupported,
         "an order of their own");
}

TEST(IngestTiff, NamedChannels_areChosenByName) {
  const ForeignFiles files;
  const ForeignVolume all = randomVolume({21, 19, 4}, VoxelType::u8, 33);
  const fs::path path = files.directory() / "a.tif";
  TiffLayout layout;
  layout.description =
      "<?xml version=\"1.0\"?><OME xmlns=\"x\"><Image><Pixels DimensionOrder=\"XYZCT\" SizeC=\"2\" SizeT=\"1\" "
      "SizeZ=\"2\"><Channel Name=\"DAPI\"/><Channel Name=\"GFP\"/><TiffData IFD=\"0\" "
      "PlaneCount=\"4\"/></Pixels></Image>"
      "</OME>";
  writeTiff(path, all, 0, 4, layout);
  expectRefused(path, ErrorCode::kUsage,
                "holds 2 channels; choose one with --channel, from 0 to 1: 0 ('DAPI'), 1 ('GFP')");
  SourceOptions options;
  options.channel = "GFP";
  expectReadsBack(
      all.slices({2, 3}), [&] { return openSource(path, options); }, 34);
  EXPECT_EQ(openSource(path, options)->info().format, "TIFF, 2 slices, channel 1");
}

// Known: libtiff writes the 16 and 64 bits as they are given; the reader's values are compared with the definition.
TEST(IngestTiff, HalfFloatsAndWideIntegersBecomeVoxels) {
  const ForeignFiles files;
  const fs::path path = files.directory() / "a.tif";
  ForeignVolume halves = randomVolume({21, 19, 2}, VoxelType::u16, 35);
  for (std::size_t i = 1; i < halves.voxels.size(); i += 2) halves.voxels[i] &= std::byte{0xbf};  // no infinity, no NaN
  ForeignVolume wide = {{21, 19, 2}, VoxelType::f64, {}}, narrow = randomVolume({21, 19, 2}, VoxelType::i32, 36);
  for (std::size_t i = 0; i < narrow.voxels.size(); i += 4) {
    std::int32_t value;
    std::memcpy(&value, &narrow.voxels[i], 4);
    const std::int64_t same = value;
    const auto* const bytes = reinterpret_cast<const std::byte*>(&same);
    wide.voxels.insert(wide.voxels.end(), bytes, bytes + 8);
  }
  for (const int tile : {0, 16}) {
    for (const bool big : {false, true}) {
      TiffLayout layout;
      layout.tile = tile, layout.big_endian = big, layout.compression = tile == 0 ? 1 : 8;
      layout.sample_format = 3;
      writeTiff(path, halves, 0, 2, layout);
      const auto source = openSource(path);
      EXPECT_EQ(source->info().type, VoxelType::f32);
      const std::vector<std::byte> found = readWhole(*source);
      for (std::size_t i = 0; 2 * i < halves.voxels.size(); ++i) {
        std::uint16_t bits;
        float value;
        std::memcpy(&bits, &halves.voxels[2 * i], 2), std::memcpy(&value, &found[4 * i], 4);
        const int exponent = bits >> 10 & 31, mantissa = bits & 1023;
        const double magnitude = exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
        ASSERT_EQ(static_cast<double>(value), bits >> 15 ? -magnitude : magnitude) << bits;
      }
      layout.sample_format = 2;
      writeTiff(path, wide, 0, 2, layout);
      expectReadsBack(narrow, path, 37);
    }
  }
  wide.voxels[4] = std::byte{1};  // of the first value, beyond 32 bits
  TiffLayout layout;
  layout.sample_format = 2;
  writeTiff(path, wide, 0, 2, layout);
  expectRefused(path, ErrorCode::kFormat, "slice 0: the 64-bit integer");
}

// Spacings in descriptions, in the units that each program writes.
TEST(IngestTiff, DescriptionsGiveTheSpacing) {
  struct Said {
    std::string description;
    glm::dvec3 spacing;
    std::string unit;
  };
  for (
      const Said& said : std::vector<Said>{
          {"ImageJ=1.53c\nunit=um\nspacing=0.5\n", {0.25, 0.25, 0.5}, "um"},
          {"ImageJ=1.53c\nunit=angstrom\nspacing=0.5\n", {0.25, 0.25, 0.5}, "angstrom"},
          {"ImageJ=1.53c\nunit=furlong\nspacing=0.5\n", {0.25, 0.25, 0.5}, ""},
          {"ImageJ=1.53c\nunit=pixel\nspacing=2\n", {1, 1, 2}, ""},
          {R"(<OME x="y"><Pixels SizeC="1" PhysicalSizeX="0.2" PhysicalSizeY="0.3" PhysicalSizeZ="1.5"/></OME>)",
           {0.2, 0.3, 1.5},
           "um"},
          {R"(<OME x="y"><Pixels PhysicalSizeX="0.2" PhysicalSizeXUnit="mm" PhysicalSizeY="0.3" PhysicalSizeYUnit="mm"/></OME>)",
           {0.2, 0.3, 0.2},
           "mm"},
          {R"({"shape": [4, 19, 21]})", {1, 1, 1}, ""}}) {
    const ForeignFiles files;
    TiffLayout layout;
    layout.description = said.description;
    layout.x_resolution = layout.y_resolution = 4, layout.resolution_unit = 1;
    writeTiff(files.directory() / "a.tif", randomVolume(kStackDims, VoxelType::u8, 18), 0, 4, layout);
    const VolumeGeometry geometry = openSource(files.directory() / "a.tif")->info().geometry;
    EXPECT_LT(glm::length(geometry.spacing() - said.spacing), 1e-9) << said.description;
    EXPECT_EQ(geometry.unit, said.unit) << said.description;
  }
}

// ImageJ stores signed numbers with an offset of 32768 and a mark in the description.
TEST(IngestTiff, SignedNumbersOfImageJAreSigned) {
  const ForeignFiles files;
  ForeignVolume stored = randomVolume(kStackDims, VoxelType::u16, 19);
  TiffLayout layout;
  layout.description = "ImageJ=1.53c\nslices=4\ncf=0\nc0=-32768.0\nc1=1.0\nvunit=gray value\n";
  writeTiff(files.directory() / "a.tif", stored, 0, 4, layout);
  ForeignVolume meant{stored.dims, VoxelType::i16, stored.voxels};
  for (std::size_t i = 1; i < meant.voxels.size(); i += 2) meant.voxels[i] ^= std::byte{0x80};
  expectReadsBack(meant, files.directory() / "a.tif", 19);
  layout.description = "ImageJ=1.53c\nslices=4\ncf=0\nc0=-1000\nc1=2\n";
  writeTiff(files.directory() / "b.tif", stored, 0, 4, layout);
  const auto source = openSource(files.directory() / "b.tif");
  ASSERT_EQ(source->info().notes.size(), 2u);
  EXPECT_NE(source->info().notes[0].find("taken to be 1 x 1 x 1"), std::string::npos);
  EXPECT_NE(source->info().notes[1].find("-1000 + 2 times what is stored"), std::string::npos);
}

// A slice that is missing or empty would shift all later slices.
TEST(IngestTiff, ASliceThatCannotBeReadIsAnError) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u8, 20);
  for (int z = 0; z < 3; ++z) writeTiff(files.directory() / ("s" + std::to_string(z) + ".tif"), volume, z, z + 1);
  files.write("notes.txt", "");
  std::filesystem::create_symlink("gone", files.directory() / "latest");
  EXPECT_EQ(openSource(files.directory())->info().geometry.dims.z, 3);
  files.write("s1.tif", "");
  expectRefused(files.directory(), ErrorCode::kFormat, "s1.tif: is named like the slices beside it");
  std::filesystem::remove(files.directory() / "s1.tif");
  std::filesystem::create_symlink("gone.tif", files.directory() / "s1.tif");
  expectRefused(files.directory(), ErrorCode::kNotFound,
                "s1.tif: is named like the slices beside it, and is a link to nothing");
}

// Replaces LZW's code in the directory, a short at the front of the entry's value.
TEST(IngestTiff, AnUnknownCompressionIsNamed) {
  const ForeignFiles files;
  TiffLayout layout;
  layout.compression = 5;
  writeTiff(files.directory() / "a.tif", randomVolume(kStackDims, VoxelType::u8, 16), 0, 1, layout);
  const std::string whole = bytesOf(files.directory() / "a.tif");
  const std::string entry("\x03\x01\x03\x00\x01\x00\x00\x00\x05\x00", 10);
  const std::size_t at = whole.find(entry);
  ASSERT_NE(at, std::string::npos);
  for (const auto& [code, says] : {std::pair{34712, "JPEG 2000 (scheme 34712)"}, {4, "CCITT"}, {777, "scheme 777"}}) {
    std::string changed = whole;
    changed[at + 8] = static_cast<char>(code & 255), changed[at + 9] = static_cast<char>(code >> 8);
    files.write("a.tif", changed);
    expectRefused(files.directory() / "a.tif", ErrorCode::kUnsupported, says);
  }
}

TEST(IngestTiff, SlicesThatDifferAreAnErrorThatNamesThem) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kStackDims, VoxelType::u16, 17);
  writeTiff(files.directory() / "s1.tif", volume, 0, 1);
  writeTiff(files.directory() / "s2.tif", randomVolume({21, 18, 1}, VoxelType::u16, 17), 0, 1);
  expectRefused(files.directory(), ErrorCode::kFormat,
                "s2.tif: page 1: slice 1 is 21 x 18 of u16, but the first, in s1.tif, is 21 x 19 of u16");
  // A third slice shows which slice is odd.
  writeTiff(files.directory() / "s3.tif", randomVolume({21, 18, 1}, VoxelType::u16, 17), 0, 1);
  expectRefused(files.directory(), ErrorCode::kFormat,
                "s1.tif: page 1: slice 0 is 21 x 19 of u16, but the next, in s2.tif, is 21 x 18 of u16");
  fs::remove(files.directory() / "s3.tif");
  writeTiff(files.directory() / "s2.tif", randomVolume({21, 19, 1}, VoxelType::i16, 17), 0, 1);
  expectRefused(files.directory(), ErrorCode::kFormat, "is 21 x 19 of i16");
  files.write("s2.tif", bytesOf(files.directory() / "s1.tif").substr(0, 40));
  expectRefused(files.directory(), ErrorCode::kFormat, "s2.tif");
}

TEST(IngestTiff, ADirectoryWithoutSlicesIsOneLine) {
  const ForeignFiles files;
  expectRefused(files.directory(), ErrorCode::kUnsupported, "a directory without slices");
  files.write("b.txt", "b");
  files.write("a.txt", "a");
  expectRefused(files.directory(), ErrorCode::kUnsupported, "'a.txt' and 1 more");
}

// A compressed page of a single strip must be decoded whole: planning fails before any read.
TEST(IngestTiff, AStripThatDoesNotFitTheBudgetIsNamedBeforeReading) {
  const ForeignFiles files;
  const ForeignVolume volume{{2048, 1024, 2}, VoxelType::u16, std::vector<std::byte>(2048 * 1024 * 2 * 2)};
  TiffLayout layout;
  layout.compression = 8;
  writeTiff(files.directory() / "a.tif", volume, 0, 2, layout);
  ConvertOptions options;
  options.memory_bytes = 4 << 20;
  Progress silent;
  expectError([&] { convert(*openSource(files.directory() / "a.tif"), files.directory() / "a.kiln", options, silent); },
              ErrorCode::kBudget, "");
  layout.compression = 1;
  writeTiff(files.directory() / "a.tif", volume, 0, 2, layout);
  convert(*openSource(files.directory() / "a.tif"), files.directory() / "a.kiln", options, silent);
}

TEST(IngestTiff, TheRealStackIsTheFirstSlicesOfTheNrrd) {
  const fs::path stack = realData("tiff/cthead"), nrrd = realData("cthead_256x256x113_u16le.nrrd");
  if (stack.empty() || nrrd.empty()) GTEST_SKIP() << "../shared/data is not here";
  const auto tiff = openSource(stack), whole = openSource(nrrd);
  ASSERT_EQ(tiff->info().geometry.dims, (Extent3{256, 256, 99}));
  ASSERT_EQ(tiff->info().type, VoxelType::u16);
  std::vector<std::byte> expected(256 * 256 * 99 * 2);
  whole->read({{0, 0, 0}, {256, 256, 99}}, expected);
  EXPECT_TRUE(readWhole(*tiff) == expected);
}

}  // namespace
}  // namespace kiln::test

// AmiraMesh. Known because the test writes the header's text and the voxels behind the mark @1.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "ingest/open_source.h"
#include "support/files/amira_files.h"
#include "support/files/foreign_files.h"

namespace kiln::test {
namespace {

TEST(IngestAmira, EveryTypeAndOrderReadsBack) {
  const ForeignFiles files;
  for (const VoxelType type :
       {VoxelType::u8, VoxelType::i16, VoxelType::u16, VoxelType::i32, VoxelType::f32, VoxelType::f64}) {
    SCOPED_TRACE(nameOf(type));
    const ForeignVolume volume = randomVolume({13, 9, 7}, type, 361);
    const std::string name = amiraName(type), little = amiraHeader(volume.dims, "BINARY-LITTLE-ENDIAN", name);
    for (const auto& path :
         {files.write("a.am", little + volume.stored(false) + "\n"),
          files.write("b.am", amiraHeader(volume.dims, "3D BINARY", name) + volume.stored(true)),
          files.write("c.am", amiraHeader(volume.dims, "ASCII", name) + decimalsOf(volume, " \n"))}) {
      expectReadsBack(volume, path, 362);
      const auto source = openSource(path);
      readWhole(*source);
      source->finish();
      EXPECT_TRUE(source->info().notes.empty()) << source->info().notes[0];
    }
    const std::string packed = zlibbed(volume.stored(false));
    const std::string mark = fmt::format("@1(HxZip,{})", packed.size());
    expectReadsBack(volume, files.write("d.am", amiraHeader(volume.dims, "BINARY-LITTLE-ENDIAN", name, mark) + packed),
                    363);
    expectReadsBack(volume, files.write("e.am", replaced(little, "} @1", "} = @1") + volume.stored(false)), 364);
  }
}

// Known: the box runs from the first voxel's centre to the last one's.
TEST(IngestAmira, BoundingBoxIsThePlace) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume({5, 4, 3}, VoxelType::u8, 371);
  const std::string whole = amiraHeader(volume.dims, "BINARY", "byte") + volume.stored(true);
  const auto path = files.write("a.am", whole);
  const VolumeGeometry g = openSource(path)->info().geometry;
  EXPECT_EQ(g.worldOf({0, 0, 0}), glm::dvec3(1, 2, -3));
  EXPECT_EQ(g.worldOf({4, 3, 2}), glm::dvec3(5, 8, 3));
  EXPECT_EQ(g.unit, "mm");
  SourceOptions options;
  options.spacing = glm::dvec3(2);
  expectRefused(path, ErrorCode::kUsage, "--spacing", options);
  const auto unplaced = files.write("b.am", replaced(whole, "    BoundingBox 1 5 2 8 -3 3,\n", ""));
  EXPECT_EQ(openSource(unplaced, options)->info().geometry.worldOf({1, 1, 1}), glm::dvec3(2));
}

TEST(IngestAmira, OtherFilesAreRefusedByName) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u8, 381);
  const std::string whole = amiraHeader(volume.dims, "BINARY", "byte") + volume.stored(true);
  const auto refused = [&](const std::string& from, const std::string& to, ErrorCode code, const std::string& part) {
    expectRefused(files.write("a.am", replaced(whole, from, to)), code, part);
  };
  refused("BINARY 2.1", "HYPERSURFACE 2.1", ErrorCode::kUnsupported, "line 1: is neither ASCII nor BINARY");
  refused("define Lattice", "define Nodes", ErrorCode::kFormat, "has no lattice");
  refused("define Lattice 5 4 3", "define Lattice 5 4", ErrorCode::kFormat, "line 4: a lattice of 2 axes");
  refused("define Lattice 5", "define Lattice x", ErrorCode::kFormat, "'x' is no number of voxels");
  refused("define Lattice 5", "define Lattice -5", ErrorCode::kFormat, "a.am");
  refused("{ byte", "{ float[3]", ErrorCode::kUnsupported, "holds 'float[3]', not one number a voxel");
  refused("} @1", "} @1(HxByteRLE,9)", ErrorCode::kUnsupported, "compressed by 'HxByteRLE'");
  refused("\"uniform\"", "\"curvilinear\"", ErrorCode::kUnsupported, "'curvilinear' coordinates are not read");
  refused("BoundingBox 1 5", "BoundingBox 1 1", ErrorCode::kFormat, "a.am");
  refused("BoundingBox 1 5", "BoundingBox 5", ErrorCode::kFormat, "BoundingBox must hold 6 numbers");
  refused("Lattice { byte Data } @1\n", "", ErrorCode::kUnsupported, "has a lattice without a field");
  refused("Lattice { byte Data } @1\n", "Lattice { byte A } @1\nLattice { byte B } @2\n", ErrorCode::kUnsupported,
          "holds 2 fields on its lattice");
  refused("{ byte Data }", "{ byte }", ErrorCode::kFormat, "a field has a type and a name");
  refused("\n@1\n", "\n", ErrorCode::kFormat, "the header ends before its data");
  // Points of another kind stand in front of the voxels.
  refused("Lattice { byte Data } @1\n", "Markers { float[3] Coordinates } @1\nLattice { byte Data } @2\n",
          ErrorCode::kUnsupported, "the field's data, '@2', lie behind other data (found '@1' first)");
}

TEST(IngestAmira, EveryCutIsNoticedAndFlipsAreHarmless) {
  const ForeignFiles files;
  const ForeignVolume volume = randomVolume(kFewVoxels, VoxelType::u16, 391);
  const std::string head = amiraHeader(volume.dims, "BINARY-LITTLE-ENDIAN", "ushort"),
                    whole = head + volume.stored(false);
  const auto path = files.write("a.am", whole);
  expectNoCutGoesUnnoticed(volume, files, "a.am", whole, path);
  expectBitFlipsAreHarmless(files, "a.am", whole, head.size(), path, 392);
}

}  // namespace
}  // namespace kiln::test

// Arrays that the Python package zarr wrote. Known because the script also wrote the voxels as raw bytes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "ingest/open_source.h"
#include "support/system/python.h"
#include "support/volumes/zarr_files.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// Each array lies beside NAME.raw, its voxels in C order and little-endian.
constexpr const char* kScript = R"(
import sys, numpy, zarr
from numcodecs import Blosc, GZip, Zlib, Zstd, LZ4, Shuffle, BitRound
where = sys.argv[1]
random = numpy.random.default_rng(7)
def volume(dtype):
    kind = numpy.dtype(dtype)
    if kind.kind == 'f':
        return random.standard_normal((13, 17, 19)).astype(kind)
    smooth = numpy.add.outer(numpy.add.outer(numpy.arange(13) * 5, numpy.arange(17) * 3), numpy.arange(19))
    return (smooth + random.integers(0, 9, (13, 17, 19))).astype(kind)
number = 0
def write(data, voxels=None, **how):
    global number
    name = '%s/%d' % (where, number)
    number += 1
    store = zarr.NestedDirectoryStore(name) if how.pop('nested', False) else zarr.DirectoryStore(name)
    array = zarr.create(data.shape, dtype=data.dtype, store=store, **how)
    array[...] = data
    read = zarr.open(store, mode='r')[...] if voxels is None else voxels
    read.astype(read.dtype.newbyteorder('<')).tofile(name + '.raw')
codecs = [None, GZip(), Zlib(), Zstd(), LZ4()]
codecs += [Blosc(cname, 5, shuffle, blocksize) for cname in ('lz4', 'lz4hc', 'zstd', 'zlib')
           for shuffle in (Blosc.NOSHUFFLE, Blosc.SHUFFLE, Blosc.BITSHUFFLE, Blosc.AUTOSHUFFLE) for blocksize in (0, 300)]
for codec in codecs:
    write(volume('<u2'), compressor=codec, chunks=(5, 6, 7))
for dtype in ('|u1', '|i1', '>u2', '<i2', '>u4', '<i4', '<f4', '>f4', '<f8', '>f8'):
    for order in 'CF':
        write(volume(dtype), chunks=(4, 17, 30), order=order, compressor=Blosc('zstd', 3, Blosc.BITSHUFFLE))
write(volume('<u2'), chunks=(5, 6, 7), nested=True)
write(volume('<u2'), chunks=(5, 6, 7), dimension_separator='/')
write(volume('<u4'), chunks=(5, 6, 7), filters=[Shuffle(4)], compressor=Zlib())
write(volume('<f4'), chunks=(5, 6, 7), filters=[BitRound(5)], compressor=Zstd())
sparse = volume('<f4')
sparse[:, :12] = numpy.nan
write(sparse, chunks=(5, 6, 7), fill_value=float('nan'), write_empty_chunks=False)
for wide, narrow in (('<i8', '<i4'), ('>u8', '<u4'), ('<f2', '<f4'), ('|b1', '|u1')):
    data = volume(wide)
    write(data, voxels=data.astype(narrow), chunks=(5, 6, 7))
)";

TEST(IngestZarrPython, EveryArrayOfZarrPythonReadsBackExactly) {
  const std::string python = pythonWith("zarr");
  if (python.empty()) GTEST_SKIP() << "python3-zarr is not installed";
  const ForeignFiles files;
  const fs::path script = files.write("write.py", kScript);
  ASSERT_EQ(std::system(fmt::format("{} {} {}", python, script.string(), files.directory().string()).c_str()), 0);
  int arrays = 0;
  for (;; ++arrays) {
    const fs::path folder = files.directory() / std::to_string(arrays);
    if (!fs::exists(folder)) break;
    SCOPED_TRACE(bytesOf(folder / ".zarray"));
    const std::unique_ptr<VolumeSource> source = openSource(folder);
    EXPECT_EQ(source->info().geometry.dims, (Extent3{19, 17, 13}));
    const std::vector<std::byte> voxels = readWhole(*source);
    const std::string expected = bytesOf(folder.string() + ".raw");
    ASSERT_EQ(voxels.size(), expected.size());
    EXPECT_TRUE(std::equal(voxels.begin(), voxels.end(), std::as_bytes(std::span(expected)).begin()));
  }
  EXPECT_EQ(arrays, 5 + 32 + 20 + 5 + 4);
}

}  // namespace
}  // namespace kiln::test

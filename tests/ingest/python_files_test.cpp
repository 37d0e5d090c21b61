// Volumes that the libraries of each field wrote: nibabel, tifffile, zarr, mrcfile, VTK, h5py. Known because the
// scripts also wrote the voxels as raw bytes, and extent and affine as text.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "ingest/open_source.h"
#include "support/files/foreign_files.h"
#include "support/system/run_python.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

// keep(name, voxels, affine) writes NAME.raw, x fastest and little-endian, the numbers of voxels along x, y, z as
// NAME.dims, and the rows of the affine as NAME.affine.
constexpr const char* kCommonLines = R"(
import sys, numpy
where = sys.argv[1] + '/'
random = numpy.random.default_rng(7)
def volume(dtype, shape=(13, 17, 19)):
    kind = numpy.dtype(dtype)
    if kind.kind == 'f':
        return random.standard_normal(shape).astype(kind)
    limits = numpy.iinfo(kind)
    out = random.integers(limits.min, limits.max, shape, dtype=kind.newbyteorder('='), endpoint=True).astype(kind)
    out.flat[0], out.flat[1] = limits.min, limits.max
    return out
def keep(name, voxels, affine=None):
    voxels.astype(voxels.dtype.newbyteorder('<')).tofile(where + name + '.raw')
    numpy.savetxt(where + name + '.dims', voxels.shape[::-1], fmt='%d')
    if affine is not None:
        numpy.savetxt(where + name + '.affine', affine, fmt='%.17g')
)";

struct PythonLibrary {
  const char* modules = "";
  const char* package = "";
  int files = 0;
  const char* script = "";
};

// Arrays of nibabel have the axes x, y, z. All numbers of the affine are floats of 32 bits.
const PythonLibrary kNibabel = {"numpy, nibabel", "python3-nibabel", 8 * 2 + 2, R"(
import nibabel
affine = numpy.array([[0.5, 0, 0.125, -10], [0, -0.25, 0.5, 4], [0.25, 0.125, 2, 7], [0, 0, 0, 1]])
def save(name, data, kind, order='<'):
    header = kind.header_class(endianness=order)
    header.set_data_dtype(data.dtype)
    header.set_xyzt_units('mm')
    nibabel.save(kind(data, affine, header), where + name)
    keep(name, data.T, affine)
for number, dtype in enumerate(('u1', 'i1', 'u2', 'i2', 'u4', 'i4', 'f4', 'f8')):
    save('%d.nii' % number, volume(dtype), nibabel.Nifti1Image)
    save('%d.nii.gz' % number, volume(dtype), nibabel.Nifti2Image, '>')
save('pair.img', volume('i2'), nibabel.Nifti1Pair)
save('wide.nii', volume('i2', (33000, 2, 3)), nibabel.Nifti2Image)
)"};

const PythonLibrary kTifffile = {"numpy, tifffile", "python3-tifffile", 10 + 6, R"(
import tifffile
spacing = numpy.diag([0.25, 0.5, 2, 1])
def save(name, data, affine=None, **how):
    tifffile.imwrite(where + name, data, **how)
    keep(name, data, affine)
for number, dtype in enumerate(('u1', 'i1', '<u2', '>u2', '<i2', '<u4', '>i4', '<f4', '>f4', '<f8')):
    save('%d.tif' % number, volume(dtype), byteorder=dtype[0] if dtype[0] in '<>' else None, photometric='minisblack')
save('big.tif', volume('<u2'), bigtiff=True, photometric='minisblack')
save('zlib.tif', volume('<u2'), compression='zlib', photometric='minisblack')
save('tiles.tif', volume('<u2', (5, 40, 50)), tile=(16, 32), photometric='minisblack')
save('strips.tif', volume('<f4'), rowsperstrip=3, compression='zlib', photometric='minisblack')
save('imagej.tif', volume('<u2'), spacing, imagej=True, resolution=(4, 2), metadata={'spacing': 2, 'unit': 'um', 'axes': 'ZYX'})
save('ome.ome.tif', volume('<u2'), spacing, ome=True, photometric='minisblack',
     metadata={'axes': 'ZYX', 'PhysicalSizeX': 0.25, 'PhysicalSizeY': 0.5, 'PhysicalSizeZ': 2.0})
)"};

// A half float has its value as a float of 32 bits.
const PythonLibrary kMrcfile = {"numpy, mrcfile", "python3-mrcfile", 5 + 1, R"(
import mrcfile
spacing = numpy.diag([0.5, 0.25, 2, 1])
def save(name, data, **how):
    with mrcfile.new(where + name, **how) as file:
        file.set_data(data)
        file.set_volume()
        file.voxel_size = (0.5, 0.25, 2)
    keep(name, data.astype('f4') if data.dtype == numpy.dtype('f2') else data, spacing)
for number, dtype in enumerate(('i1', 'i2', 'u2', 'f2', 'f4')):
    save('%d.mrc' % number, volume(dtype))
save('packed.mrc.gz', volume('i2'), compression='gzip')
)"};

const PythonLibrary kH5py = {"numpy, h5py", "python3-h5py", 10 + 9, R"(
import h5py
def save(name, data, **how):
    with h5py.File(where + name, 'w') as file:
        file.create_dataset('volume', data=data, **how)
    keep(name, data)
for number, dtype in enumerate(('u1', 'i1', '<u2', '>u2', '<i2', '<u4', '>i4', '<f4', '>f4', '<f8')):
    save('%d.h5' % number, volume(dtype))
parts = (5, 6, 7)
save('chunks.h5', volume('<u2'), chunks=parts)
save('gzip.h5', volume('>u2'), chunks=parts, compression='gzip', shuffle=True)
save('lzf.h5', volume('<f4'), chunks=parts, compression='lzf')
save('sums.h5', volume('<i4'), chunks=parts, compression='gzip', fletcher32=True)
save('nbit.h5', volume('<u2') & 1023, chunks=parts, scaleoffset=0)
save('newest.h5', volume('<u2'), chunks=parts, maxshape=(None, 17, 19))
data = volume('<u2')
with h5py.File(where + 'parts.hdf5', 'w') as file:
    file.create_dataset('low', data=data[:6])
    file.create_dataset('high', data=data[6:])
layout = h5py.VirtualLayout(data.shape, data.dtype)
layout[:6] = h5py.VirtualSource('parts.hdf5', 'low', (6, 17, 19))
layout[6:] = h5py.VirtualSource('parts.hdf5', 'high', (7, 17, 19))
with h5py.File(where + 'virtual.h5', 'w') as file:
    file.create_virtual_dataset('volume', layout)
keep('virtual.h5', data)
data.tofile(where + 'outside')
with h5py.File(where + 'external.h5', 'w') as file:
    file.create_dataset('volume', data.shape, data.dtype, external=[('outside', 0, data.nbytes)])
keep('external.h5', data)
with h5py.File(where + 'other.hdf5', 'w') as file:
    file.create_dataset('volume', data=data, chunks=parts, compression='gzip')
with h5py.File(where + 'link.h5', 'w') as file:
    file['volume'] = h5py.ExternalLink('other.hdf5', '/volume')
keep('link.h5', data)
)"};

// Smooth volumes, which codecs compress.
const PythonLibrary kZarr = {"numpy, zarr", "python3-zarr", 5 + 32 + 20 + 5 + 4, R"(
import zarr
from numcodecs import Blosc, GZip, Zlib, Zstd, LZ4, Shuffle, BitRound
def smooth(dtype):
    kind = numpy.dtype(dtype)
    if kind.kind == 'f':
        return volume(dtype)
    ramp = numpy.add.outer(numpy.add.outer(numpy.arange(13) * 5, numpy.arange(17) * 3), numpy.arange(19))
    return (ramp + random.integers(0, 9, (13, 17, 19))).astype(kind)
number = 0
def write(data, voxels=None, **how):
    global number
    name = '%d' % number
    number += 1
    store = zarr.NestedDirectoryStore(where + name) if how.pop('nested', False) else zarr.DirectoryStore(where + name)
    array = zarr.create(data.shape, dtype=data.dtype, store=store, **how)
    array[...] = data
    keep(name, zarr.open(store, mode='r')[...] if voxels is None else voxels)
codecs = [None, GZip(), Zlib(), Zstd(), LZ4()]
codecs += [Blosc(cname, 5, shuffle, blocksize) for cname in ('lz4', 'lz4hc', 'zstd', 'zlib')
           for shuffle in (Blosc.NOSHUFFLE, Blosc.SHUFFLE, Blosc.BITSHUFFLE, Blosc.AUTOSHUFFLE) for blocksize in (0, 300)]
for codec in codecs:
    write(smooth('<u2'), compressor=codec, chunks=(5, 6, 7))
for dtype in ('|u1', '|i1', '>u2', '<i2', '>u4', '<i4', '<f4', '>f4', '<f8', '>f8'):
    for order in 'CF':
        write(smooth(dtype), chunks=(4, 17, 30), order=order, compressor=Blosc('zstd', 3, Blosc.BITSHUFFLE))
write(smooth('<u2'), chunks=(5, 6, 7), nested=True)
write(smooth('<u2'), chunks=(5, 6, 7), dimension_separator='/')
write(smooth('<u4'), chunks=(5, 6, 7), filters=[Shuffle(4)], compressor=Zlib())
write(smooth('<f4'), chunks=(5, 6, 7), filters=[BitRound(5)], compressor=Zstd())
sparse = smooth('<f4')
sparse[:, :12] = numpy.nan
write(sparse, chunks=(5, 6, 7), fill_value=float('nan'), write_empty_chunks=False)
for wide, narrow in (('<i8', '<i4'), ('>u8', '<u4'), ('<f2', '<f4'), ('|b1', '|u1')):
    data = smooth(wide)
    write(data, voxels=data.astype(narrow), chunks=(5, 6, 7))
)"};

// Numbers of the affine are sums of powers of two. Texts of floats have too few digits.
const PythonLibrary kVtk = {"numpy, vtkmodules", "python3-vtk9", 8 * 3 + 4 * 3 + 4 + 8 * 2, R"(
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkIOCore import vtkLZ4DataCompressor, vtkLZMADataCompressor, vtkZLibDataCompressor
from vtkmodules.vtkIOLegacy import vtkStructuredPointsWriter
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
from vtkmodules.util.numpy_support import numpy_to_vtk
spacing, origin = numpy.array((0.5, 0.75, 2)), numpy.array((-12.5, 30, 7.25))
straight, turned = numpy.eye(3), numpy.array([[0., -1, 0], [1, 0, 0], [0, 0, 1]])
def image(data, first=(0, 0, 0), directions=straight):
    out = vtkImageData()
    out.SetExtent(*[end for i in range(3) for end in (first[i], first[i] + data.shape[2 - i] - 1)])
    out.SetSpacing(spacing)
    out.SetOrigin(origin)
    out.SetDirectionMatrix(*directions.ravel())
    values = numpy_to_vtk(data.ravel(), deep=True)
    values.SetName('values')
    out.GetPointData().SetScalars(values)
    affine = numpy.eye(4)
    affine[:3, :3] = directions * spacing
    affine[:3, 3] = origin + affine[:3, :3] @ first
    return out, affine
def write(writer, name, data, affine):
    writer.SetFileName(where + name)
    if not writer.Write():
        sys.exit(name + ' was not written')
    keep(name, data, affine)
def vti(name, data, compressor=None, first=(0, 0, 0), directions=straight, **settings):
    input, affine = image(data, first, directions)
    writer = vtkXMLImageDataWriter()
    writer.SetInputData(input)
    writer.SetCompressor(compressor)
    for setting, value in settings.items():
        getattr(writer, setting)(*value)
    write(writer, name + '.vti', data, affine)
def legacy(name, data, kind):
    input, affine = image(data)
    writer = vtkStructuredPointsWriter()
    writer.SetInputData(input)
    writer.SetFileType(kind)
    write(writer, name + '.vtk', data, affine)
BINARY, APPENDED = 1, 2
for number, dtype in enumerate(('u1', 'i1', 'u2', 'i2', 'u4', 'i4', 'f4', 'f8')):
    data = volume(dtype)
    vti('%d_appended' % number, data, SetDataMode=(APPENDED,), EncodeAppendedDataOff=())
    vti('%d_base64' % number, data, SetDataMode=(APPENDED,), EncodeAppendedDataOn=(), SetHeaderTypeToUInt32=())
    vti('%d_inline' % number, data, SetDataMode=(BINARY,), SetByteOrderToBigEndian=())
    legacy('%d_binary' % number, data, BINARY + 1)
    legacy('%d_text' % number, data if dtype[0] != 'f' else numpy.round(data), BINARY)
for compressor in (vtkZLibDataCompressor, vtkLZ4DataCompressor, vtkLZMADataCompressor):
    name = compressor.__name__
    vti(name + '_raw', volume('u2'), compressor(), SetDataMode=(APPENDED,), EncodeAppendedDataOff=())
    vti(name + '_blocks', volume('f4'), compressor(), SetBlockSize=(1000,))
    vti(name + '_inline', volume('i2'), compressor(), SetDataMode=(BINARY,))
    vti(name + '_wide', volume('f8'), compressor(), SetByteOrderToBigEndian=())
for number, dtype in enumerate(('u1', 'i2')):
    vti('text_%d' % number, volume(dtype), SetDataModeToAscii=())
vti('extent', volume('u2'), first=(4, -3, 7))
vti('turned', volume('u2'), first=(1, 2, 3), directions=turned)
)"};

std::vector<fs::path> volumesIn(const fs::path& folder) {
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".raw") out.push_back(fs::path(entry.path()).replace_extension());
  std::sort(out.begin(), out.end());
  return out;
}

void expectAffine(const std::string& rows, const glm::dmat4& found) {
  std::istringstream in(rows);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) {
      double expected = 0;
      in >> expected;
      EXPECT_EQ(found[column][row], expected) << "row " << row << ", column " << column;
    }
}

void expectReadBack(const fs::path& file) {
  const std::unique_ptr<VolumeSource> source = openSource(file);
  const std::string expected = bytesOf(file.string() + ".raw");
  Extent3 dims;
  std::istringstream(bytesOf(file.string() + ".dims")) >> dims.x >> dims.y >> dims.z;
  EXPECT_EQ(source->info().geometry.dims, dims);
  const std::vector<std::byte> voxels = readWhole(*source);
  ASSERT_EQ(voxels.size(), expected.size());
  EXPECT_TRUE(std::equal(voxels.begin(), voxels.end(), std::as_bytes(std::span(expected)).begin()));
  const fs::path affine = file.string() + ".affine";
  if (fs::exists(affine)) expectAffine(bytesOf(affine), source->info().geometry.world_from_index);
}

void expectAllReadBack(const PythonLibrary& library) {
  const ForeignFiles files;
  if (!runPython(library.modules, files.directory(), std::string(kCommonLines) + library.script,
                 {files.directory().string()}))
    GTEST_SKIP() << library.package << " is not installed";
  const std::vector<fs::path> volumes = volumesIn(files.directory());
  EXPECT_EQ(static_cast<int>(volumes.size()), library.files);
  for (const fs::path& volume : volumes) {
    SCOPED_TRACE(volume.filename().string());
    expectReadBack(volume);
  }
}

TEST(IngestPythonFiles, Nibabel_readsBackExactly) { expectAllReadBack(kNibabel); }
TEST(IngestPythonFiles, Tifffile_readsBackExactly) { expectAllReadBack(kTifffile); }
TEST(IngestPythonFiles, Zarr_readsBackExactly) { expectAllReadBack(kZarr); }
TEST(IngestPythonFiles, Mrcfile_readsBackExactly) { expectAllReadBack(kMrcfile); }
TEST(IngestPythonFiles, Vtk_readsBackExactly) { expectAllReadBack(kVtk); }
#ifdef KILN_TEST_HDF5
// Known: external and virtual data lie beside their file, whatever the variables of the HDF5 library name.
TEST(IngestPythonFiles, H5py_readsBackExactly) {
  const char* const prefixes[] = {"HDF5_EXTFILE_PREFIX", "HDF5_VDS_PREFIX"};
  for (const char* const prefix : prefixes) ::setenv(prefix, "/nowhere", 1);
  expectAllReadBack(kH5py);
  for (const char* const prefix : prefixes) ::unsetenv(prefix);
}
#endif

}  // namespace
}  // namespace kiln::test

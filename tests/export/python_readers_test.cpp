// Exports read by nibabel, tifffile, pyopenvdb and VTK, libraries of their fields. Known because the test made voxels
// and affine; the script compares and prints each difference.
#include <gtest/gtest.h>

#include "base/progress.h"
#include "export/export_store.h"
#include "store/store_reader.h"
#include "support/files/foreign_files.h"
#include "support/system/run_python.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

constexpr Extent3 kVolumeDims = {19, 17, 18};

// v.raw holds the voxels, x fastest, in the type of the command line.
constexpr const char* kComparison = R"(
import sys, numpy
where, dtype = sys.argv[1] + '/', numpy.dtype(sys.argv[2])
expected = numpy.fromfile(where + 'v.raw', dtype).reshape(18, 17, 19)
affine = numpy.array([[-0.5, 0, 0, 12.5], [0, -0.75, 0, -30], [0, 0, 2, 7.25], [0, 0, 0, 1]])
def compare(name, data, found=None):
    if data.dtype.newbyteorder('=') != dtype or not numpy.array_equal(data, expected):
        sys.exit(name + ' has other voxels')
    if found is not None and not numpy.array_equal(found, affine):
        sys.exit(name + ' has the affine ' + str(found))
)";

struct PythonReader {
  const char* modules = "";
  const char* package = "";
  std::vector<const char*> names;
  const char* script = "";
};

const PythonReader kNibabelReader = {"numpy, nibabel", "python3-nibabel", {"v.nii", "v.nii.gz"}, R"(
import nibabel
for name in ('v.nii', 'v.nii.gz'):
    image = nibabel.load(where + name)
    compare(name, numpy.asanyarray(image.dataobj).T, image.affine)
    assert image.header.get_xyzt_units()[0] == 'mm'
)"};

const PythonReader kTifffileReader = {"numpy, tifffile", "python3-tifffile", {"v.tif", "v_##.tif"}, R"(
import glob, tifffile
compare('v.tif', tifffile.imread(where + 'v.tif'))
compare('slices', numpy.stack([tifffile.imread(name) for name in sorted(glob.glob(where + 'v_*.tif'))]))
with tifffile.TiffFile(where + 'v.tif') as file:
    assert file.is_imagej and file.imagej_metadata['spacing'] == 2 and file.imagej_metadata['slices'] == 18
)"};

const PythonReader kVtkReader = {
    "numpy, vtkmodules", "python3-vtk9", {"v.nrrd", "v.mha", "w.mhd", "v.nii", "v.tif"}, R"(
from vtkmodules.vtkIOImage import vtkMetaImageReader, vtkNIFTIImageReader, vtkNrrdReader, vtkTIFFReader
from vtkmodules.util.numpy_support import vtk_to_numpy
for reader, names in ((vtkNrrdReader, ['v.nrrd']), (vtkMetaImageReader, ['v.mha', 'w.mhd']),
                      (vtkNIFTIImageReader, ['v.nii']), (vtkTIFFReader, ['v.tif'])):
    for name in names:
        file = reader()
        file.SetFileName(where + name)
        if reader is vtkTIFFReader:
            file.SetOrientationType(1)  # the first row at y = 0
        file.Update()
        image = file.GetOutput()
        compare(name, vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1]))
        if reader is not vtkTIFFReader and image.GetSpacing() != (0.5, 0.75, 2):
            sys.exit(name + ' has the spacing ' + str(image.GetSpacing()))
)"};

const PythonReader kOpenVdbReader = {"numpy, pyopenvdb", "python3-openvdb", {"v.vdb"}, R"(
import pyopenvdb
grid, voxels = pyopenvdb.read(where + 'v.vdb', 'density'), numpy.zeros((19, 17, 18), dtype)
grid.copyToArray(voxels)
compare('v.vdb', voxels.T)
for place in ((0, 0, 0), (3, 5, 7)):
    if not numpy.allclose(grid.transform.indexToWorld(place), (affine @ (*place, 1))[:3] * (-1, -1, 1), 0, 1e-12):
        sys.exit('v.vdb places ' + str(place) + ' at ' + str(grid.transform.indexToWorld(place)))
)"};

// The affine is that of the script in left, front and top; nibabel's is in right, back and top.
DenseVolume exportedVolumeOf(VoxelType type) {
  DenseVolume out = noise({kVolumeDims, type}, 7, usualRange(type));
  out.geometry.world_from_index = spacingAffine({0.5, 0.75, 2}, {-12.5, 30, 7.25});
  out.geometry.frame = PatientFrame::kLps;
  out.geometry.unit = "mm";
  return out;
}

void expectRead(const PythonReader& reader, VoxelType type, const char* numpy_type) {
  SCOPED_TRACE(numpy_type);
  const ForeignFiles files;
  const DenseVolume volume = exportedVolumeOf(type);
  files.write("v.raw", std::string(reinterpret_cast<const char*>(volume.voxels.data()), volume.voxels.size()));
  const fs::path store = makeStore(volume, std::string("python_") + numpy_type, 16);
  Progress silent;
  for (const char* const name : reader.names) {
    ExportRequest request;
    request.out = files.directory() / name;
    exportStore(StoreReader(store), request, silent);
  }
  if (!runPython(reader.modules, files.directory(), std::string(kComparison) + reader.script,
                 {files.directory().string(), numpy_type}))
    GTEST_SKIP() << reader.package << " is not installed";
}

TEST(ExportPythonReaders, Nibabel_readsVoxelsAffineAndUnit) { expectRead(kNibabelReader, VoxelType::f32, "f4"); }

TEST(ExportPythonReaders, PyOpenVdb_readsVoxelsAndPlaces) { expectRead(kOpenVdbReader, VoxelType::f32, "f4"); }
TEST(ExportPythonReaders, Vtk_readsVoxelsAndSpacing) { expectRead(kVtkReader, VoxelType::u16, "u2"); }
TEST(ExportPythonReaders, Tifffile_readsVoxelsAndSpacing) { expectRead(kTifffileReader, VoxelType::u16, "u2"); }

}  // namespace
}  // namespace kiln::test

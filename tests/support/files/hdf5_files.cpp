#include "support/files/hdf5_files.h"

#include <hdf5.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace kiln::test {
namespace {

hid_t checked(hid_t id) {
  if (id < 0) throw std::runtime_error("the HDF5 library failed");
  return id;
}
void require(herr_t verdict) { checked(verdict); }

/// Closes an identifier at the end of its scope.
class Hdf5Id {
 public:
  Hdf5Id(hid_t id, herr_t (*close)(hid_t)) : id_(checked(id)), close_(close) {}
  ~Hdf5Id() { close_(id_); }
  Hdf5Id(const Hdf5Id&) = delete;
  Hdf5Id& operator=(const Hdf5Id&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

hid_t memoryType(VoxelType type) {
  const hid_t types[] = {H5T_NATIVE_UINT8,  H5T_NATIVE_INT8,  H5T_NATIVE_UINT16, H5T_NATIVE_INT16,
                         H5T_NATIVE_UINT32, H5T_NATIVE_INT32, H5T_NATIVE_FLOAT,  H5T_NATIVE_DOUBLE};
  return types[static_cast<int>(type)];
}

hid_t linksWithGroups() {
  const hid_t out = checked(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(out, 1);
  return out;
}

hid_t layoutOf(const Hdf5Dataset& dataset) {
  const hid_t out = checked(H5Pcreate(H5P_DATASET_CREATE));
  if (dataset.compact) require(H5Pset_layout(out, H5D_COMPACT));
  if (!dataset.chunk.empty()) {
    const std::vector<hsize_t> chunk(dataset.chunk.begin(), dataset.chunk.end());
    require(H5Pset_chunk(out, static_cast<int>(chunk.size()), chunk.data()));
    if (dataset.raw_border) require(H5Pset_chunk_opts(out, H5D_CHUNK_DONT_FILTER_PARTIAL_CHUNKS));
  }
  if (dataset.shuffle) require(H5Pset_shuffle(out));
  if (dataset.scale_offset) require(H5Pset_scaleoffset(out, H5Z_SO_INT, 0));
  if (dataset.deflate) require(H5Pset_deflate(out, static_cast<unsigned>(*dataset.deflate)));
  if (dataset.fletcher32) require(H5Pset_fletcher32(out));
  if (dataset.foreign)
    require(H5Pset_filter(out, dataset.foreign->id, H5Z_FLAG_OPTIONAL, dataset.foreign->values.size(),
                          dataset.foreign->values.data()));
  if (dataset.fill) require(H5Pset_fill_value(out, H5T_NATIVE_DOUBLE, &*dataset.fill));
  return out;
}

// Writes the chunks one by one, encoded by the test; chunks at the border are filled with zeros.
void writeEncoded(hid_t id, const ForeignVolume& volume, const Hdf5Dataset& dataset) {
  const Extent3 n = volume.dims;
  const auto cz = static_cast<std::int64_t>(dataset.chunk[0]), cy = static_cast<std::int64_t>(dataset.chunk[1]),
             cx = static_cast<std::int64_t>(dataset.chunk[2]);
  const std::size_t size = sizeOf(volume.type);
  for (std::int64_t z = 0; z < n.z; z += cz) {
    for (std::int64_t y = 0; y < n.y; y += cy) {
      for (std::int64_t x = 0; x < n.x; x += cx) {
        std::string chunk(static_cast<std::size_t>(cz * cy * cx) * size, '\0');
        for (std::int64_t k = z; k < std::min(z + cz, n.z); ++k) {
          for (std::int64_t j = y; j < std::min(y + cy, n.y); ++j) {
            const VoxelBox row = {{x, j, k}, {std::min(x + cx, n.x), j + 1, k + 1}};
            const std::vector<std::byte> voxels = volume.box(row);
            std::memcpy(&chunk[static_cast<std::size_t>(((k - z) * cy + (j - y)) * cx) * size], voxels.data(),
                        voxels.size());
          }
        }
        const std::string packed = dataset.encode(chunk);
        const hsize_t offset[] = {static_cast<hsize_t>(z), static_cast<hsize_t>(y), static_cast<hsize_t>(x)};
        require(H5Dwrite_chunk(id, H5P_DEFAULT, 0, offset, packed.size(), packed.data()));
      }
    }
  }
}

void setAttribute(hid_t file, const std::string& object, const std::string& name, hid_t type, hid_t space,
                  const void* value) {
  const Hdf5Id owner(H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose);
  const Hdf5Id attribute(H5Acreate2(owner, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  require(H5Awrite(attribute, type, value));
}

}  // namespace

Hdf5File::Hdf5File(const std::filesystem::path& path, std::uint64_t user_block_bytes) {
  // An installed plugin would change the settings of a filter that a test encodes by itself.
  ::setenv("HDF5_PLUGIN_PRELOAD", "::", 1);
  const Hdf5Id plist(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  if (user_block_bytes > 0) require(H5Pset_userblock(plist, user_block_bytes));
  file_ = checked(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, plist, H5P_DEFAULT));
}

Hdf5File::~Hdf5File() { H5Fclose(file_); }

void Hdf5File::add(const std::string& path, const ForeignVolume& volume, const Hdf5Dataset& dataset) {
  std::vector<hsize_t> shape(dataset.shape.begin(), dataset.shape.end());
  if (shape.empty())
    shape = {static_cast<hsize_t>(volume.dims.z), static_cast<hsize_t>(volume.dims.y),
             static_cast<hsize_t>(volume.dims.x)};
  const hid_t memory = memoryType(volume.type);
  const Hdf5Id stored(H5Tcopy(memory), H5Tclose);
  require(H5Tset_order(stored, dataset.big_endian ? H5T_ORDER_BE : H5T_ORDER_LE));
  const Hdf5Id space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
  const Hdf5Id links(linksWithGroups(), H5Pclose), layout(layoutOf(dataset), H5Pclose);
  const Hdf5Id id(H5Dcreate2(file_, path.c_str(), stored, space, links, layout, H5P_DEFAULT), H5Dclose);
  if (dataset.encode)
    writeEncoded(id, volume, dataset);
  else if (dataset.written)
    require(H5Dwrite(id, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, volume.voxels.data()));
}

void Hdf5File::addNumbers(const std::string& path, const std::vector<double>& numbers,
                          const std::vector<std::uint64_t>& shape) {
  std::vector<hsize_t> dims(shape.begin(), shape.end());
  if (dims.empty()) dims.push_back(numbers.size());
  const Hdf5Id space(H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr), H5Sclose);
  const Hdf5Id links(linksWithGroups(), H5Pclose);
  const Hdf5Id id(H5Dcreate2(file_, path.c_str(), H5T_IEEE_F64LE, space, links, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
  require(H5Dwrite(id, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()));
}

void Hdf5File::addVirtual(const std::string& path, const Extent3& dims, const std::string& file,
                          const std::string& source) {
  const hsize_t shape[] = {static_cast<hsize_t>(dims.z), static_cast<hsize_t>(dims.y), static_cast<hsize_t>(dims.x)};
  const Hdf5Id space(H5Screate_simple(3, shape, nullptr), H5Sclose);
  const Hdf5Id layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  require(H5Pset_virtual(layout, space, file.c_str(), source.c_str(), space));
  const Hdf5Id id(H5Dcreate2(file_, path.c_str(), H5T_STD_U16LE, space, H5P_DEFAULT, layout, H5P_DEFAULT), H5Dclose);
}

void Hdf5File::addGroup(const std::string& path) {
  const Hdf5Id links(linksWithGroups(), H5Pclose);
  const Hdf5Id group(H5Gcreate2(file_, path.c_str(), links, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
}

void Hdf5File::link(const std::string& path, const std::string& target) {
  require(H5Lcreate_soft(target.c_str(), file_, path.c_str(), H5P_DEFAULT, H5P_DEFAULT));
}

void Hdf5File::linkOutside(const std::string& path, const std::string& file, const std::string& target) {
  const Hdf5Id links(linksWithGroups(), H5Pclose);
  require(H5Lcreate_external(file.c_str(), target.c_str(), file_, path.c_str(), links, H5P_DEFAULT));
}

void Hdf5File::setScales(const std::string& dataset, const std::vector<std::string>& scales) {
  std::vector<hobj_ref_t> references(scales.size());
  std::vector<hvl_t> lists(scales.size());
  for (std::size_t i = 0; i < scales.size(); ++i) {
    if (scales[i].empty()) continue;
    require(H5Rcreate(&references[i], file_, scales[i].c_str(), H5R_OBJECT, -1));
    lists[i] = {1, &references[i]};
  }
  const hsize_t count = scales.size();
  const Hdf5Id type(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose), space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  setAttribute(file_, dataset, "DIMENSION_LIST", type, space, lists.data());
}

void Hdf5File::setText(const std::string& object, const std::string& name, const std::string& text) {
  const Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  require(H5Tset_size(type, text.size() + 1));
  setAttribute(file_, object, name, type, space, text.c_str());
}

void Hdf5File::setTexts(const std::string& object, const std::string& name, const std::vector<std::string>& texts) {
  const Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  require(H5Tset_size(type, H5T_VARIABLE));
  const hsize_t count = texts.size();
  const Hdf5Id space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  std::vector<const char*> raw;
  for (const std::string& text : texts) raw.push_back(text.c_str());
  setAttribute(file_, object, name, type, space, raw.data());
}

void Hdf5File::setPaddedTexts(const std::string& object, const std::string& name,
                              const std::vector<std::string>& texts) {
  constexpr std::size_t kSize = 8;
  const Hdf5Id type(H5Tcopy(H5T_FORTRAN_S1), H5Tclose);
  require(H5Tset_size(type, kSize));
  const hsize_t count = texts.size();
  const Hdf5Id space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  std::string padded;
  for (const std::string& text : texts) padded += text + std::string(kSize - text.size(), ' ');
  setAttribute(file_, object, name, type, space, padded.data());
}

void Hdf5File::setLetters(const std::string& object, const std::string& name, const std::string& text) {
  const hsize_t count = text.size();
  const Hdf5Id space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  setAttribute(file_, object, name, H5T_C_S1, space, text.data());
}

void Hdf5File::setNumbers(const std::string& object, const std::string& name, const std::vector<double>& numbers) {
  const hsize_t count = numbers.size();
  const Hdf5Id space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  setAttribute(file_, object, name, H5T_NATIVE_DOUBLE, space, numbers.data());
}

}  // namespace kiln::test

// A worker (base/worker_loop.h) that reads an HDF5 file: hdf5_reader MEMORY_BYTES SECONDS FILE.
// Requests: ingest/hdf5/hdf5_protocol.h.
#include <hdf5.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/worker_loop.h"
#include "ingest/hdf5/hdf5_protocol.h"

namespace {

using kiln::WorkerRefusal;
using kiln::hdf5::ChunkEntry;
using kiln::hdf5::Request;
using nlohmann::json;

// Few enough for Kiln to read the description within its limits of JSON.
constexpr std::size_t kMostObjects = 20'000, kMostValues = 4096, kMostCoordinates = 60'000;

/// An identifier of the library, closed at the end of its scope.
class Id {
 public:
  Id(hid_t id, herr_t (*close)(hid_t), const char* what) : id_(id), close_(close) {
    if (id < 0) throw WorkerRefusal(std::string("the HDF5 library cannot read ") + what);
  }
  ~Id() { close_(id_); }
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void require(bool ok, const char* what) {
  if (!ok) throw WorkerRefusal(std::string("the HDF5 library cannot read ") + what);
}

// Whole numbers and floats that fill their bytes. Anything else the library converts.
json typeOf(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  if (kind == H5T_ENUM) {
    const Id base(H5Tget_super(type), H5Tclose, "the type of an enumeration");
    return typeOf(base);
  }
  const std::size_t bytes = H5Tget_size(type);
  const bool whole = kind == H5T_INTEGER, floating = kind == H5T_FLOAT;
  if (!whole && !floating) return nullptr;
  const bool size_is_power = bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8;
  const H5T_order_t order = H5Tget_order(type);
  bool plain = size_is_power && H5Tget_precision(type) == 8 * bytes && H5Tget_offset(type) == 0 &&
               (order == H5T_ORDER_LE || order == H5T_ORDER_BE || order == H5T_ORDER_NONE);
  if (floating) {
    const hid_t standard[] = {H5T_IEEE_F32LE, H5T_IEEE_F32BE, H5T_IEEE_F64LE, H5T_IEEE_F64BE};
    const bool ieee =
        std::any_of(std::begin(standard), std::end(standard), [&](hid_t s) { return H5Tequal(type, s) > 0; });
    std::size_t sign, exponent, exponent_size, mantissa, mantissa_size;
    const bool half =
        bytes == 2 && H5Tget_fields(type, &sign, &exponent, &exponent_size, &mantissa, &mantissa_size) >= 0 &&
        sign == 15 && exponent == 10 && exponent_size == 5 && mantissa_size == 10 && H5Tget_ebias(type) == 15;
    plain = plain && (ieee || half);
  }
  const char* const name = floating ? "float" : H5Tget_sign(type) == H5T_SGN_NONE ? "uint" : "int";
  return {{"name", name + std::to_string(8 * bytes)}, {"big", order == H5T_ORDER_BE}, {"plain", plain}};
}

// The type in memory in which the library gives values of `type` to Kiln.
hid_t nativeOf(hid_t type) {
  const std::size_t bytes = H5Tget_size(type);
  if (H5Tget_class(type) == H5T_FLOAT) return bytes > 4 ? H5T_NATIVE_DOUBLE : H5T_NATIVE_FLOAT;
  const bool is_unsigned = H5Tget_sign(type) == H5T_SGN_NONE;
  if (bytes == 1) return is_unsigned ? H5T_NATIVE_UINT8 : H5T_NATIVE_INT8;
  if (bytes == 2) return is_unsigned ? H5T_NATIVE_UINT16 : H5T_NATIVE_INT16;
  if (bytes <= 4) return is_unsigned ? H5T_NATIVE_UINT32 : H5T_NATIVE_INT32;
  return is_unsigned ? H5T_NATIVE_UINT64 : H5T_NATIVE_INT64;
}

std::string shownNative(hid_t native) {
  const char* const name = H5Tget_class(native) == H5T_FLOAT     ? "float"
                           : H5Tget_sign(native) == H5T_SGN_NONE ? "uint"
                                                                 : "int";
  return name + std::to_string(8 * H5Tget_size(native));
}

std::vector<hsize_t> dimsOf(hid_t space) {
  const int axes = H5Sget_simple_extent_ndims(space);
  std::vector<hsize_t> out(axes > 0 ? static_cast<std::size_t>(axes) : 0);
  if (axes > 0) H5Sget_simple_extent_dims(space, out.data(), nullptr);
  return out;
}

// JSON has no NaN and no infinity.
json numberOf(double number) {
  if (number != number) return "NaN";
  if (number - number != 0) return number > 0 ? "Infinity" : "-Infinity";
  return number;
}

json numbersOf(const std::vector<double>& numbers) {
  json out = json::array();
  for (const double number : numbers) out.push_back(numberOf(number));
  return out;
}

json textsOf(hid_t attribute, hid_t type, std::size_t count) {
  json out = json::array();
  if (H5Tis_variable_str(type) > 0) {
    const Id memory(H5Tcopy(H5T_C_S1), H5Tclose, "a text");
    H5Tset_size(memory, H5T_VARIABLE);
    H5Tset_cset(memory, H5Tget_cset(type));
    std::vector<char*> texts(count, nullptr);
    if (H5Aread(attribute, memory, texts.data()) < 0) return nullptr;
    for (char* const text : texts) {
      out.push_back(text ? std::string(text, strnlen(text, 4096)) : "");
      H5free_memory(text);
    }
    return out;
  }
  const std::size_t size = H5Tget_size(type);
  if (size == 0 || size > (1 << 16)) return nullptr;
  std::vector<char> texts(count * size);
  const Id memory(H5Tcopy(type), H5Tclose, "a text");
  if (H5Aread(attribute, memory, texts.data()) < 0) return nullptr;
  // Imaris writes a text as a list of letters.
  if (size == 1 && count > 1) return {{"letters", std::string(texts.data(), strnlen(texts.data(), count))}};
  // Fortran pads with spaces.
  const bool padded = H5Tget_strpad(type) == H5T_STR_SPACEPAD;
  for (std::size_t i = 0; i < count; ++i) {
    std::string text(&texts[i * size], strnlen(&texts[i * size], size));
    while (padded && text.ends_with(' ')) text.pop_back();
    out.push_back(std::move(text));
  }
  return out;
}

// Numbers and texts of an attribute; null for anything else and for long lists.
json valueOf(hid_t attribute) {
  const Id type(H5Aget_type(attribute), H5Tclose, "an attribute"),
      space(H5Aget_space(attribute), H5Sclose, "an attribute");
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (count < 1 || count > static_cast<hssize_t>(kMostValues)) return nullptr;
  const auto n = static_cast<std::size_t>(count);
  const H5T_class_t kind = H5Tget_class(type);
  json out;
  if (kind == H5T_STRING) {
    out = textsOf(attribute, type, n);
  } else if (kind == H5T_INTEGER || kind == H5T_FLOAT) {
    std::vector<double> numbers(n);
    if (H5Aread(attribute, H5T_NATIVE_DOUBLE, numbers.data()) < 0) return nullptr;
    out = numbersOf(numbers);
  } else {
    return nullptr;
  }
  return out.is_array() && H5Sget_simple_extent_type(space) == H5S_SCALAR ? out[0] : out;
}

json attributesOf(hid_t object) {
  json out = json::object();
  hsize_t index = 0;
  H5Aiterate2(
      object, H5_INDEX_NAME, H5_ITER_NATIVE, &index,
      [](hid_t of, const char* name, const H5A_info_t*, void* data) -> herr_t {
        auto& all = *static_cast<json*>(data);
        if (all.size() > 256) return 1;
        const hid_t attribute = H5Aopen(of, name, H5P_DEFAULT);
        if (attribute < 0) return 0;
        try {
          all[name] = valueOf(attribute);
        } catch (const std::exception&) {
        }
        H5Aclose(attribute);
        return 0;
      },
      &out);
  return out;
}

// Returns the path of an object that `dataset` refers to; empty if there is none. The library walks the file for it,
// and many data sets share a few scales.
std::string pathOf(hid_t dataset, const hobj_ref_t& reference) {
  static std::map<std::pair<unsigned long, hobj_ref_t>, std::string> known;
  H5O_info_t info;
  if (H5Oget_info(dataset, &info) < 0) return {};
  const auto [found, is_new] = known.try_emplace({info.fileno, reference});
  if (is_new) {
    char name[4096] = {};
    H5Rget_name(dataset, H5R_OBJECT, &reference, name, sizeof name);
    found->second = name;
  }
  return found->second;
}

// The paths of the dimension scales of each axis, as NetCDF writes them; null without scales.
json scalesOf(hid_t dataset, int axes) {
  if (H5Aexists(dataset, "DIMENSION_LIST") <= 0) return nullptr;
  const Id attribute(H5Aopen(dataset, "DIMENSION_LIST", H5P_DEFAULT), H5Aclose, "an attribute"),
      space(H5Aget_space(attribute), H5Sclose, "an attribute"),
      stored(H5Aget_type(attribute), H5Tclose, "an attribute"),
      lists_type(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose, "a list");
  if (H5Sget_simple_extent_npoints(space) != axes || H5Tequal(stored, lists_type) <= 0) return nullptr;
  std::vector<hvl_t> lists(static_cast<std::size_t>(axes));
  if (H5Aread(attribute, lists_type, lists.data()) < 0) return nullptr;
  json out = json::array();
  for (const hvl_t& list : lists)
    out.push_back(list.len > 0 ? pathOf(dataset, *static_cast<const hobj_ref_t*>(list.p)) : "");
  H5Dvlen_reclaim(lists_type, space, H5P_DEFAULT, lists.data());
  return out;
}

// Paths of scales belong to the file of the data set.
json describedDataset(hid_t dataset, bool is_other_file) {
  const Id type(H5Dget_type(dataset), H5Tclose, "a type"), space(H5Dget_space(dataset), H5Sclose, "a shape");
  json out = {{"kind", "dataset"}, {"shape", dimsOf(space)}, {"type", typeOf(type)}};
  json scales = is_other_file ? json() : scalesOf(dataset, H5Sget_simple_extent_ndims(space));
  if (!scales.is_null()) out["scales"] = std::move(scales);
  // Short lists of numbers are coordinates and scales.
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  const H5T_class_t kind = H5Tget_class(type);
  static std::size_t left = kMostCoordinates;
  if (count > 0 && count <= static_cast<hssize_t>(std::min(kMostValues, left)) &&
      H5Sget_simple_extent_ndims(space) <= 2 && (kind == H5T_INTEGER || kind == H5T_FLOAT)) {
    std::vector<double> values(static_cast<std::size_t>(count));
    if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0) {
      out["values"] = numbersOf(values);
      left -= values.size();
    }
  }
  return out;
}

// Returns null for an object that the library cannot open, such as a link that leads nowhere. `file` is the library's
// number of the file that the user named.
json describedObject(hid_t root, const char* name, unsigned long file) {
  const hid_t object = H5Oopen(root, name, H5P_DEFAULT);
  if (object < 0) return nullptr;
  json out;
  try {
    const H5I_type_t kind = H5Iget_type(object);
    if (kind == H5I_DATASET || kind == H5I_GROUP) {
      H5O_info_t info;
      const bool is_other_file = H5Oget_info(object, &info) < 0 || info.fileno != file;
      out = kind == H5I_DATASET ? describedDataset(object, is_other_file) : json{{"kind", "group"}};
      out["attributes"] = attributesOf(object);
    }
  } catch (const std::exception&) {
    out = nullptr;
  }
  H5Oclose(object);
  return out;
}

class Description {
 public:
  explicit Description(hid_t file) {
    H5O_info_t info;
    require(H5Oget_info(file, &info) >= 0, "the root of the file");
    file_ = info.fileno;
  }

  /// True if the user's file, or groups of other files, have more objects than are described.
  bool is_cut = false, are_others_cut = false;

  // Adds the objects below `root` by their first names, then links, also to other files. Returns false if the library
  // cannot read the objects.
  bool addAll(hid_t root) {
    const herr_t visited = H5Ovisit(
        root, H5_INDEX_NAME, H5_ITER_NATIVE,
        [](hid_t of, const char* name, const H5O_info_t*, void* data) -> herr_t {
          return static_cast<Description*>(data)->add(of, name, H5L_TYPE_HARD);
        },
        this);
    H5Lvisit(
        root, H5_INDEX_NAME, H5_ITER_NATIVE,
        [](hid_t of, const char* name, const H5L_info_t* info, void* data) -> herr_t {
          return info->type == H5L_TYPE_HARD ? 0 : static_cast<Description*>(data)->add(of, name, info->type);
        },
        this);
    return visited >= 0;
  }

  // Adds an object that may lie behind a link, and all objects below a group.
  void addNamed(hid_t file, const std::string& path) {
    json named = describedObject(file, path.c_str(), file_);
    if (named.is_null()) return;
    const bool is_group = named["kind"] == "group";
    objects_[path] = std::move(named);
    if (!is_group) return;
    const Id group(H5Oopen(file, path.c_str(), H5P_DEFAULT), H5Oclose, "a group");
    addAllBelow(group, path);
  }

  // Returns pairs of path and object: Kiln's reader of JSON takes time by the square of the members of one object.
  json take() {
    json out = json::array();
    for (auto& [path, object] : objects_.items()) out.push_back(json::array({path, std::move(object)}));
    return out;
  }

 private:
  // The named group and groups of other files get half of the room, so that they cannot make a file unreadable.
  bool isFull() const { return objects_.size() >= (prefix_.empty() ? kMostObjects : kMostObjects / 2); }

  // Returns 0, or 1 to end the walk of the library.
  herr_t add(hid_t root, const std::string& name, H5L_type_t link) {
    if (isFull()) {
      (prefix_.empty() ? is_cut : are_others_cut) = true;
      return 1;
    }
    const std::string path = name != "." ? prefix_ + "/" + name : prefix_.empty() ? "/" : prefix_;
    if (objects_.contains(path)) return 0;
    json described = describedObject(root, name.c_str(), file_);
    if (described.is_null()) return 0;
    if (link == H5L_TYPE_SOFT) described["link"] = true;
    const bool is_group = described["kind"] == "group";
    objects_[path] = std::move(described);
    if (link == H5L_TYPE_EXTERNAL && is_group) addGroupOfOtherFile(root, name, path);
    return 0;
  }

  // Adds the objects below a group of another file, of which several links may lead to one.
  void addGroupOfOtherFile(hid_t root, const std::string& name, const std::string& path) {
    const hid_t group = H5Oopen(root, name.c_str(), H5P_DEFAULT);
    H5O_info_t info;
    if (group >= 0 && H5Oget_info(group, &info) >= 0 && info.fileno != file_ &&
        followed_.emplace(info.fileno, info.addr).second)
      addAllBelow(group, path);
    if (group >= 0) H5Oclose(group);
  }

  void addAllBelow(hid_t group, const std::string& path) {
    const std::string above = std::exchange(prefix_, path);
    addAll(group);
    prefix_ = above;
  }

  unsigned long file_ = 0;  // the library's number of the file that the user named
  json objects_ = json::object();
  std::string prefix_;                                    // path of the named or linked group that is walked
  std::set<std::pair<unsigned long, haddr_t>> followed_;  // groups of other files: file and place
};

// All objects, but first the object at `path`, which other objects must not crowd out.
json describe(hid_t file, const std::string& path) {
  Description out(file);
  if (path.size() > 1) out.addNamed(file, path);
  require(out.addAll(file), "the objects of the file");
  if (path.empty() && out.is_cut)
    throw WorkerRefusal("the file has more than " + std::to_string(kMostObjects) +
                        " objects; name a data set, as FILE:/PATH");
  const bool are_others_cut = out.are_others_cut;
  return {{"objects", out.take()}, {"are_others_cut", are_others_cut}};
}

json fillOf(hid_t plist) {
  H5D_fill_value_t defined;
  if (H5Pfill_value_defined(plist, &defined) < 0 || defined == H5D_FILL_VALUE_UNDEFINED) return nullptr;
  double value = 0;
  if (H5Pget_fill_value(plist, H5T_NATIVE_DOUBLE, &value) < 0) return nullptr;
  return numberOf(value);
}

// Chunks at the border may be stored without any filter, whatever their masks say.
bool leavesBorderUnfiltered(hid_t plist) {
  unsigned options = 0;
  return H5Pget_chunk_opts(plist, &options) >= 0 && (options & H5D_CHUNK_DONT_FILTER_PARTIAL_CHUNKS) != 0;
}

// A table of all chunks in the order of the grid, the last axis fastest; nothing for too many chunks.
std::string tableOf(hid_t file, const std::string& path) {
  const Id dataset(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose, "the data set");
  const Id space(H5Dget_space(dataset), H5Sclose, "its shape"),
      plist(H5Dget_create_plist(dataset), H5Pclose, "its layout");
  const std::vector<hsize_t> dims = dimsOf(space);
  std::vector<hsize_t> chunk(dims.size()), grid;
  require(H5Pget_chunk(plist, static_cast<int>(chunk.size()), chunk.data()) >= 0, "the shape of chunks");
  std::uint64_t count = 1;
  for (std::size_t axis = 0; axis < dims.size(); ++axis) {
    grid.push_back((dims[axis] + chunk[axis] - 1) / chunk[axis]);
    count *= grid.back();
    if (count > kiln::hdf5::kMostListedChunks) return {};
  }
  const bool raw_border = leavesBorderUnfiltered(plist);
  std::string out;
  out.reserve(count * sizeof(ChunkEntry));
  std::vector<hsize_t> at(dims.size(), 0);
  for (std::uint64_t i = 0; i < count; ++i) {
    std::vector<hsize_t> offset(at);
    bool at_border = false;
    for (std::size_t axis = 0; axis < at.size(); ++axis) {
      offset[axis] *= chunk[axis];
      at_border = at_border || offset[axis] + chunk[axis] > dims[axis];
    }
    unsigned mask = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t bytes = 0;
    require(H5Dget_chunk_info_by_coord(dataset, offset.data(), &mask, &address, &bytes) >= 0,
            "the places of the chunks");
    const ChunkEntry entry{address, bytes, raw_border && at_border ? UINT64_MAX : mask};
    out.append(reinterpret_cast<const char*>(&entry), sizeof entry);
    for (std::size_t axis = at.size(); axis-- > 0;) {
      if (++at[axis] < grid[axis]) break;
      at[axis] = 0;
    }
  }
  return out;
}

json filtersOf(hid_t plist) {
  json out = json::array();
  const int count = H5Pget_nfilters(plist);
  for (int i = 0; i < count; ++i) {
    unsigned flags = 0, values[32] = {}, settings = 0;
    std::size_t n = std::size(values);
    const H5Z_filter_t id = H5Pget_filter2(plist, static_cast<unsigned>(i), &flags, &n, values, 0, nullptr, &settings);
    out.push_back({{"id", id}, {"values", std::vector<unsigned>(values, values + std::min(n, std::size(values)))}});
  }
  return out;
}

// Names of the files with the voxels of a virtual or external data set.
json filesOf(hid_t plist, H5D_layout_t layout) {
  std::set<std::string> names;
  char name[4096] = {};
  if (layout == H5D_VIRTUAL) {
    std::size_t count = 0;
    H5Pget_virtual_count(plist, &count);
    for (std::size_t i = 0; i < std::min(count, kMostValues); ++i)
      if (H5Pget_virtual_filename(plist, i, name, sizeof name) > 0) names.insert(name);
  }
  const int external = H5Pget_external_count(plist);
  for (int i = 0; i < external; ++i) {
    off_t offset = 0;
    hsize_t bytes = 0;
    if (H5Pget_external(plist, static_cast<unsigned>(i), sizeof name, name, &offset, &bytes) >= 0) names.insert(name);
  }
  return names;
}

// Returns the name of the file with the data set if an external link leads to another file; else an empty text.
std::string linkedFile(hid_t file, hid_t dataset) {
  H5O_info_t here, there;
  require(H5Oget_info(file, &here) >= 0 && H5Oget_info(dataset, &there) >= 0, "the place of the data set");
  if (here.fileno == there.fileno) return {};
  char name[4096] = {};
  require(H5Fget_name(dataset, name, sizeof name) > 0, "the name of a linked file");
  return std::filesystem::absolute(name).string();
}

std::string layoutOf(hid_t file, const std::string& path) {
  const Id dataset(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose, "the data set");
  const Id type(H5Dget_type(dataset), H5Tclose, "its type"), space(H5Dget_space(dataset), H5Sclose, "its shape");
  const Id plist(H5Dget_create_plist(dataset), H5Pclose, "its layout"),
      file_plist(H5Fget_create_plist(file), H5Pclose, "the file");
  const std::vector<hsize_t> dims = dimsOf(space);
  hsize_t user_block = 0;
  H5Pget_userblock(file_plist, &user_block);
  json out = {{"shape", dims},
              {"type", typeOf(type)},
              {"native", shownNative(nativeOf(type))},
              {"fill", fillOf(plist)},
              {"user_block", user_block}};
  const H5D_layout_t layout = H5Pget_layout(plist);
  const std::string linked = linkedFile(file, dataset);
  // Places in another file are of no use to Kiln: the library reads such a data set.
  out["in_this_file"] = linked.empty();
  if (layout == H5D_CONTIGUOUS) {
    const haddr_t offset = H5Dget_offset(dataset);
    if (offset != HADDR_UNDEF && H5Pget_external_count(plist) <= 0) out["offset"] = offset;
  } else if (layout == H5D_CHUNKED) {
    std::vector<hsize_t> chunk(dims.size());
    require(H5Pget_chunk(plist, static_cast<int>(chunk.size()), chunk.data()) >= 0, "the shape of chunks");
    out["chunk"] = chunk;
    out["filters"] = filtersOf(plist);
  }
  out["files"] = linked.empty() ? filesOf(plist, layout) : json::array({linked});
  return out.dump(-1, ' ', true, json::error_handler_t::replace);
}

// A data set that is read again and again stays open.
class OpenDataset {
 public:
  hid_t at(hid_t file, const std::string& path) {
    if (id_ >= 0 && path == path_) return id_;
    if (id_ >= 0) H5Dclose(id_);
    // External files lie beside the file, as virtual sources do; by default the library takes the working directory.
    const Id plist(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose, "the properties of an access");
    H5Pset_efile_prefix(plist, "${ORIGIN}");
    id_ = H5Dopen2(file, path.c_str(), plist);
    path_ = path;
    require(id_ >= 0, "the data set");
    return id_;
  }

 private:
  hid_t id_ = -1;
  std::string path_;
};

std::string readBox(hid_t file, OpenDataset& open, const std::string& payload) {
  const std::size_t nul = payload.find('\0');
  if (nul == std::string::npos) throw WorkerRefusal("a request without a path");
  const hid_t dataset = open.at(file, payload.substr(0, nul));
  const Id type(H5Dget_type(dataset), H5Tclose, "its type"), space(H5Dget_space(dataset), H5Sclose, "its shape");
  const std::size_t axes = dimsOf(space).size();
  if (payload.size() - nul - 1 != 2 * axes * sizeof(std::int64_t)) throw WorkerRefusal("a request of another shape");
  std::vector<hsize_t> first(axes), count(axes);
  hsize_t total = 1;
  for (std::size_t i = 0; i < axes; ++i) {
    std::int64_t range[2];
    std::memcpy(range, payload.data() + nul + 1 + i * sizeof range, sizeof range);
    first[i] = static_cast<hsize_t>(range[0]);
    count[i] = static_cast<hsize_t>(range[1] - range[0]);
    total *= count[i];
  }
  const Id memory(H5Screate_simple(static_cast<int>(axes), count.data(), nullptr), H5Sclose, "a box");
  require(H5Sselect_hyperslab(space, H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr) >= 0, "a box");
  const hid_t native = nativeOf(type);
  std::string out(total * H5Tget_size(native), '\0');
  require(H5Dread(dataset, native, memory, space, H5P_DEFAULT, out.data()) >= 0, "the voxels");
  return out;
}

}  // namespace

int main(int count, char** arguments) {
  const kiln::WorkerArguments limits = kiln::startWorker(count, arguments);
  if (limits.next == nullptr) return 2;
  // Kiln stamps the files that a virtual or external data set names, so that no variable may choose other files.
  for (const char* const prefix : {"HDF5_EXTFILE_PREFIX", "HDF5_VDS_PREFIX"}) ::unsetenv(prefix);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const hid_t file = H5Fopen(limits.next, H5F_ACC_RDONLY, H5P_DEFAULT);
  OpenDataset open;
  kiln::serveRequests(limits, [&](std::uint32_t kind, const std::string& payload) {
    require(file >= 0, "the file; it is damaged, cut, or open in a program that writes to it");
    switch (static_cast<Request>(kind)) {
      case Request::kDescribe:
        return describe(file, payload).dump(-1, ' ', true, json::error_handler_t::replace);
      case Request::kLayout:
        return layoutOf(file, payload);
      case Request::kTable:
        return tableOf(file, payload);
      case Request::kRead:
        break;
    }
    return readBox(file, open, payload);
  });
}

// 1024 bytes, then an extended header of any length. The cell's lengths over its counts of samples are the edges of a
// voxel. Columns, rows and sections may follow the cell's axes in any order.
// Source: MRC2014, ccpem.ac.uk/mrc_format/mrc2014.php, which CCP4's maplib shares; for the sign of bytes and of the
// origin IMOD's bio3d.colorado.edu/imod/doc/mrc_format.txt.
#include "ingest/mrc/mrc_header.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>

namespace kiln {
namespace {

constexpr std::size_t kMrcHeaderBytes = 1024;

// Offsets of the fields. unit: bytes.
constexpr std::size_t kDims = 0, kMode = 12, kStart = 16, kSampleCounts = 28, kCell = 40, kAngles = 52, kMap = 64,
                      kLeast = 76, kMost = 80, kSpaceGroup = 88, kExtended = 92, kImodStamp = 152, kImodFlags = 156,
                      kOrigin = 196, kStamp = 212;
constexpr std::int32_t kImod = 1146047817, kImodSigned = 1, kImodOriginAsHere = 4;
constexpr std::int32_t kFirstGroupOfStacks = 401, kLastGroupOfStacks = 630;

std::array<std::int32_t, 3> threeIntegers(const HeaderBytes& bytes, std::size_t at) {
  return {bytes.get<std::int32_t>(at), bytes.get<std::int32_t>(at + 4), bytes.get<std::int32_t>(at + 8)};
}
bool isFinite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Old programs leave the order of axes at 0.
std::array<std::int32_t, 3> axesOf(const HeaderBytes& bytes) {
  const auto axes = threeIntegers(bytes, kMap);
  return axes == std::array<std::int32_t, 3>{} ? std::array<std::int32_t, 3>{1, 2, 3} : axes;
}
bool isOrder(const std::array<std::int32_t, 3>& axes) {
  int seen = 0;
  for (const std::int32_t axis : axes) seen |= axis >= 1 && axis <= 3 ? 1 << axis : 0;
  return seen == 0b1110;
}

// True if the numbers make sense in the present byte order.
bool isPlausible(const HeaderBytes& bytes) {
  const auto mode = bytes.get<std::int32_t>(kMode);
  return mode >= 0 && mode <= 101 && isOrder(axesOf(bytes)) && bytes.get<std::int32_t>(kDims) > 0;
}

// The stamp is 0x44 0x44 or 0x44 0x41 in little-endian files, and 0x11 0x11 in big-endian files. Some writers leave the
// stamp empty or wrong: an order in which the numbers make no sense is not taken.
void findByteOrder(HeaderBytes& bytes) {
  const bool stamped_big = bytes.holds(kStamp, "\x11");
  bytes.setBigEndian(stamped_big);
  if (isPlausible(bytes)) return;
  bytes.setBigEndian(!stamped_big);
  if (!isPlausible(bytes)) bytes.setBigEndian(stamped_big);
}

bool isImod(const HeaderBytes& bytes, std::int32_t flag) {
  return bytes.get<std::int32_t>(kImodStamp) == kImod && (bytes.get<std::int32_t>(kImodFlags) & flag) == 0;
}

// The bytes of mode 0 are signed since 2014. Older files have unsigned bytes, which IMOD's flags or a largest value
// above 127 reveal.
VoxelType byteType(const HeaderBytes& bytes, std::vector<std::string>& notes) {
  const double least = bytes.f32(kLeast), most = bytes.f32(kMost);
  const bool beyond = least >= 0 && most > 127 && most <= 255;
  if (!isImod(bytes, kImodSigned) && !beyond) return VoxelType::i8;
  notes.push_back(fmt::format("its bytes are taken as unsigned, by {}", beyond ? "its largest value" : "IMOD's flags"));
  return VoxelType::u8;
}

StoredType typeOf(const HeaderBytes& bytes, std::vector<std::string>& notes) {
  const auto mode = bytes.get<std::int32_t>(kMode);
  switch (mode) {
    case 0:
      return byteType(bytes, notes);
    case 1:
      return VoxelType::i16;
    case 2:
      return VoxelType::f32;
    case 6:
      return VoxelType::u16;
    case 12:
      return StoredType::half();
    case 3:
    case 4:
      bytes.refuse(fmt::format("holds complex numbers (mode {}); save the real part or the magnitude", mode));
    case 16:
      bytes.refuse("holds RGB colours (mode 16), not one value a voxel");
    case 101:
      bytes.refuse("holds 4-bit integers (mode 101), which Kiln does not read; save it as mode 0 or 6");
    default:
      bytes.fail("byte 12", fmt::format("mode {} is not one of MRC's; 0, 1, 2, 6 and 12 are read", mode));
  }
}

// Exactly 0 for a right angle. unit: degrees.
double cosine(double angle) { return angle == 90 ? 0 : std::cos(angle * std::numbers::pi / 180); }

// Sets unit vectors along the cell's axes. Programs for microscopes leave the angles at 0.
void takeAngles(const HeaderBytes& bytes, MrcHeader& out) {
  const glm::dvec3 angles = bytes.vector(kAngles);
  if (angles == glm::dvec3(0) || angles == glm::dvec3(90)) return;
  for (int i = 0; i < 3; ++i) {
    if (!(angles[i] > 0 && angles[i] < 180))
      bytes.fail(fmt::format("byte {}", kAngles + 4 * static_cast<std::size_t>(i)),
                 fmt::format("an angle of the cell is {} degrees; 0 to 180 are legal", angles[i]));
  }
  const double cos_a = cosine(angles.x), cos_b = cosine(angles.y), cos_c = cosine(angles.z);
  const double sin_c = std::sqrt(1 - cos_c * cos_c), y = (cos_a - cos_b * cos_c) / sin_c;
  const double square = 1 - cos_b * cos_b - y * y;
  if (!(square > 0)) bytes.fail("byte 52", "the angles of the cell enclose no volume");
  out.right_angles = false;
  out.step = {glm::dvec3(1, 0, 0), glm::dvec3(cos_c, sin_c, 0), glm::dvec3(cos_b, y, std::sqrt(square))};
}

void takeCell(const HeaderBytes& bytes, MrcHeader& out) {
  const glm::dvec3 cell = bytes.vector(kCell);
  const auto samples = threeIntegers(bytes, kSampleCounts);
  takeAngles(bytes, out);
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!(cell[static_cast<int>(axis)] > 0) || !isFinite(cell) || samples[axis] < 1) return;
  out.has_cell = true;
  for (std::size_t axis = 0; axis < 3; ++axis) out.step[axis] *= cell[static_cast<int>(axis)] / samples[axis];
}

// The origin takes precedence over the start, which counts voxels from the cell's corner.
void takeOrigin(const HeaderBytes& bytes, MrcHeader& out) {
  const auto start = threeIntegers(bytes, kStart);
  for (std::size_t i = 0; i < 3; ++i)
    out.origin += static_cast<double>(start[i]) * out.step[static_cast<std::size_t>(out.cell_axis[i])];
  const glm::dvec3 written = bytes.vector(kOrigin);
  if (written == glm::dvec3(0) || !isFinite(written)) return;
  const glm::dvec3 origin = isImod(bytes, kImodOriginAsHere) ? -written : written;
  if (out.origin != glm::dvec3(0) && glm::distance(out.origin, origin) > glm::length(out.step[0]) / 2)
    out.notes.push_back("its origin and its start place it differently; the origin is taken");
  out.origin = origin;
}

// A stack of volumes has space groups of its own; the cell then counts the sections of one volume.
std::int64_t sectionsOfVolume(const HeaderBytes& bytes, std::int64_t sections) {
  const auto group = bytes.get<std::int32_t>(kSpaceGroup), of_cell = bytes.get<std::int32_t>(kSampleCounts + 8);
  if (group < kFirstGroupOfStacks || group > kLastGroupOfStacks) return sections;
  if (of_cell < 1 || sections % of_cell != 0)
    bytes.fail("byte 36", fmt::format("a stack of volumes has {} sections, which are not volumes of {} sections",
                                      sections, of_cell));
  return of_cell;
}

}  // namespace

MrcHeader readMrcHeader(const std::filesystem::path& path) {
  HeaderBytes bytes = readHeaderBytes(path, kMrcHeaderBytes);
  findByteOrder(bytes);
  MrcHeader out;
  out.big_endian = bytes.bigEndian();
  out.in_gzip = bytes.inGzip();
  const auto dims = threeIntegers(bytes, kDims);
  for (std::size_t i = 0; i < 3; ++i) {
    if (dims[i] < 1)
      bytes.fail(fmt::format("byte {}", kDims + 4 * i),
                 fmt::format("{} voxels along an axis; 1 or more are legal", dims[i]));
  }
  out.dims = {dims[0], dims[1], dims[2]};
  out.type = typeOf(bytes, out.notes);
  const auto axes = axesOf(bytes);
  if (!isOrder(axes))
    bytes.fail("byte 64", fmt::format("the order of axes is {}, {}, {}; 1, 2 and 3 in some order are legal", axes[0],
                                      axes[1], axes[2]));
  for (std::size_t i = 0; i < 3; ++i) out.cell_axis[i] = axes[i] - 1;
  takeCell(bytes, out);
  takeOrigin(bytes, out);
  out.sections_of_volume = sectionsOfVolume(bytes, dims[2]);
  const auto extended = bytes.get<std::int32_t>(kExtended);
  if (extended < 0) bytes.fail("byte 92", fmt::format("the extended header has {} bytes", extended));
  out.end_offset = kMrcHeaderBytes + static_cast<std::uint64_t>(extended);
  return out;
}

}  // namespace kiln

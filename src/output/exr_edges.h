// The layers of a partial image's edges as a part of its EXR: deep scanlines with R G B A and `coverage`, without
// depths, behind the flat picture that programs read which know of no parts. Not installed: it names OpenEXR.
#pragma once

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>

#include <memory>

#include "base/edge_layers.h"

namespace kiln {

inline constexpr const char* kEdgesPart = "edges";

/// Of the same windows and attributes as the flat picture's.
Imf::Header edgesHeader(Imf::Header flat);
/// The part of that number. throws: what OpenEXR throws.
void writeEdges(const EdgeLayers& edges, Imf::MultiPartOutputFile& file, int part);
/// The layers of pixels counted from the data window's first; null where the file has no such part. throws: what
/// OpenEXR throws, std::runtime_error, also where the part is not of `width` × `height` pixels, or has more layers than
/// `memory_bytes` hold.
std::shared_ptr<EdgeLayers> readEdges(Imf::MultiPartInputFile& file, int width, int height, std::uint64_t memory_bytes);
/// throws: std::runtime_error where a row of a deep part has more samples than `memory_bytes` hold; what OpenEXR
/// throws.
void requireRowsWithin(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes);
/// Reads every sample of a deep part, a row at a time in at most `memory_bytes`. throws: as readEdges.
void checkDeepPart(Imf::MultiPartInputFile& file, int part, std::uint64_t memory_bytes);

}  // namespace kiln

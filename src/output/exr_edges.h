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
/// Of pixels counted from the data window's first; null where the file has no such part. throws: what OpenEXR throws,
/// std::runtime_error, also where the part is not of `width` × `height` pixels.
std::shared_ptr<EdgeLayers> readEdges(Imf::MultiPartInputFile& file, int width, int height);
/// Reads every sample of a deep part. throws: as readEdges.
void checkDeepPart(Imf::MultiPartInputFile& file, int part);

}  // namespace kiln

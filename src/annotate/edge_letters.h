// The patient's sides as letters at the middles of a picture's edges.
#pragma once

#include <vector>

#include "annotate/drawing.h"
#include "grid/slice_view.h"
#include "image/image.h"

namespace kiln {

/// Shortest side of a picture that has letters: on smaller pictures letters would hide what the picture shows. unit:
/// pixels.
inline constexpr int kLeastLetteredSide = 32;

/// Returns the space that the letters take at each edge; 0 on a small picture. unit: pixels.
int edgeLetterRoom(const ImageSize& size);

/// Returns the shapes of the letters; nothing without letters or on a small picture. throws: Error kUnsupported without
/// a font.
std::vector<Shape> edgeLetterShapes(const EdgeLetters& letters, const ImageSize& size);

/// Draws the letters over a picture.
void drawEdgeLetters(const EdgeLetters& letters, Image& image);
/// Appends the letters as planes of an EXR, as Annotator::addPlanes.
void addEdgeLetterPlanes(const EdgeLetters& letters, Image& image);

}  // namespace kiln

// Parameters shared by the samples of a zone, in the form that kernels need.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "engine/shared/plain_light.h"
#include "engine/shared/shade.h"
#include "scene/render_options.h"

namespace kiln {

struct SampleLattice {
  Interpolation interpolation = Interpolation::kLinear;
  int label_smoothing = 0;  // reach of the opacity smoothing in a label volume. unit: voxels
  bool perspective = false;
  float focal = 1;      // unit: pixels per x/z; orthographic: pixels per world unit
  float thickness = 1;  // thickness of a slab. unit: world
  // Classification table, see SampleTable.
  const float* table = nullptr;        // shape: entries of r, g, b, tau
  const float* extinctions = nullptr;  // shape: entries
  float table_scale = 1, table_last = 0;
  // Table of the colours of a companion's values; null: samples have colours of the table above. With `color_nearest` a
  // sample has the colour of the nearest voxel.
  const float* color_table = nullptr;
  float color_last = 0;
  bool color_nearest = false;
  // Extinction is zero outside these table positions.
  float visible_after = -1, visible_before = 3e38f;
  // Integral of extinction, for levels where a sample stands for an interval of values; null if a sample is a point.
  const float* integral = nullptr;
  float least_interval = 1;
  // Factors of opacity over values and gradients: see PlaneTable.
  struct Plane {
    const float* factors = nullptr;  // null: none
    const float* colors = nullptr;   // null: colours do not depend on gradients
    int stride = 0;
    float column_scale = 0, column_offset = 0, last_column = 0;  // unit: columns per entry of the table, columns
    float row_offset = 0, last_row = 0;                          // unit: rows
    glm::mat3 rows_from_slope{1};  // a vector of a gradient's length in rows. unit: rows per (value per voxel)
    float unit = 1;                // length that opacities refer to. unit: world
  } plane;
  // Values of iso-surfaces, less the table's offset, in ascending order, and the opacity of each; 0: samples are
  // classified.
  int surfaces = 0;
  const float* surface_values = nullptr;
  const float* surface_opacities = nullptr;
  bool points_on_faces = false;  // points on cut faces are samples of their own (CutFaces)
  // Without phong if there are `lights`.
  PlainLight light;
  const Shader* lights = nullptr;  // other lights than a white headlight; null: none
  float near = 0;                  // depth at which the zone begins. unit: world
};

}  // namespace kiln

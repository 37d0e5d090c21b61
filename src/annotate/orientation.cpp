// The directions of the world in the lower left corner, as seen along the view. A patient's directions are letters at
// both ends of three lines, other worlds have arrows. Directions away from the eye are dim and lie below.
#include "annotate/orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>
#include <optional>
#include <string_view>
#include <vector>

#include "annotate/drawing.h"
#include "annotate/font.h"
#include "annotate/places.h"

namespace kiln {
namespace {

// unit: the font's size.
constexpr double kLine = 0.14, kHead = 0.6, kHeadWidth = 0.42, kAside = 1.1, kLetterRoom = 1.1;
constexpr double kDim = 0.5;
// Length below which a direction's letter would lie over the middle of the marker. Towards the eye the letter stands
// aside, away from the eye a patient's letter is left out: its place is the place of the letter in front.
constexpr double kShort = 0.4;

// Colours of x, y and z: linear light, of equal lightness to the eye.
constexpr std::array<glm::dvec3, 3> kAxisColors = {{{0.82, 0.10, 0.08}, {0.12, 0.50, 0.10}, {0.10, 0.25, 0.90}}};

// Writes a letter around its middle.
void letterAt(std::string_view letter, const glm::dvec2& middle, double opacity, Drawing& drawing) {
  const double size = drawing.style().em;
  drawing.text(letter, {middle.x, middle.y + 0.5 * kCapHeight * size}, size, Drawing::Align::kCentre, opacity);
}

// Returns the unit vector that is farthest from all directions that are not short.
glm::dvec2 besideAll(const std::vector<Direction>& directions) {
  constexpr int kTurns = 16;
  glm::dvec2 best(0);
  double least = 2;  // the cosine of the nearest direction
  for (int i = 0; i < kTurns; ++i) {
    // The upper right is tried first.
    const double angle = 2 * std::numbers::pi * (i + 2) / kTurns;
    const glm::dvec2 candidate(std::cos(angle), -std::sin(angle));
    double nearest = -1;
    for (const Direction& direction : directions) {
      const glm::dvec2 seen(direction.seen);
      if (glm::length(seen) >= kShort) nearest = std::max(nearest, glm::dot(candidate, glm::normalize(seen)));
    }
    if (nearest < least - 1e-9) least = nearest, best = candidate;
  }
  return best;
}

}  // namespace

std::vector<Direction> directionsOf(const AnnotatedPicture& picture) {
  static constexpr std::array<std::string_view, 6> kAxes = {"x", "y", "z", "", "", ""};
  static constexpr std::array<std::string_view, 6> kLps = {"L", "P", "S", "R", "A", "I"};
  static constexpr std::array<std::string_view, 6> kRas = {"R", "A", "S", "L", "P", "I"};
  const PatientFrame frame = picture.box.frame;
  const auto& names = frame == PatientFrame::kUnknown ? kAxes : frame == PatientFrame::kLps ? kLps : kRas;
  const glm::dmat3 turned(picture.view.view_from_world);
  std::vector<Direction> out;
  for (int i = 0; i < 6; ++i) {
    const std::string_view name = names[static_cast<std::size_t>(i)];
    if (!name.empty()) out.push_back({name, i % 3, (i < 3 ? 1.0 : -1.0) * turned[i % 3]});
  }
  std::stable_sort(out.begin(), out.end(), [](const Direction& a, const Direction& b) { return a.seen.z > b.seen.z; });
  return out;
}

glm::dvec2 middleOfDirections(const AnnotatedPicture& picture, const Style& style) {
  const Room room = placeOfDirections(picture, style);
  return {(room.x0 + room.x1) / 2, (room.y0 + room.y1) / 2};
}

std::vector<std::optional<glm::dvec2>> letterPlaces(const AnnotatedPicture& picture,
                                                    const std::vector<Direction>& directions, const Style& style) {
  const bool patient = picture.box.frame != PatientFrame::kUnknown;
  const glm::dvec2 middle = middleOfDirections(picture, style);
  std::vector<std::optional<glm::dvec2>> out(directions.size());
  for (std::size_t i = directions.size(); i-- > 0;) {
    const glm::dvec2 seen(directions[i].seen);
    const double length = glm::length(seen);
    if (patient && directions[i].seen.z > 1e-9 && length < kShort) continue;
    const bool is_short = length < kShort;
    glm::dvec2 place = is_short ? middle + kAside * style.em * besideAll(directions)
                                : middle + style.em * (kArmLength * seen + kLetterGap * (seen / length));
    // Upwards, or to the right of an upright direction.
    glm::dvec2 across = is_short ? glm::dvec2(0, -1) : glm::dvec2(seen.y, -seen.x) / length;
    if (across.y > 1e-9 || (across.y > -1e-9 && across.x < 0)) across = -across;
    for (std::size_t nearer = directions.size(); --nearer > i;) {
      const std::optional<glm::dvec2>& other = out[nearer];
      if (other && glm::distance(place, *other) < kLetterRoom * style.em)
        place = *other + kLetterRoom * style.em * across;
    }
    out[i] = place;
  }
  return out;
}

void addAxes(const AnnotatedPicture& picture, Drawing& drawing) {
  const Style& style = drawing.style();
  const bool patient = picture.box.frame != PatientFrame::kUnknown;
  const glm::dvec2 middle = middleOfDirections(picture, style);
  const std::vector<Direction> directions = directionsOf(picture);
  const std::vector<std::optional<glm::dvec2>> letters = letterPlaces(picture, directions, style);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const Direction& direction = directions[i];
    const glm::dvec2 seen(direction.seen);
    const bool behind = direction.seen.z > 1e-9;
    const glm::dvec2 tip = middle + kArmLength * style.em * seen;
    const double opacity = behind ? kDim : 1;
    if (patient)
      drawing.ink(stroke(middle, tip, kLine * style.em), opacity);
    else
      drawing.fill(arrow(middle, tip, kLine * style.em, kHead * style.em, kHeadWidth * style.em),
                   kAxisColors[static_cast<std::size_t>(direction.axis)], 1);
    if (letters[i]) letterAt(direction.name, *letters[i], patient ? opacity : 1, drawing);
  }
}

}  // namespace kiln

// DejaVu Sans, compiled in, by FreeType: the module that annotate/font_module.cpp loads. Outlines are in the font's own
// whole units, before any rounding to pixels, so that no version of FreeType changes them.
#include <freetype/freetype.h>
#include <freetype/ftoutln.h>

#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "annotate/font.h"
#include "base/error.h"

// The font's bytes, from the file that the build found.
asm(".pushsection .rodata\n"
    ".balign 16\n"
    "kiln_font_begin:\n"
    ".incbin \"" KILN_FONT_FILE
    "\"\n"
    "kiln_font_end:\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" const unsigned char kiln_font_begin[] __attribute__((visibility("hidden")));
extern "C" const unsigned char kiln_font_end[] __attribute__((visibility("hidden")));

namespace kiln {
namespace {

// Lines that a curve becomes: a letter of 200 pixels is within a twentieth of a pixel.
constexpr int kLinesOfCurve = 8;

struct Tracer {
  Outline& outline;
  double unit;
  glm::dvec2 at{0};

  glm::dvec2 placed(const FT_Vector& p) const {
    return unit * glm::dvec2(static_cast<double>(p.x), -static_cast<double>(p.y));
  }
  void add(const glm::dvec2& p) { outline.back().push_back(at = p); }
};

Tracer& tracerOf(void* user) { return *static_cast<Tracer*>(user); }

int moveTo(const FT_Vector* to, void* user) {
  tracerOf(user).outline.emplace_back();
  tracerOf(user).add(tracerOf(user).placed(*to));
  return 0;
}
int lineTo(const FT_Vector* to, void* user) {
  tracerOf(user).add(tracerOf(user).placed(*to));
  return 0;
}
int conicTo(const FT_Vector* control, const FT_Vector* to, void* user) {
  Tracer& tracer = tracerOf(user);
  const glm::dvec2 a = tracer.at, b = tracer.placed(*control), c = tracer.placed(*to);
  for (int i = 1; i <= kLinesOfCurve; ++i) {
    const double t = static_cast<double>(i) / kLinesOfCurve, u = 1 - t;
    tracer.add(u * u * a + 2 * u * t * b + t * t * c);
  }
  return 0;
}
int cubicTo(const FT_Vector* first, const FT_Vector* second, const FT_Vector* to, void* user) {
  Tracer& tracer = tracerOf(user);
  const glm::dvec2 a = tracer.at, b = tracer.placed(*first), c = tracer.placed(*second), d = tracer.placed(*to);
  for (int i = 1; i <= kLinesOfCurve; ++i) {
    const double t = static_cast<double>(i) / kLinesOfCurve, u = 1 - t;
    tracer.add(u * u * u * a + 3 * u * u * t * b + 3 * u * t * t * c + t * t * t * d);
  }
  return 0;
}

class FreeTypeFont : public Font {
 public:
  FreeTypeFont() {
    require(FT_Init_FreeType(&library_), "starting");
    require(
        FT_New_Memory_Face(library_, kiln_font_begin, static_cast<FT_Long>(kiln_font_end - kiln_font_begin), 0, &face_),
        "opening the font");
  }

  const Letter& letter(char32_t character) const override {
    const std::lock_guard lock(mutex_);
    const auto known = letters_.find(character);
    if (known != letters_.end()) return known->second;
    require(FT_Load_Char(face_, character, FT_LOAD_NO_SCALE | FT_LOAD_NO_HINTING), "loading a letter");
    Letter out;
    const double unit = 1.0 / face_->units_per_EM;
    Tracer tracer{out.outline, unit};
    const FT_Outline_Funcs functions{&moveTo, &lineTo, &conicTo, &cubicTo, 0, 0};
    require(FT_Outline_Decompose(&face_->glyph->outline, &functions, &tracer), "tracing a letter");
    out.advance = unit * static_cast<double>(face_->glyph->metrics.horiAdvance);
    return letters_.emplace(character, std::move(out)).first->second;
  }

  double kerning(char32_t left, char32_t right) const override {
    const std::lock_guard lock(mutex_);
    FT_Vector by{};
    if (!FT_HAS_KERNING(face_)) return 0;
    require(FT_Get_Kerning(face_, FT_Get_Char_Index(face_, left), FT_Get_Char_Index(face_, right), FT_KERNING_UNSCALED,
                           &by),
            "reading the font");
    return static_cast<double>(by.x) / face_->units_per_EM;
  }

 private:
  static void require(FT_Error error, const char* step) {
    if (error != 0)
      throw Error(ErrorCode::kUnsupported, std::string("FreeType failed while ") + step + ": error " +
                                               std::to_string(error) + "; leave annotations with letters out");
  }

  FT_Library library_ = nullptr;
  FT_Face face_ = nullptr;
  mutable std::mutex mutex_;
  mutable std::map<char32_t, Letter> letters_;
};

}  // namespace
}  // namespace kiln

extern "C" [[gnu::visibility("default")]] const kiln::Font* kilnMakeFont() { return new kiln::FreeTypeFont(); }

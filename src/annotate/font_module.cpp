#include "annotate/font.h"
#include "base/error.h"
#include "base/module.h"

namespace kiln {

bool hasFont() {
#ifdef KILN_FONT_MODULE
  return true;
#else
  return false;
#endif
}

const Font& font() {
#ifdef KILN_FONT_MODULE
  using Make = const Font* (*)();
  static const auto make =
      reinterpret_cast<Make>(functionOfModule(KILN_FONT_MODULE, "kilnMakeFont", "no letters can be drawn"));
  // Never destroyed: the module stays loaded.
  static const Font* const font = make();
  return *font;
#else
  throw Error(ErrorCode::kUnsupported,
              "this kiln was built without a font for --scale-bar, --legend, --axes and --text; build it with FreeType "
              "and DejaVu Sans (Debian: libfreetype-dev fonts-dejavu-core)");
#endif
}

}  // namespace kiln

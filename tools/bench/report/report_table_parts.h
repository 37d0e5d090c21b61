// Building blocks of the report's tables: captions, cells, and rows that span a case's image sizes.
#pragma once

#include <fmt/format.h>

#include <string>

#include "bench/measurements.h"
#include "bench/report/report_words.h"
#include "bench/report/svg.h"

namespace kiln {

/// Returns a table with its caption above, as a <figure> that scrolls if it is wider than the page.
inline std::string tableFigure(std::string_view number, std::string_view caption, const std::string& head,
                               const std::string& body) {
  return fmt::format(
      "<figure class=\"table\"><figcaption><b>{}</b> {}</figcaption><div class=\"wide\"><table>\n"
      "<thead>{}</thead>\n<tbody>{}</tbody></table></div></figure>\n",
      number, caption, head, body);
}

inline std::string numberCell(const std::string& text, std::string_view classes = "") {
  return fmt::format("<td class=\"n {}\">{}</td>", classes, text);
}

inline std::string headCell(std::string_view text, std::string_view classes = "") {
  return fmt::format("<th class=\"n {}\">{}</th>", classes, text);
}

/// A cell without a number.
inline const std::string kNoCell = "<td class=\"n paper\">–</td>";

/// "5 views".
inline std::string viewsText(const Suite& suite) {
  return fmt::format("{} view{}", suite.views, suite.views == 1 ? "" : "s");
}

/// Returns rows of cases and image sizes, as in the paper; a case's name spans its rows. `cells` writes the remaining
/// cells of a row; an empty result omits the row.
template <class Cells>
std::string caseRows(const Measurements& m, Cells cells) {
  std::string out;
  for (std::size_t i = 0; i < m.suite.cases.size(); ++i) {
    const SuiteCase& c = m.suite.cases[i];
    bool first = true;
    for (const ImageSize& size : c.sizes) {
      const std::string written = cells(i, size);
      if (written.empty()) continue;
      out += "<tr>";
      if (first) out += fmt::format("<th scope=\"row\" rowspan=\"{}\">{}</th>", c.sizes.size(), escaped(c.name));
      out += fmt::format("<td>{}</td>{}</tr>\n", textOf(size), written);
      first = false;
    }
  }
  return out;
}

}  // namespace kiln

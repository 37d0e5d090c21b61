// The page's style sheet: print-like, for light and dark screens; wide tables scroll separately.
#pragma once

#include <string_view>

namespace kiln {

inline constexpr std::string_view kReportStyle = R"(
:root { color-scheme: light dark; --ink: #1d1d1b; --faint: #6f6e68; --rule: #c9c7bf; --hair: #e6e4dd; --page: #fffefb;
  --plate: #0c0d0f; --mark: #f5efdc; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e6e0; --faint: #9b988f; --rule: #55534d; --hair: #2c2b29;
  --page: #191817; --plate: #060607; --mark: #2f2a1c; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink);
  font: 16.5px/1.55 "Charter", "Bitstream Charter", "Iowan Old Style", "Source Serif 4", "Georgia", serif; }
main { max-width: 76rem; margin: 0 auto; padding: 3.2rem 1.6rem 5rem; }
h1 { font-size: 2.1rem; line-height: 1.15; font-weight: 600; margin: 0 0 .5rem; max-width: 46rem; }
h2 { font-size: 1.3rem; font-weight: 600; margin: 3.4rem 0 .7rem; padding-top: .9rem; border-top: 1px solid var(--rule); }
p, ul, dl { max-width: 46rem; }
p { margin: .55rem 0; }
.by { color: var(--faint); font-size: .95rem; }
.lead { font-size: 1.12rem; line-height: 1.5; border-left: 3px solid var(--ink); padding-left: 1.1rem; margin: 1.6rem 0; }
nav { display: flex; flex-wrap: wrap; margin: 1.6rem 0 0; font-size: .92rem; max-width: 60rem; }
nav a { color: inherit; margin-right: 1.1rem; white-space: nowrap; text-decoration-color: var(--rule); text-underline-offset: .2em; }
figure { margin: 1.9rem 0; }
figcaption { font-size: .92rem; max-width: 54rem; margin: .55rem 0; color: var(--ink); }
figcaption b { font-weight: 600; margin-right: .25em; }
.wide { overflow-x: auto; }
.over { font-size: .9rem; margin: .8rem 0 0; color: var(--faint); }
table { border-collapse: collapse; font-size: .86rem; line-height: 1.35; font-variant-numeric: tabular-nums lining-nums;
  border-top: 1.6px solid var(--ink); border-bottom: 1.6px solid var(--ink); }
th, td { padding: .26rem .5rem; text-align: left; vertical-align: baseline; font-weight: normal; white-space: nowrap; }
thead th { font-size: .8rem; line-height: 1.25; white-space: normal; min-width: 3.4rem; vertical-align: bottom; border-bottom: 1px solid var(--ink); }
thead th.group { text-align: center; border-bottom: 1px solid var(--rule); }
tbody th { font-weight: 600; vertical-align: top; }
tbody tr { border-top: 1px solid var(--hair); }
tbody tr:first-child { border-top: 0; }
tbody tr.rule { border-top: 1px solid var(--ink); }
tbody tr.chosen { background: var(--mark); }
.n { text-align: right; }
.paper { color: var(--faint); font-size: .94em; }
td.note { white-space: normal; overflow-wrap: anywhere; min-width: 10rem; max-width: 22rem; font-size: .95em; }
td b { font-weight: 600; }
.panels { display: flex; flex-wrap: wrap; gap: 1.3rem 1.2rem; align-items: flex-start; margin-bottom: 1.4rem; }
.panel { max-width: 100%; flex: 0 1 auto; }
.panel p { font-size: .84rem; line-height: 1.35; color: var(--faint); margin: .35rem 0 0; }
img { display: block; max-width: 100%; height: auto; }
summary { cursor: pointer; font-size: .95rem; }
img.plate { background: var(--plate); }
img.difference { outline: 1px solid var(--rule); image-rendering: pixelated; }
.swatch { display: inline-block; width: .78em; height: .78em; margin-right: .42em; vertical-align: -.04em; border: 1px solid rgba(128,128,128,.55); }
.swatch.m-none { background: #8a8a84; } .swatch.m-range-tree { background: #0072b2; } .swatch.m-quadtree { background: #d55e00; }
.swatch.m-overlay { background: #009e73; } .swatch.m-mask { background: #a3478c; }
@media (prefers-color-scheme: dark) { .swatch.m-range-tree { background: #56b4e9; } .swatch.m-quadtree { background: #f0843c; }
  .swatch.m-overlay { background: #2ec99a; } .swatch.m-mask { background: #dd8fc9; } }
.swatch.d0 { background: #fff; } .swatch.d1 { background: #ff0; } .swatch.d2 { background: #0f0; } .swatch.d3 { background: #0ff; }
.swatch.d4 { background: #00f; } .swatch.d5 { background: #f0f; } .swatch.d6 { background: #f00; } .swatch.d7 { background: #808080; }
.swatch.d8 { background: #000; }
.scale span { white-space: nowrap; } .scale > span { margin-right: .8rem; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1.4rem; font-size: .95rem; }
dt { color: var(--faint); } dd { margin: 0; }
pre { overflow-x: auto; font: 12.5px/1.5 ui-monospace, "DejaVu Sans Mono", monospace; border: 1px solid var(--hair); padding: .9rem 1.1rem; }
code { font: .86em ui-monospace, "DejaVu Sans Mono", monospace; }
.warning { border-left: 3px solid #d55e00; padding-left: 1.1rem; }
@media (max-width: 40rem) { main { padding: 1.6rem 1rem 3rem; } h1 { font-size: 1.6rem; } }
@media print { body { font-size: 10.5pt; } main { padding: 0; } nav { display: none; } figure { break-inside: avoid; } }
)";

}  // namespace kiln

#pragma once

#include <string_view>

/// @file
/// The style sheet of HTML reports: one calm column of text, figures and tables a little wider; scrolls
/// sideways inside wide figures on a phone; prints without splitting figures or rows.

namespace credence {

inline constexpr std::string_view kPageStyle = R"css(
:root { --ink: #1f2328; --soft: #5b636e; --rule: #d9dde2; --wash: #f6f7f9; --link: #00598a; }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; scroll-behavior: smooth; }
body { margin: 0; background: #fff; color: var(--ink);
  font: 17px/1.6 "Iowan Old Style", "Palatino Linotype", Palatino, "Book Antiqua", Georgia, serif; }
main { max-width: 1180px; margin: 0 auto; padding: 2.5rem 1.25rem 5rem; }
h1, h2, h3, th, td, figcaption, nav, .callout, .facts, .notes, .subtitle {
  font-family: "Helvetica Neue", Helvetica, Arial, sans-serif; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0 0 .3rem; letter-spacing: -.01em; }
.subtitle { color: var(--soft); font-size: .92rem; margin: 0 0 2rem; }
h2 { font-size: 1.35rem; line-height: 1.3; margin: 3.2rem 0 .8rem; padding-top: .8rem;
  border-top: 1px solid var(--rule); }
h3 { font-size: 1.05rem; margin: 2rem 0 .5rem; }
p, ul { max-width: 46rem; margin: .7rem 0; }
a { color: var(--link); text-decoration-thickness: 1px; text-underline-offset: 2px; }
nav { font-size: .92rem; border-left: 3px solid var(--rule); padding: .1rem 0 .1rem 1rem; margin: 1.5rem 0; }
nav ol { list-style: none; margin: 0; padding: 0; columns: 20rem; }
nav li { padding: .15rem 0; break-inside: avoid; }
nav a { text-decoration: none; }
nav a:hover { text-decoration: underline; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .88rem; line-height: 1.35; margin: .3rem 0;
  font-variant-numeric: tabular-nums lining-nums; }
thead th { border-top: 1.5px solid var(--ink); border-bottom: 1px solid var(--ink); font-weight: 600;
  vertical-align: bottom; }
tbody tr:last-child td { border-bottom: 1.5px solid var(--ink); }
tbody tr:nth-child(even) { background: var(--wash); }
th, td { padding: .32rem .75rem; text-align: left; }
.number { text-align: right; white-space: nowrap; }
.table { margin: 1.6rem 0; }
.table .notes { font-size: .84rem; color: var(--soft); margin: .4rem 0 0; }
.good { color: #00553e; background: #e3f4ee; font-weight: 600; }
.caution { color: #6b4a00; background: #fdf2d7; font-weight: 600; }
.alarm { color: #8c3300; background: #fce8dc; font-weight: 600; }
.muted { color: var(--soft); }
.callout { max-width: 46rem; font-size: .95rem; padding: .7rem 1rem; margin: 1rem 0; border-left: 4px solid;
  font-weight: 400; }
.callout.plain, .callout.muted { background: var(--wash); border-color: var(--rule); }
figure { margin: 1.8rem 0 2.4rem; }
figure svg { display: block; width: 100%; height: auto; margin: 0 auto; }
figcaption, caption { font-family: "Helvetica Neue", Helvetica, Arial, sans-serif; font-size: .9rem;
  line-height: 1.45; color: var(--soft); text-align: left; max-width: 52rem; margin-top: .5rem; }
caption { padding-bottom: .5rem; caption-side: top; color: var(--ink); }
figcaption b, caption b { color: var(--ink); }
.facts { display: grid; grid-template-columns: max-content 1fr; gap: .15rem 1.2rem; font-size: .9rem;
  margin: 1rem 0; }
.facts dt { color: var(--soft); }
.facts dd { margin: 0; overflow-wrap: anywhere; font-variant-numeric: tabular-nums; }
pre { font: .82rem/1.45 ui-monospace, "SF Mono", Menlo, "DejaVu Sans Mono", monospace; background: var(--wash);
  padding: .8rem 1rem; overflow-x: auto; }
@media (max-width: 640px) {
  body { font-size: 16px; }
  main { padding: 1.5rem 1rem 3rem; }
  h1 { font-size: 1.6rem; }
  .facts { grid-template-columns: 1fr; gap: 0; }
  .facts dd { margin-bottom: .4rem; }
}
@media print {
  body { font-size: 10.5pt; }
  main { max-width: none; padding: 0; }
  nav { display: none; }
  h2, h3 { break-after: avoid; }
  figure, .callout, tr { break-inside: avoid; }
  thead { display: table-header-group; }
  .scroll { overflow: visible; }
  figure .scroll > div { min-width: 0 !important; }
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}
)css";

}  // namespace credence

#pragma once

#include <string_view>

/// @file
/// The style sheet of HTML reports: contents beside the text, above it on a phone; light or dark as the
/// reader has it; wide things scroll in themselves, with a shade at the edge where there is more that shows
/// through the washes of the cells, and on a phone with the names of the rows held; prints light, unfolded,
/// without splitting figures or rows.

namespace credence::internal {

inline constexpr std::string_view kPageStyle = R"css(
:root { color-scheme: light dark; --paper: #fff; --ink: #1f2328; --soft: #57606a; --rule: #d9dde2;
  --wash: #f6f7f9; --link: #00598a; --good: #00553e; --good-wash: rgba(0,145,90,.11); --caution: #6b4a00;
  --caution-wash: rgba(240,175,0,.16); --alarm: #8c3300; --alarm-wash: rgba(233,91,5,.14); --shade: rgba(0,0,0,.18); }
@media screen and (prefers-color-scheme: dark) {
  :root { --paper: #16191d; --ink: #e3e6ea; --soft: #a3abb5; --rule: #3a4048; --wash: #1f2328;
    --link: #6cb8ea; --good: #7fd8b8; --good-wash: rgba(2,112,72,.3); --caution: #f0c66a;
    --caution-wash: rgba(82,58,1,.6); --alarm: #ffac85; --alarm-wash: rgba(112,39,1,.5); --shade: rgba(0,0,0,.7); }
  .panel svg, figure svg { fill: #e3e6ea; }
  figure svg [stroke="#000000"] { stroke: #f2f4f6; } figure svg [fill="#000000"] { fill: #f2f4f6; }
  figure svg .heat [stroke="#000000"] { stroke: #000; } figure svg .heat [fill="#000000"] { fill: #000; }
  figure svg [stroke="#0072b2"] { stroke: #4aa3e0; } figure svg [fill="#0072b2"] { fill: #4aa3e0; }
  figure svg [stroke="#56b4e9"] { stroke: #a9dcf7; } figure svg [fill="#56b4e9"] { fill: #a9dcf7; }
  figure svg [stroke="#009e73"] { stroke: #2fc79b; } figure svg [fill="#009e73"] { fill: #2fc79b; }
  figure svg [stroke="#d55e00"] { stroke: #f07f2a; } figure svg [fill="#d55e00"] { fill: #f07f2a; }
  figure svg [stroke="#6e6e6e"] { stroke: #b3b8be; } figure svg [fill="#6e6e6e"] { fill: #b3b8be; }
  figure svg [stroke="#666666"] { stroke: #8a9199; } figure svg [fill="#666666"] { fill: #a3abb5; }
  figure svg [stroke="#e6e6e6"] { stroke: #2c3138; }
  figure svg [fill="#d9d9d9"] { fill: #757b82; }
}
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; scroll-behavior: smooth; scroll-padding-top: 1rem; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 16px/1.55 system-ui, "Helvetica Neue", Helvetica, Arial, sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 2rem 1.5rem 4rem; }
.skip { position: absolute; left: -999rem; } .skip:focus { left: 1rem; top: 1rem; background: var(--paper); z-index: 9; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .3rem; letter-spacing: -.01em; overflow-wrap: anywhere; }
.subtitle { color: var(--soft); font-size: .92rem; margin: 0 0 1rem; }
h2 { font-size: 1.3rem; line-height: 1.3; margin: 2.4rem 0 .7rem; padding-top: .7rem;
  border-top: 1px solid var(--rule); overflow-wrap: anywhere; }
h3 { font-size: 1.02rem; margin: 1.6rem 0 .5rem; }
p, ul { max-width: 50rem; margin: .6rem 0; }
a { color: var(--link); text-decoration-thickness: 1px; text-underline-offset: 2px; }
a.word { color: inherit; text-decoration-style: dotted; }
:focus-visible { outline: 2px solid var(--link); outline-offset: 2px; }
.scroll:focus-visible { outline-offset: -2px; }
nav { font-size: .88rem; }
nav ol { list-style: none; margin: 0; padding: 0; }
nav li { padding: .16rem 0; }
nav a { text-decoration: none; }
nav a:hover, nav a.here { text-decoration: underline; }
nav a.here { color: var(--ink); font-weight: 600; }
button, input { font: inherit; color: inherit; background: var(--wash); border: 1px solid var(--rule);
  border-radius: 4px; padding: .2rem .6rem; }
nav button { margin: .7rem 0 0; font-size: .82rem; white-space: nowrap; cursor: pointer; }
@media screen and (min-width: 1060px) {
  body:has(nav) { display: grid; grid-template-columns: 12rem minmax(0, 1fr); }
  nav { position: sticky; top: 0; align-self: start; max-height: 100vh; overflow-y: auto;
    padding: 2.2rem .8rem 2rem 1.2rem; border-right: 1px solid var(--rule); min-height: 100vh; }
  body:has(nav) main { margin: 0; width: 100%; }
}
details { margin: .6rem 0; }
summary { cursor: pointer; }
summary h3 { display: inline; }
details.section { border-top: 1px solid var(--rule); margin: 0; padding: .55rem 0; }
details.section > summary h2 { display: inline; border: 0; padding: 0; margin: 0; font-size: 1.12rem; }
details.section[open] { padding-bottom: 1.6rem; }
details.section[open] > summary { margin-bottom: .7rem; }
.teaser { font-size: .9rem; padding: .1rem .45rem; border-radius: 3px; margin-left: .3rem; }
.line { font-size: .9rem; color: var(--soft); }
nav wbr { display: none; }
.scroll { overflow-x: auto; background:
    linear-gradient(to right, var(--paper) 30%, transparent) left / 40px 100% no-repeat local,
    linear-gradient(to left, var(--paper) 30%, transparent) right / 40px 100% no-repeat local,
    radial-gradient(farthest-side at 0 50%, var(--shade), transparent) left / 12px 100% no-repeat scroll,
    radial-gradient(farthest-side at 100% 50%, var(--shade), transparent) right / 12px 100% no-repeat scroll; }
table { border-collapse: collapse; font-size: .84rem; line-height: 1.35; margin: .3rem 0;
  font-variant-numeric: tabular-nums lining-nums; }
thead th, thead td { border-top: 1.5px solid var(--ink); border-bottom: 1px solid var(--ink); font-weight: 600;
  vertical-align: bottom; }
thead button { all: unset; cursor: pointer; font: inherit; }
thead button:focus-visible { outline: 2px solid var(--link); }
th[aria-sort=ascending] button::after { content: " ▲"; font-size: .7em; }
th[aria-sort=descending] button::after { content: " ▼"; font-size: .7em; }
tbody tr { border-bottom: 1px solid var(--rule); }
tbody tr:last-child { border-bottom: 1.5px solid var(--ink); }
th, td { padding: .3rem .25rem; text-align: left; }
td { vertical-align: top; white-space: nowrap; }
td.long { white-space: normal; min-width: 12rem; }
td.with-interval { white-space: normal; }
.interval { white-space: nowrap; }
.number { text-align: right; white-space: nowrap; }
thead .number { white-space: normal; }
.table { margin: 1.2rem 0; }
.table input { margin: 0 0 .4rem; }
.table .notes { font-size: .84rem; color: var(--soft); margin: .35rem 0 0; }
.good { color: var(--good); background: var(--good-wash); font-weight: 600; }
.caution { color: var(--caution); background: var(--caution-wash); font-weight: 600; }
.alarm { color: var(--alarm); background: var(--alarm-wash); font-weight: 600; }
.muted { color: var(--soft); }
.callout { max-width: 50rem; font-size: .95rem; padding: .6rem 1rem; margin: 1rem 0; border-left: 4px solid;
  font-weight: 400; }
.callout.plain, .callout.muted { background: var(--wash); border-color: var(--rule); }
.answer { font-size: 1.12rem; line-height: 1.45; max-width: 62rem; overflow-wrap: anywhere; }
figure { margin: 1.4rem 0 2rem; }
figure svg { display: block; width: 100%; height: auto; margin: 0 auto; overflow: visible; }
.panels { display: grid; gap: 0; grid-template-columns: minmax(0, 1fr); }
@media (min-width: 641px), print { .panels { grid-template-columns: var(--columns); } }
.panel { min-width: 0; }
.panel svg { touch-action: pan-x pan-y; }
.panel .catch { cursor: crosshair; }
.panel .rule { stroke: var(--soft); stroke-width: 1; stroke-dasharray: 3 3; pointer-events: none; }
.panel .drag { fill: var(--link); fill-opacity: .15; stroke: var(--link); pointer-events: none; }
.panel circle { stroke: var(--paper); stroke-width: 1; pointer-events: none; }
.panel .key[role=button] { cursor: pointer; }
.panel .key[aria-pressed=false] { opacity: .35; }
.panel .zoom * { vector-effect: non-scaling-stroke; }
.tip { position: fixed; z-index: 5; max-width: 21rem; background: var(--paper); color: var(--ink);
  border: 1px solid var(--rule); border-radius: 4px; box-shadow: 0 2px 10px var(--shade); padding: .35rem .6rem;
  font-size: .8rem; line-height: 1.4; pointer-events: none; font-variant-numeric: tabular-nums; }
.tip span { border-left: 3px solid transparent; padding-left: .35rem; color: var(--soft); }
.live { position: absolute; left: -999rem; }
figcaption, .caption { font-size: .88rem; line-height: 1.45; color: var(--soft); text-align: left;
  max-width: 52rem; margin-top: .4rem; }
.caption { margin: 0 0 .4rem; color: var(--ink); }
figcaption b, .caption b { color: var(--ink); }
.facts { display: grid; grid-template-columns: max-content minmax(0, 1fr); gap: .12rem 1.2rem;
  font-size: .88rem; margin: .8rem 0; }
.facts dt { color: var(--soft); }
.facts dd { margin: 0; overflow-wrap: anywhere; font-variant-numeric: tabular-nums; }
.glossary { max-width: 50rem; font-size: .92rem; }
.glossary dt { font-weight: 600; margin-top: .6rem; }
.glossary dd { margin: 0; }
.glossary dt:target { background: var(--caution-wash); }
footer { border-top: 1px solid var(--rule); margin-top: 2rem; color: var(--soft); }
pre { font: .8rem/1.45 ui-monospace, "SF Mono", Menlo, "DejaVu Sans Mono", monospace; background: var(--wash);
  padding: .8rem 1rem; overflow-x: auto; }
@media screen and (max-width: 1059px) {
  html { scroll-padding-top: 3.2rem; }
  nav { position: sticky; top: 0; z-index: 4; background: var(--paper); border-bottom: 1px solid var(--rule);
    display: flex; align-items: center; gap: .9rem; padding: .45rem 1rem; overflow-x: auto; }
  nav a { white-space: nowrap; }
  nav ol { display: flex; gap: 1.1rem; white-space: nowrap; }
  nav button { margin: 0; order: -1; }
}
@media (max-width: 640px) {
  body { font-size: 15px; }
  main { padding: 1rem .9rem 3rem; }
  h1 { font-size: 1.45rem; }
  .answer { font-size: 1rem; }
  th, td { padding: .3rem .45rem; }
  .facts { grid-template-columns: minmax(0, 1fr); gap: 0; }
  .facts dd { margin-bottom: .4rem; }
  .scroll tr > :first-child { position: sticky; left: 0; background: var(--paper); background-clip: padding-box; }
}
@media print {
  body { font-size: 10pt; }
  main { max-width: none; padding: 0; }
  nav, .skip, .tip, .table input { display: none; }
  details::details-content { content-visibility: visible; block-size: auto; }
  h2, h3, summary { break-after: avoid; }
  figure, .callout, tr { break-inside: avoid; }
  thead { display: table-header-group; }
  .scroll { overflow: visible; background: none; }
  figure .scroll > div { min-width: 0 !important; }
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; }
}
)css";

}  // namespace credence::internal

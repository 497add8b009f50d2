"""The page of a report: one file, no network, light and dark, printable. `$name` is filled in by `page.py`."""

from string import Template

PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy"
content="default-src 'none'; style-src 'unsafe-inline'; img-src data:$policy">
<title>$title</title>
<style>
:root { --paper: #ffffff; --panel: #f5f6f7; --ink: #1b1b1b; --soft: #57606a; --rule: #d9d9d9;
  --blue: #0072b2; --orange: #d55e00; }
@media screen and (prefers-color-scheme: dark) {
  :root { --paper: #12181e; --panel: #1d242b; --ink: #e8e8e8; --soft: #a3b1be; --rule: #36414b;
    --blue: #56b4e9; --orange: #ee8a3c; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem; max-width: 62rem; background: var(--paper); color: var(--ink);
  overflow-wrap: break-word; font: 1rem/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.2rem; margin: 2.2rem 0 .7rem; padding-bottom: .2rem; border-bottom: 1px solid var(--rule); }
p { margin: .5rem 0; max-width: 46rem; }
.soft, small { color: var(--soft); }
.warning { border-left: .3rem solid var(--orange); padding: .3rem .8rem; background: var(--panel); }
.wide { overflow-x: auto; }
.wide svg { display: block; max-width: 100%; height: auto; margin: 0 auto; }
@media screen {
  .wide svg.proofmass { max-width: none; }
  .wide:has(> .picture) { margin: 0 calc(50% - min(48vw, 33.5rem)); }
  .wide { background: linear-gradient(to right, var(--paper) 1rem, transparent) left / 2rem 100% no-repeat local,
    linear-gradient(to left, var(--paper) 1rem, transparent) right / 2rem 100% no-repeat local,
    linear-gradient(to right, var(--rule), transparent) left / .6rem 100% no-repeat scroll,
    linear-gradient(to left, var(--rule), transparent) right / .6rem 100% no-repeat scroll; }
}
@media screen { .wide svg.picture { max-width: none; } .diagram { margin: 0 calc(50% - min(48vw, 58rem)); } }
.wide + .wide { margin-top: 1.2rem; }
td > small { display: block; }
td:not(.number) > small { min-width: 11rem; }
table { border-collapse: collapse; width: 100%; font-size: .9rem; }
th, td { padding: .25rem .7rem .25rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--rule); }
th { font-weight: 600; max-width: 20rem; }
tbody th { min-width: 9rem; }
.short tbody th { min-width: 0; white-space: nowrap; }
th small, .kind { font-weight: 400; }
thead th { color: var(--soft); font-weight: 500; }
.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
td.number, code, pre { font-family: ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace; font-size: .85rem; }
pre { background: var(--panel); padding: .8rem 1rem; white-space: pre-wrap; overflow-wrap: anywhere; }
small code { font-size: 1em; }
td.long { overflow-wrap: anywhere; }
summary { cursor: pointer; color: var(--soft); font-size: .9rem; padding: .25rem 0; }
td summary { font-size: .8rem; padding: 0; }
footer { margin-top: 3rem; color: var(--soft); font-size: .85rem; }
@media print {
  @page { margin: 15mm; }
  body { padding: 0; max-width: none; font-size: 10pt; }
  h2 { break-after: avoid; }
  .wide { overflow: visible; }
  table, td.number { font-size: .68rem; }
  th, td { padding-right: .4rem; }
  tbody th { min-width: 7rem; }
  tr, svg { break-inside: avoid; }
  details::details-content { content-visibility: visible; block-size: auto; }
  summary { display: none; }
  .page svg { max-height: 235mm; }
  .parameters table { font-size: .64rem; line-height: 1.25; }
  .parameters td.number { font-size: .64rem; }
  .parameters td, .parameters th { padding-top: .06rem; padding-bottom: .06rem; }
  .parameters small { display: none; }
  pre.file { columns: 2; font-size: 6.5pt; line-height: 1.2; }
}
$styles</style>
</head>
<body>
<main>
<h1>$title</h1>
$opening
$live$sections
</main>
<footer>$footer</footer>
</body>
</html>
""")

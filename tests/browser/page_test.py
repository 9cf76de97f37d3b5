"""Every kind of page in a real browser: python3 page_test.py CREDENCE SCENARIOS.

Exits with 77, which ctest takes as skipped, where there is no Chromium. With the file axe.min.js of axe-core named in
CREDENCE_AXE the pages are held against its rules of accessibility as well.
"""

import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from devtools import Browser

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)

SWEEP = """
[world]
model = "monobot"
landmarks = 2
[study]
runs = 64
steps = 10
[sweep]
"filter.measurement_scale" = [0.25, 0.5, 1.0, 2.0, 4.0]
"filter.process_scale" = [0.1, 1.0, 10.0]
"""


def make_pages(credence, scenarios, folder):
    """Pages of all kinds that need no data and little time; name → path."""
    (folder / "plane.toml").write_text(SWEEP)
    small = ["--runs", "64", "--steps", "20"]
    commands = {
        "run": ["run", scenarios / "figure1_two_landmarks.toml", scenarios / "planar_loop.toml",
                scenarios / "figure4_one_landmark.toml", *small],
        "sweep": ["sweep", scenarios / "mistuned_sweep.toml", *small],
        "plane": ["sweep", folder / "plane.toml"],
        "stability": ["stability", scenarios / "figure3_two_landmarks.toml"],
        "growth": ["stability", scenarios / "planar_stability.toml", "--loops", "4", "--set",
                   "study.steps=40"],
        "check": ["check", folder / "logs"],
        "inflated": ["run", scenarios / "figure2_two_landmarks.toml", *small],
        "compare": ["compare", folder / "inflated", folder / "inflated"],
        "selftest": ["selftest", "--studies", "100"],
        "timing": ["timing", "--landmarks", "10,20", "--observed", "1", "--repetitions", "1"],
        "claims": ["claims"],
        "estimators": ["estimators", scenarios / "huang_ring.toml", "--runs", "8", "--steps", "40"],
    }
    subprocess.run([credence, "run", scenarios / "planar_loop.toml", "--runs", "8", "--steps", "30", "--log",
                    folder / "logs"], check=True, capture_output=True)
    for name, command in commands.items():
        subprocess.run([credence, *command, "--out", folder / name, "--quiet"], check=True, capture_output=True)
    return {name: folder / name / "index.html" for name in commands}


STEP_S = 0.25  # of the world of the logs


class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="credence-pages-"))
        cls.pages = make_pages(Pages.credence, Pages.scenarios, cls.folder)
        cls.browser = Browser(CHROMIUM)

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        shutil.rmtree(cls.folder)

    def test_opens_without_errors_at_every_width(self):
        for width, dark in ((1280, False), (390, True)):
            self.browser.view(width, dark=dark)
            for name, path in self.pages.items():
                self.browser.open(path)
                self.assertEqual(self.browser.errors(), [], name)
                self.assertLessEqual(self.browser.run("document.documentElement.scrollWidth"), width,
                                     name + ": the page itself scrolls sideways")

    def test_the_answer_is_in_view_on_a_phone(self):
        self.browser.view(390, 844)
        for name, path in self.pages.items():
            self.browser.open(path)
            bottom = self.browser.run("document.getElementById('answer').getBoundingClientRect().bottom")
            self.assertLess(bottom, 844, name)

    def test_paper_and_figures_are_dark_where_the_reader_wants_it(self):
        shade = "getComputedStyle(document.body).backgroundColor"
        for dark in (False, True):
            self.browser.view(1280, dark=dark)
            self.browser.open(self.pages["check"])
            red = int(self.browser.run(shade).removeprefix("rgb(").split(",")[0])
            self.assertEqual(red < 64, dark)

    def test_a_row_leads_to_its_section(self):
        self.browser.view(1280)
        self.browser.open(self.pages["run"])
        self.browser.run("document.querySelector('td a[href=\"#figure4-one-landmark\"]').click()")
        self.browser.run("new Promise(done => setTimeout(done, 1200))")  # scrolls smoothly
        self.assertTrue(self.browser.run("document.getElementById('figure4-one-landmark').open"))
        top = self.browser.run("document.getElementById('figure4-one-landmark').getBoundingClientRect().top")
        self.assertTrue(-5 < top < 900, top)

    def test_a_word_leads_to_its_explanation(self):
        self.browser.view(1280)
        self.browser.open(self.pages["run"])
        self.browser.run("document.querySelector('a[href=\"#word-nees\"]').click()")
        self.browser.run("new Promise(done => setTimeout(done, 300))")
        self.assertTrue(self.browser.run("document.getElementById('words').open"))

    def hover(self, figure, panel, x):
        """Moves the mouse to the data coordinate x of a panel and gives what is shown."""
        place = self.browser.run(f"""(async () => {{
          const panel = document.querySelectorAll('#{figure} .panel')[{panel}];
          panel.scrollIntoView({{block: 'center', behavior: 'instant'}});
          // Scrolling, which hides what is shown, is told with the next frame.
          for (let i = 0; i < 2; ++i) await new Promise(requestAnimationFrame);
          const d = JSON.parse(panel.querySelector('script').textContent), [l, r, t, b] = d.box;
          const share = (v, [low, high, log]) => log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low);
          const svg = panel.querySelector('svg');
          const p = new DOMPoint(l + share({x}, d.x) * (r - l), (t + b) / 2).matrixTransform(svg.getScreenCTM());
          return [p.x, p.y];
        }})()""")
        self.browser.mouse("mouseMoved", *place)
        return self.browser.run("document.querySelector('.tip').hidden ? null : document.querySelector('.tip').innerText")

    def test_the_mouse_shows_the_value_of_the_step(self):
        self.browser.view(1280)
        self.browser.open(self.pages["check"])
        with open(self.folder / "check" / "logs.csv") as file:
            row = list(csv.DictReader(file))[16]
        shown = self.hover("figure-logs-consistency", 0, 17 * STEP_S)
        self.assertIsNotNone(shown)
        self.assertIn("time 4.25 s", shown)
        mean = next(line for line in shown.splitlines() if line.startswith("measured mean"))
        self.assertAlmostEqual(float(mean.split()[-1]), float(row["nees_mean"]), delta=2e-3 * float(row["nees_mean"]))

    def test_the_mouse_shows_the_cell_of_a_heat_map(self):
        self.browser.view(1280)
        self.browser.open(self.pages["plane"])
        self.assertGreater(self.browser.run("document.querySelectorAll('.panel').length"), 1)
        with open(self.folder / "plane" / "sweep.csv") as file:
            rows = list(csv.DictReader(file))
        row = next(r for r in rows if float(r["filter.measurement_scale"]) == 0.5
                   and float(r["filter.process_scale"]) == 1.0)
        shown = self.hover("figure-sweep", 0, 0.5)
        self.assertIn("filter.measurement_scale 0.5, filter.process_scale 1", shown)
        ratio = float(row["nees_mean"]) / float(row["nees_expected"])
        self.assertAlmostEqual(float(shown.split()[-1]), ratio, delta=2e-3 * ratio)

    def test_a_curve_is_switched_off_and_on(self):
        self.browser.view(1280)
        self.browser.open(self.pages["check"])
        state = """(() => {
          const panel = document.querySelector('#figure-logs-consistency .panel');
          const key = [...panel.querySelectorAll('.key')].find(k => k.textContent.includes('measured mean'));
          CLICK
          return [key.getAttribute('aria-pressed'),
                  panel.querySelector('.series.' + key.classList[1]).style.display];
        })()"""
        self.assertEqual(self.browser.run(state.replace("CLICK", "")), ["true", ""])
        click = state.replace("CLICK", "key.dispatchEvent(new MouseEvent('click', {bubbles: true}));")
        self.assertEqual(self.browser.run(click), ["false", "none"])
        self.assertNotIn("measured mean", self.hover("figure-logs-consistency", 0, 17 * STEP_S))
        self.assertEqual(self.browser.run(click), ["true", ""])

    def test_a_legend_switches_the_next_panels_without_one_too(self):
        self.browser.view(1280)
        self.browser.open(self.pages["estimators"])
        click = """(() => {
          const panels = [...document.querySelectorAll('#figure-estimators .panel')];
          const key = [...panels[0].querySelectorAll('.key')].find(k => k.textContent.includes('1: '));
          key.dispatchEvent(new MouseEvent('click', {bubbles: true}));
          const hidden = g => g.style.display === 'none';
          return panels.map(p => [p.querySelector('.key') !== null, [...p.querySelectorAll('.series')].some(hidden)]);
        })()"""
        self.assertEqual(self.browser.run(click), [[True, True], [False, True], [False, True], [False, True]])
        self.assertEqual(self.browser.run(click), [[True, False], [False, False], [False, False], [False, False]])
        self.assertEqual(self.browser.errors(), [])

    def test_a_drawn_box_is_zoomed_to_and_escape_leads_back(self):
        self.browser.view(1280)
        self.browser.open(self.pages["check"])
        box = self.browser.run("""(async () => {
          const frame = document.querySelector('#figure-logs-consistency .catch');
          frame.scrollIntoView({block: 'center', behavior: 'instant'});
          for (let i = 0; i < 2; ++i) await new Promise(requestAnimationFrame);
          const r = frame.getBoundingClientRect();
          return [r.left, r.top, r.width, r.height];
        })()""")
        left, top, width, height = box
        start, end = (left + 0.25 * width, top + 0.25 * height), (left + 0.75 * width, top + 0.75 * height)
        self.browser.mouse("mousePressed", *start, button="left", clickCount=1)
        self.browser.mouse("mouseMoved", *end, button="left", buttons=1)
        self.browser.mouse("mouseReleased", *end, button="left", clickCount=1)
        ticks = "document.querySelectorAll('#figure-logs-consistency .new-ticks text').length"
        self.assertGreater(self.browser.run(ticks), 3)
        # The left edge of the box is now that of the axes: a quarter into 30 steps.
        self.assertIn(f"time {STEP_S * round(1 + 0.25 * 29):g} s", self.hover_at(left + 1, start[1]))
        self.browser.run("document.querySelector('#figure-logs-consistency svg').focus()")
        self.browser.key("Escape")
        self.assertEqual(self.browser.run(ticks), 0)
        self.assertEqual(self.browser.errors(), [])

    def hover_at(self, x, y):
        self.browser.mouse("mouseMoved", x, y)
        return self.browser.run("document.querySelector('.tip').innerText")

    def test_the_keyboard_walks_along_a_curve(self):
        self.browser.view(1280)
        self.browser.open(self.pages["check"])
        self.browser.run("document.querySelector('#figure-logs-consistency svg').focus()")
        self.browser.key("ArrowRight")
        self.browser.key("ArrowRight")
        self.assertIn("time 0.5 s", self.browser.run("document.querySelector('.live').textContent"))

    def test_a_table_is_sorted_by_a_column(self):
        self.browser.view(1280)
        self.browser.open(self.pages["sweep"])
        values = """(() => {
          const table = document.querySelector('.table table');
          const th = [...table.querySelectorAll('th')].find(t => t.textContent === 'NEES');
          th.querySelector('button').click();
          return [...table.tBodies[0].rows].map(r => parseFloat(r.cells[th.cellIndex].textContent));
        })()"""
        rising = self.browser.run(values)
        self.assertEqual(rising, sorted(rising))
        self.assertEqual(self.browser.run(values), sorted(rising, reverse=True))

    def test_a_column_is_sorted_by_the_numbers_that_are_meant(self):
        self.browser.view(1280)
        self.browser.open(self.pages["sweep"])
        for texts in (["< 1e−12", "3.39e−6", "0.00896", "0.5"], ["90 ns", "25 µs", "1.2 ms", "3 s", "2.0 min"],
                      ["−∞", "−1.5e2", "−0.04", "7", "∞"], ["512 B", "12 kB", "3 MB", "1 GB"],
                      ["× 2.25", "× 23.1"], ["11.4 %", "> 100 %"], ["1.02 (0.98 … 1.06)", "4.495 of 3.000"]):
            shown = self.browser.run("""(texts => {
              const table = document.querySelector('.table table'), rows = [...table.tBodies[0].rows];
              const th = [...table.querySelectorAll('th')].find(t => t.textContent === 'failed');
              const at = row => row.cells[th.cellIndex];
              th.removeAttribute('aria-sort');
              rows.forEach((row, i) => { at(row).textContent = i < texts.length ? texts[i] : '–'; });
              th.querySelector('button').click();
              return [...table.tBodies[0].rows].map(row => at(row).textContent);
            })(%s)""" % json.dumps(texts[::-1]))
            self.assertEqual(shown[:len(texts)], texts)
            self.assertEqual(set(shown[len(texts):]), {"–"})

    def test_what_scrolls_can_be_reached_and_everything_has_a_name(self):
        script = """(() => {
          const bad = [];
          document.querySelectorAll('.scroll, pre').forEach(e => { if (e.tabIndex !== 0) bad.push('scroll'); });
          document.querySelectorAll('th, button, summary, a, figure svg').forEach(e => {
            if (!(e.textContent.trim() || e.getAttribute('aria-label'))) bad.push(e.outerHTML.slice(0, 80));
          });
          const ids = [...document.querySelectorAll('[id]')].map(e => e.id);
          if (new Set(ids).size !== ids.length) bad.push('an id twice');
          document.querySelectorAll('a[href^="#"]').forEach(a => {
            if (!document.getElementById(a.getAttribute('href').slice(1))) bad.push(a.getAttribute('href'));
          });
          return bad;
        })()"""
        self.browser.view(1280)
        for name, path in self.pages.items():
            self.browser.open(path)
            self.assertEqual(self.browser.run(script), [], name)

    @unittest.skipUnless("CREDENCE_AXE" in os.environ, "axe.min.js is not named in CREDENCE_AXE")
    def test_breaks_no_rule_of_accessibility(self):
        axe = pathlib.Path(os.environ["CREDENCE_AXE"]).read_text()
        violations = """(async () => {
          document.querySelectorAll('details').forEach(d => { d.open = true; });
          return (await axe.run()).violations.map(v => v.id + ': ' + v.nodes[0].html.slice(0, 160));
        })()"""
        for width, dark in ((1280, False), (1280, True), (390, False)):
            self.browser.view(width, dark=dark)
            for name, path in self.pages.items():
                self.browser.open(path)
                self.browser.run(axe + "; 0")
                self.assertEqual(self.browser.run(violations), [], f"{name}, {width} px")

    def test_no_table_is_wider_than_a_common_screen(self):
        self.browser.view(1280)
        for name, path in self.pages.items():
            self.browser.open(path)
            wide = self.browser.run("""(() => {
              document.querySelectorAll('details').forEach(d => { d.open = true; });
              return [...document.querySelectorAll('.table .scroll')].filter(s => s.scrollWidth > s.clientWidth)
                  .map(s => `${s.closest('.table').querySelector('.caption').textContent}: ${s.scrollWidth}`);
            })()""")
            self.assertEqual(wide, [], name)

    def test_print_unfolds_everything(self):
        self.browser.view(1280)
        self.browser.open(self.pages["run"])
        self.browser.run("window.dispatchEvent(new Event('beforeprint'))")
        self.assertEqual(self.browser.run("document.querySelectorAll('details:not([open])').length"), 0)
        self.browser.run("window.dispatchEvent(new Event('afterprint'))")
        self.assertGreater(self.browser.run("document.querySelectorAll('details:not([open])').length"), 2)


if __name__ == "__main__":
    if CHROMIUM is None:
        print("skipped: there is no Chromium here")
        sys.exit(77)
    Pages.credence, Pages.scenarios = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1])

"""What is seen in a picture, by its pixels. Needs numpy and matplotlib alone: python3 -m unittest test_draw"""

import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

try:
    import matplotlib
    import matplotlib.image
    import numpy as np
except ImportError as error:
    raise unittest.SkipTest(f"{error.name} is not installed") from None

from c3rt.pictures import DescriptionError, draw

RED, GREEN, BLUE = "#ff0000", "#00ff00", "#0000ff"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(pathlib.Path(__file__).parents[2])}


def only(**panel):
    """One panel without axes, whose colours are nowhere else."""
    return {"panels": [{"axes": False, **panel}]}


def line(color, x, y, **more):
    return {"color": color, "x": x, "y": y, **more}


def places(image, color):
    """Which pixels are of this colour, at least by three quarters."""
    wanted = matplotlib.colors.to_rgb(color)
    return np.all(np.abs(image[:, :, :3] - wanted) < 0.26, axis=2)


def rows(image, color):
    """The first and the last row from above with the colour, as edges of its area."""
    found = np.flatnonzero(places(image, color).any(axis=1))
    return found[0], found[-1] + 1


def columns(image, color):
    found = np.flatnonzero(places(image, color).any(axis=0))
    return found[0], found[-1] + 1


def length(edges):
    return edges[1] - edges[0]


class Pictures(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        self.file = self.folder / "p.png"

    def image(self, figure):
        draw(figure, self.file)
        return matplotlib.image.imread(self.file)


class Draw(Pictures):
    def test_it_has_the_size_that_is_asked_for(self):
        figure = {"title": "size", "size": [820, 420], "panels": [{"curves": [line(RED, [0, 1], [0, 1], name="a")]}]}
        self.assertEqual(self.image(figure).shape[:2], (420, 820))

    def test_more_panels_and_a_longer_legend_make_it_larger(self):
        def panel(name):
            return {"curves": [line(RED, [0, 1], [0, 1], name=name)]}

        height, width = self.image({"panels": [panel("a")]}).shape[:2]
        two_high, two_wide = self.image({"panels": [panel("a" * 40), panel("")]}).shape[:2]
        self.assertGreater(two_high, 1.7 * height)
        self.assertGreater(two_wide, width + 200)

    def test_a_curve_is_where_its_numbers_are(self):
        image = self.image(
            only(
                y_limits=[-1, 3],
                curves=[line(GREEN, [0, 1], [-1, -1]), line(BLUE, [0, 1], [3, 3]), line(RED, [0, 1], [0, 0])],
            )
        )
        bottom, top = rows(image, GREEN)[1], rows(image, BLUE)[0]  # half of each line is outside
        self.assertAlmostEqual(np.mean(rows(image, RED)), bottom - (bottom - top) / 4, delta=1.5)

    def test_a_logarithmic_axis_has_a_decade_for_a_decade(self):
        levels = {GREEN: 0.01, RED: 0.1, BLUE: 10.0}
        curves = [line(color, [0, 1], [y, y]) for color, y in levels.items()]
        image = self.image(only(y_scale="log", curves=curves))
        low, middle, high = (np.mean(rows(image, color)) for color in levels)
        self.assertAlmostEqual((low - middle) / (low - high), 1 / 3, delta=0.01)

    def test_a_gap_stays_a_gap(self):
        x = np.linspace(0, 1, 101)
        for nothing in (None, float("nan"), float("inf")):
            y = [nothing if 0.395 < at < 0.605 else 1.0 for at in x]
            image = self.image(only(curves=[line(GREEN, x, 0 * x), line(RED, x, y)]))
            first, last = columns(image, GREEN)
            drawn = places(image, RED).any(axis=0)[first:last]
            gap = np.flatnonzero(~drawn) / len(drawn)
            self.assertAlmostEqual(gap[0], 0.39, delta=0.01)
            self.assertAlmostEqual(gap[-1], 0.61, delta=0.01)
            self.assertAlmostEqual(np.mean(drawn), 0.78, delta=0.01)

    def test_dashes_leave_something_out_and_marks_alone_are_not_joined(self):
        shares = {}
        for look in ({}, {"line": "dashed"}, {"line": "none", "marks": "dot"}):
            image = self.image(only(curves=[line(RED, [0, 1, 2], [0, 0, 0], **look)]))
            first, last = columns(image, RED)
            shares[look.get("line")] = np.mean(places(image, RED).any(axis=0)[first:last])
        self.assertEqual(shares[None], 1.0)
        self.assertTrue(0.4 < shares["dashed"] < 0.8)
        self.assertLess(shares["none"], 0.05)

    def test_seen_from_above_a_square_is_one(self):
        square = {"color": RED, "x": [0, 1, 1, 0], "y": [0, 0, 1, 1]}
        tall = {"color": BLUE, "x": [3, 4, 4, 3], "y": [0, 0, 3, 3]}
        image = self.image({"size": [900, 300], **only(equal=True, polygons=[square, tall])})
        self.assertAlmostEqual(length(columns(image, RED)), length(rows(image, RED)), delta=1)
        self.assertAlmostEqual(length(rows(image, BLUE)), 3 * length(rows(image, RED)), delta=3)

    def test_a_band_is_what_is_as_close_to_its_path(self):
        path = {"color": RED, "x": [0, 1], "y": [0, 0], "radius": 0.2}
        ruler = {"color": BLUE, "x": [0, 1, 1, 0], "y": [0.5, 0.5, 1, 1]}
        image = self.image(only(equal=True, x_limits=[-1, 2], y_limits=[-1, 1.5], bands=[path], polygons=[ruler]))
        unit = length(columns(image, BLUE))
        self.assertAlmostEqual(length(rows(image, RED)), 0.4 * unit, delta=2)
        self.assertAlmostEqual(length(columns(image, RED)), 1.4 * unit, delta=2)  # round at its ends
        area = np.sum(places(image, RED)) / unit**2
        self.assertAlmostEqual(area, 0.4 + np.pi * 0.04, delta=0.02)

    def test_bars_are_as_wide_and_as_high_as_their_numbers(self):
        image = self.image(only(bars=[{"color": RED, "edges": [0, 1, 3], "heights": [2, 1]}]))
        high = places(image, RED).sum(axis=0)
        high = high[high > 0]
        self.assertAlmostEqual(np.mean(high > 0.75 * high.max()), 1 / 3, delta=0.01)
        self.assertAlmostEqual(high.min() / high.max(), 0.5, delta=0.02)

    def test_a_shade_fills_its_intervals_and_its_part_of_the_height(self):
        shade = {"color": RED, "low": 0.5, "intervals": [[0, 1], [3, 4]]}
        image = self.image(only(curves=[line(BLUE, [0, 4], [0, 0]), line(GREEN, [0, 4], [1, 1])], shades=[shade]))
        first, last = columns(image, BLUE)
        shaded = places(image, RED)[:, first:last].any(axis=0)
        self.assertAlmostEqual(np.mean(shaded), 0.5, delta=0.01)
        self.assertFalse(shaded[int(0.3 * len(shaded)) : int(0.7 * len(shaded))].any())
        # the panel is 5 % higher than the curves, above and below; the curve above lies on the shade
        between = np.mean(rows(image, BLUE)) - np.mean(rows(image, GREEN))
        self.assertAlmostEqual(length(rows(image, RED)), 0.55 * between, delta=2)

    def test_a_legend_lies_beside_the_panel_or_below_and_not_on_it(self):
        for where, edges in (("right", columns), ("below", rows)):
            frame = line(RED, [0, 1, 1, 0, 0], [0, 0, 1, 1, 0])
            image = self.image({"panels": [{"legend": where, "curves": [frame, line(BLUE, [0.2, 0.8], [0.5, 0.5], name="a")]}]})
            self.assertGreater(edges(image, BLUE)[1], edges(image, RED)[1] + 10)
            left, right = columns(image, RED)
            top, bottom = rows(image, RED)
            inside = image[top:bottom, left:right]
            self.assertAlmostEqual(length(columns(inside, BLUE)) / (right - left), 0.6, delta=0.01)
            self.assertLess(length(rows(inside, BLUE)), 5)

    def test_a_panel_without_samples_says_so(self):
        empty = self.image({"panels": [{"y_scale": "log", "curves": [line(RED, [None], [None])]}]})
        blank = self.image(only(curves=[line("#ffffff", [0, 1], [0, 1])]))
        self.assertFalse(places(empty, RED).any())
        self.assertGreater(np.sum(empty < 0.9), np.sum(blank < 0.9))

    def test_text_is_shown_as_it_is(self):
        """Neither formulas nor names that begin with _, which matplotlib leaves out."""

        def ink(**words):
            panel = {"x_label": words.get("label", ""), "curves": [line(RED, [0, 1], [0, 1], name=words.get("name", ""))]}
            image = self.image({"size": [900, 400], "title": words.get("title", ""), "panels": [panel]})
            return np.sum(np.all(image[:, :, :3] < 0.5, axis=2))

        for where in ("title", "label", "name"):
            self.assertGreater(ink(**{where: "$_$"}), ink(**{where: " "}) + 30, where)
            self.assertGreater(ink(**{where: "_a"}), ink(**{where: " "}) + 10, where)
            ink(**{where: r"$\nonsense{"})  # is no error

    def test_nine_curves_differ_where_the_palette_ends(self):
        curves = [{"x": [0, 1], "y": [i, i], "width": 4} for i in range(9)]
        image = self.image(only(curves=curves))
        blue = places(image, "#0072b2")
        full = blue.sum(axis=1)
        lines = np.flatnonzero(full > 0)
        self.assertGreater(length((lines[0], lines[-1])), image.shape[0] / 2)  # the first and the ninth
        self.assertLess(full[lines[0] + 2], 0.9 * full[lines[-1] - 2])  # the ninth is above, with dashes

    def test_a_persons_own_settings_change_nothing_and_are_not_changed(self):
        with matplotlib.rc_context({"axes.facecolor": RED, "figure.facecolor": RED, "axes.prop_cycle": "cycler('color', 'r')"}):
            image = self.image({"panels": [{"curves": [{"x": [0, 1], "y": [0, 1]}]}]})
            self.assertEqual(matplotlib.rcParams["axes.facecolor"], RED)
        self.assertFalse(places(image, RED).any())


class Descriptions(Pictures):
    def wrong(self, figure, message):
        with self.assertRaises(DescriptionError) as caught:
            draw(figure, self.file)
        self.assertEqual(str(caught.exception), message)
        self.assertEqual(list(self.folder.iterdir()), [])

    def wrong_panel(self, panel, message):
        self.wrong({"panels": [{}, panel]}, f"panels[1].{message}")

    def test_what_is_wrong_is_named_by_its_key(self):
        self.wrong([], "the figure: expected a dict, got []")
        self.wrong({}, "panels: missing")
        self.wrong({"panels": []}, "panels: expected at least one")
        self.wrong({"panels": {}}, "panels: expected a list, got {}")
        self.wrong({"panels": [3]}, "panels[0]: expected a dict, got 3")
        self.wrong({"panels": [{}], "heigth": 3}, "heigth: unknown key, expected one of title, size, columns, panels")
        self.wrong({"panels": [{}], "size": [300]}, "size: expected two numbers, got [300]")
        self.wrong({"panels": [{}], "columns": 0}, "columns: expected a whole number of at least 1, got 0")
        self.wrong_panel({"title": 3}, "title: expected a text, got 3")
        self.wrong_panel({"equal": 1}, "equal: expected true or false, got 1")
        self.wrong_panel({"y_scale": "Log"}, "y_scale: expected one of linear, log, got 'Log'")
        self.wrong_panel({"x_limits": [2, 1]}, "x_limits: expected the smaller number first, got [2, 1]")

    def test_what_is_wrong_with_a_curve_is_named_by_its_key(self):
        def wrong_curve(message, **change):
            self.wrong_panel({"curves": [{"x": [0, 1], "y": [0, 1], **change}]}, f"curves[0].{message}")

        wrong_curve("color: expected a colour, #rrggbb, got 'red'", color="red")
        wrong_curve("y: expected 2 numbers, got 3", y=[1, 2, 3])
        wrong_curve("x: expected a number, got '1'", x=["1", "2"])
        wrong_curve("x: expected a list of numbers, got 3", x=3)
        wrong_curve("x: expected a list of numbers, got one of shape (2, 1)", x=[[1], [2]])
        wrong_curve("width: expected a number above 0, got 0", width=0)
        wrong_curve("marks: expected one of none, dot, cross, got 'o'", marks="o")
        self.wrong_panel({"curves": [{"x": []}]}, "curves[0].y: missing")

    def test_what_is_wrong_with_other_shapes_is_named_by_its_key(self):
        shade = {"color": RED, "intervals": [[0, 1], [2]]}
        self.wrong_panel({"shades": [shade]}, "shades[0].intervals[1]: expected two numbers, got [2]")
        bars = {"edges": [0, 1], "heights": [1, 1]}
        self.wrong_panel({"bars": [bars]}, "bars[0].edges: expected 3 numbers, got 2")
        band = {"color": RED, "x": [0], "y": [0], "radius": 0.1}
        self.wrong_panel({"bands": [band]}, "bands: their radius is one of a panel with equal: true")
        self.wrong_panel({"polygons": [{"x": [0], "y": [0]}]}, "polygons[0].color: missing")


class Files(Pictures):
    def python(self, program, status):
        ran = subprocess.run([sys.executable, "-B", "-c", program], env=ENVIRONMENT, capture_output=True, text=True)
        self.assertEqual(ran.returncode, status, ran.stderr)

    def test_a_process_that_is_killed_while_it_writes_leaves_the_old_picture(self):
        draw(only(curves=[line(RED, [0, 1], [0, 1])]), self.file)
        before = self.file.read_bytes()
        self.python(
            "import os, pathlib\n"
            "from c3rt.pictures import draw\n"
            "whole = pathlib.Path.write_bytes\n"
            "def half(self, data):\n"
            "    whole(self, data[:len(data) // 2])\n"
            "    os.kill(os.getpid(), 9)\n"
            "pathlib.Path.write_bytes = half\n"
            f"draw({{'panels': [{{}}]}}, {str(self.file)!r})\n",
            -9,
        )
        self.assertEqual(self.file.read_bytes(), before)

    def test_without_room_there_is_no_file_and_an_error(self):
        self.python(
            "import resource, signal\n"
            "from c3rt.pictures import draw\n"
            "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
            "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
            "try:\n"
            f"    draw({{'panels': [{{}}]}}, {str(self.file)!r})\n"
            "except OSError:\n"
            "    raise SystemExit(7)\n",
            7,
        )
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_folder_that_is_not_there_is_an_error(self):
        with self.assertRaises(FileNotFoundError):
            draw({"panels": [{}]}, self.folder / "none" / "p.png")


class Program(Pictures):
    def program(self, document, status):
        ran = subprocess.run([sys.executable, "-B", "-m", "c3rt.pictures"], input=document, env=ENVIRONMENT,
                             capture_output=True, text=True)
        self.assertEqual(ran.returncode, status, ran.stderr)
        return ran

    def test_it_draws_all_that_it_can_and_names_the_others(self):
        files = [str(self.folder / name) for name in ("a.png", "b.png", "none/c.png", "d.png")]
        figures = [{"panels": [{}]}, {"panels": 3}, {"panels": [{}]}, {"panels": [{"curves": [line(RED, [None], [1])]}]}]
        document = {"pictures": [{"file": file, "figure": figure} for file, figure in zip(files, figures)]}
        told = json.loads(self.program(json.dumps(document), 1).stdout)
        self.assertEqual(told, {"missing": {files[1]: "panels: expected a list, got 3",
                                            files[2]: "could not write the file: No such file or directory"}})
        self.assertEqual(sorted(file.name for file in self.folder.iterdir()), ["a.png", "d.png"])
        for name in ("a.png", "d.png"):
            matplotlib.image.imread(io.BytesIO((self.folder / name).read_bytes()))
        document["pictures"] = document["pictures"][:1]
        self.assertEqual(json.loads(self.program(json.dumps(document), 0).stdout), {"missing": {}})

    def test_a_document_that_is_none_is_refused(self):
        for document in ("", "[]", "{}", '{"pictures": [{"file": "a.png"}]}'):
            self.assertIn("expected {", self.program(document, 2).stderr)


if __name__ == "__main__":
    unittest.main()

"""Pictures as PNG, from descriptions of plain data: what the reports of c3rt draw, and whoever else wants to.

Needs numpy and matplotlib (Debian: python3-matplotlib; pip: the extra `pictures`). `draw` is one picture; many at once:

    python -m c3rt.pictures < pictures.json

A figure is a dict; what stands in [] may be left out, with what then holds:

    title     [""]  above all panels
    size      [by the panels]  width and height in pixels
    columns   [1]  of panels, which are given row by row
    panels    a list of:
      title, x_label, y_label           [""]
      x_scale, y_scale                  ["linear"] or "log"
      x_limits, y_limits                [all that is drawn]  two numbers; None: all that is drawn, on that side
      equal                             [False]  one unit is as long in x as in y, as seen from above
      axes                              [True]
      legend                            ["right"] or "below"
      curves    [none]  name [""], color [by order], x, y, line ["solid"] "dashed" "none",
                        marks ["none"] "dot" "cross", width [1.5], mark_size [4] in points of print
      shades    [none]  name, color, low [0], high [1], intervals: pairs of x, shaded over this part of the height
      bands     [none]  name, color, x, y, radius: all that is as close to a path, of panels with `equal`
      bars      [none]  name, color, edges, heights: a histogram; one edge more than heights
      polygons  [none]  name, color, edge [None], x, y: filled areas

A name that is not empty has its line in the legend, beside or below the panel. Colours are "#rrggbb"; of curves without one the
first eight have those of PALETTE, the next eight the same with another line and other marks. In x and y of a curve or a
band, None, nan and infinities are gaps. Text is shown as it is given.
"""

from .description import PALETTE as PALETTE
from .description import DescriptionError
from .figure import draw

__all__ = ["DescriptionError", "draw"]

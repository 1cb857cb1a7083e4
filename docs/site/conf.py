"""Sphinx's settings for the site; build.py calls it. The order of the pages is that of docs/index.md."""
import re
from pathlib import Path

project = "c3rt"
extensions = ["myst_parser"]
myst_heading_anchors = 4  # links to headings, as a forge has them
html_theme = "furo"  # brings its own fonts, styles and search: the site needs no network
html_title = "c3rt"
html_static_path = [str(Path(__file__).parent / "style")]
html_css_files = ["site.css"]
html_copy_source = False
html_show_copyright = False


def navigation(text):
    """A table of contents for each heading of the front page: the pages that it links to, in their order."""
    parts = re.split(r"^## (.*)$", text, flags=re.MULTILINE)
    contents = []
    for caption, body in zip(parts[1::2], parts[2::2]):
        pages = [page for page in re.findall(r"\]\(([^)#]+)\.md\)", body) if page != "README"]
        contents += ["```{toctree}", ":hidden:", f":caption: {caption}", "", *pages, "```", ""]
    return "\n".join(contents)


def add_navigation(app, page, source):
    if page == app.config.root_doc:
        source[0] += "\n\n" + navigation(source[0])


def setup(app):
    app.connect("source-read", add_navigation)
    return {"parallel_read_safe": True}

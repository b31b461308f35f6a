"""Sphinx configuration of the site: `make docs`."""

import inspect
import os
import re
from pathlib import Path

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml

import hpcrub

HERE = Path(__file__).parent
ELSEWHERE = {  # pages whose text is a file outside this folder
    "start": "README.md",
    "benchmarks": "evidence/benchmarks/report.md",
    "measuring": "evidence/README.md",
    "contributing": "CONTRIBUTING.md",
    "changelog": "CHANGELOG.md",
}

project = "hpcrub"
version = release = hpcrub.__version__
copyright = "the hpcrub developers"  # noqa: A001  Sphinx asks for this name

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
]
exclude_patterns = ["_build", "figures", "reproduction"]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3
highlight_language = "text"  # of blocks that name none
nb_execution_mode = "force"  # a cache would not see a change of the program
nb_execution_raise_on_error = True
nb_execution_timeout = 300
os.environ.pop("MPLBACKEND", None)  # with another backend than their own, notebooks show no figure
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True

ALONE = "index", "start", "gallery", "theory", "cluster"  # pages that have no section
html_theme = "pydata_sphinx_theme"
html_title = "hpcrub"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_theme_options = {
    "header_links_before_dropdown": 10,
    "show_toc_level": 2,
    # the contents of a page stand under those of its section: beside both, code has no room
    "secondary_sidebar_items": {"**": []} | dict.fromkeys(ALONE, ["page-toc"]),
    "navbar_persistent": ["search-button"],
    "navigation_with_keys": False,
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_sidebars = {"**": ["sidebar-nav-bs", "page-toc"]} | dict.fromkeys(ALONE, [])
html_math_renderer = "mathml"  # needs neither a network nor LaTeX
html_show_sourcelink = False


def take_in(app, page, source):
    """A page of `ELSEWHERE` gets its text, with links that lead where they led before."""
    if page not in ELSEWHERE:
        return
    file = HERE.parent / ELSEWHERE[page]
    pages = {(HERE.parent / name).resolve(): f"{key}.md" for key, name in ELSEWHERE.items()}

    def target(link):
        there = (file.parent / link[1]).resolve()
        return f"]({pages.get(there, os.path.relpath(there, HERE))}"

    text = file.read_text("utf-8")
    if page == "start":  # what comes before and after, the home page has
        text = "# Start\n\n" + text[text.index("## Two commands") : text.index("## Where to read")]
    source[0] = re.sub(r"\]\((?!https?:|#)([^)#]+)", target, text)


def field_list(app, what, name, obj, options, lines):
    """The fields of a named tuple have their shapes and units in comments: show these."""
    if what != "class" or not hasattr(obj, "_fields"):
        return
    fields = re.findall(r"^    (\w+): [^#\n]+#[ :]*(.+)$", inspect.getsource(obj), re.MULTILINE)
    lines += ["", *(f"- ``{field}``: {text}" for field, text in fields)]


def plain_text(app, what, name, obj, options, lines):
    """Docstrings are plain text: a bar or a trailing underscore is no markup."""
    lines[:] = [re.sub(r"(\w)_(?=\W|$)", r"\1\_", line.replace("|", r"\|")) for line in lines]


def skip_fields(app, what, name, obj, skip, options):
    """The fields themselves have no more to say than their number."""
    return skip or str(getattr(obj, "__doc__", "")).startswith("Alias for field") or None


def write_math(writer, node):
    """A formula as MathML, which all browsers draw by themselves."""
    block = node.tagname == "math_block"
    mathml = tex2mathml(node.astext(), as_block=block)
    writer.body.append(f'<div class="formula">{mathml}</div>' if block else mathml)
    raise SkipNode


def setup(app):
    """Called by Sphinx."""
    app.add_html_math_renderer("mathml", (write_math, None), (write_math, None))
    app.connect("source-read", take_in)
    app.connect("autodoc-process-docstring", field_list, priority=100)
    app.connect("autodoc-process-docstring", plain_text, priority=900)
    app.connect("autodoc-skip-member", skip_fields)

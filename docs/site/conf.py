"""The site: pages of docs/, the Python package, the notebook. build.py lays its sources out and calls Sphinx."""
project = "slammot"
html_title = "slammot"
author = "The slammot authors"
root_doc = "index"
extensions = ["myst_parser", "nbsphinx", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
myst_heading_anchors = 4
html_theme = "furo"
html_extra_path = ["extra"]  # the C++ reference, pages of the gallery
highlight_language = "none"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
nbsphinx_execute = "always"
nbsphinx_timeout = 600
exclude_patterns = ["extra"]

"""How the site of this documentation is built: `make docs`."""

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent / "_ext"), str(Path(__file__).parents[1] / "scripts")]

from run_pages import package_key

import gsiirl
from gsiirl.program_cache import keep_programs

# Notebooks need not compile what an earlier build has compiled.
keep_programs()

project = "gsiirl"
author = "The gsiirl authors"
version = release = gsiirl.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "docstrings", "self_contained"]
exclude_patterns = ["_build"]

html_theme = "furo"
html_title = f"gsiirl {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("site.js", {"defer": "defer"})]
html_copy_source = False
html_show_copyright = False
highlight_language = "text"

# Headings have the anchors that GitHub gives them.
myst_heading_anchors = 4

# Every reference must have a target, but for the types of a signature: some are internal, some another package's.
nitpicky = True
nitpick_ignore_regex = [("py:(class|obj)", ".*")]

autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
napoleon_custom_sections = [("Attributes", "params_style")]
napoleon_use_rtype = False

# A notebook is run again when it or the package changes.
nb_execution_mode = "cache"
nb_execution_cache_path = str(Path(__file__).parent / "_build" / "notebooks" / package_key()[:16])
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_execution_show_tb = True
nb_merge_streams = True

"""What to cite, as BibTeX: this program in its version, and the paper that it follows.

CITATION.cff says the same; its authors are the maintainers' to fill in, and are changed here, too.
"""

from __future__ import annotations

from importlib.metadata import version

AUTHORS = "{The serpenoid authors}"
TITLE = "serpenoid: firmware, calibration and simulation of a wheeled snake robot"
PAPER = """\
@inproceedings{nirakh2005implicit,
  author = {Nirakh and Brennan and Gandhi},
  title = {An Implicit Model for Snake Robot Locomotion and Gait Optimization},
  booktitle = {Proceedings of the {ASME} International Mechanical Engineering Congress
    and Exposition},
  year = {2005},
  note = {{IMECE2005-82742}},
}
"""


def entries() -> str:
    """Return a .bib file's text."""
    return f"""\
@software{{serpenoid,
  author = {{{AUTHORS}}},
  title = {{{{{TITLE}}}}},
  version = {{{version("serpenoid")}}},
}}

{PAPER}"""

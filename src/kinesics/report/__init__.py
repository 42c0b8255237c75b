"""An analysis to a folder, to one page that can be mailed, and back.

- `save`, `load`: the folder of `kinesics analyze`
- `report_page`: the page alone
- `check_palette`: refuses a palette that the pictures cannot be drawn in
- `helping`: a second process that draws along
- `schema`: the JSON Schema that every `analysis.json` satisfies
- `kinesics.report.performances`: a new movement, where every frame comes from, and its picture
"""

from __future__ import annotations

from kinesics.report.folder import FILES, load, save, schema
from kinesics.report.helper import helping
from kinesics.report.page import report_page
from kinesics.report.pictures import check_palette

__all__ = ["FILES", "check_palette", "helping", "load", "report_page", "save", "schema"]

"""An analysis to a folder, to one page that can be mailed, and back.

- `save`, `load`: the folder of `kinesics analyze`
- `report_page`: the page alone
- `schema`: the JSON Schema that every `analysis.json` satisfies
"""

from __future__ import annotations

from kinesics.report.folder import FILES, load, save, schema
from kinesics.report.page import report_page

__all__ = ["FILES", "load", "report_page", "save", "schema"]

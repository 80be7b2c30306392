"""What the page that plays a run holds."""

from __future__ import annotations

import json
import re
from typing import Any


def data_of(page: str) -> Any:
    found = re.findall(r'<script id="run" type="application/json">(.*?)</script>', page, re.DOTALL)
    assert len(found) == 1
    return json.loads(found[0])

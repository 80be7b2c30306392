"""What the file of a run holds."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..model.model import Model
from .plain import Writer
from .record import Record
from .tables import arrays


def saved(run: Record) -> dict[str, Any]:
    """Arrays for :func:`numpy.savez`: those that anybody reads, and the rest, from which the run is made again.

    Of a run that ``simulate`` has not made, or of a model in no package, there is no rest.
    """
    named = arrays(run)
    model: Any = run.model
    if run.motion is None or not isinstance(model, Model) or model.folder is None:
        return named
    return named | {"package": np.array(model.folder.name)} | Writer(_told, named).arrays(run)


def _told(model: Any) -> Any:
    """What tells a model; None for anything else."""
    if not isinstance(model, Model):
        return None
    assert model.folder is not None
    values = dict(model.settable)
    told = {"package": model.folder.name, "name": model.name, "hash": model.data["hash"], "values": values}
    if model._begin is None:
        return told
    poses, velocities, own = model._begin
    return told | {"begin": [[list(row) for row in poses], [list(row) for row in velocities], list(own)]}

"""A simulated motion as its user has it in hand: its record, with the ways to keep it and to see it."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from .files import read_path, write_whole
from .pictures.gif import write_gif
from .pictures.player import frame_of, write_player
from .pictures.plot import draw
from .pictures.video import write_video
from .record.hybrid_state import NUMBERS, WORDS, HybridState
from .record.outputs import units_of, values_of
from .record.penetration import penetration_max
from .record.point_motion import PointMotion, point_motion
from .record.record import Record
from .record.saved import saved
from .record.tables import arrays, dataframe, dataset
from .record.trace import Traced, trace_of
from .sensitivity.jacobian import run_sensitivities, run_vjp, starts_as_scene
from .sensitivity.moving import Wrt
from .sensitivity.told import Output

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from .arrays import FloatArray
    from .model.model import Model


@dataclass(frozen=True, eq=False, repr=False)
class Run(Record):
    """A simulated motion: rows t (nt,), q (nt, nq), u (nt, nu); an impact is two rows of the same t, before and after.

    `model` carries the parameter values of its beginning, :meth:`model_at` those of later, where events have set some;
    all that is told of an instant is told with those of that instant; so are gates of joints that let go or take hold.
    `advance.between` finds states between two rows by steps of the run's method; `motion(t, q, u)` the forces along
    the run.
    `unexplained` (nt,) is what of each row's energy (J), less that of the first row, is neither work of loads nor a
    loss that an impact, a phase of kind "steps" or an event records; none is known of runs of earlier versions.
    `success` says whether the end was reached,
    `message` why not. Audits: `closure_max`, the largest gap of a cut joint (m), and `energy_drift`, the largest
    size of `unexplained` (J), over all rows; `closure_rate_max`, the largest speed at which one opens (m/s).
    `acceleration_error` is how far accelerations are from right, relative to the largest of a state, as far as the
    masses are at fault: their rounding at some of the rows, or where it is repaired, what could not be.
    Where it is known less well: `rest_speed` (m/s), 0 unless events crowded, or friction jammed, so that contacts that
    still moved, the fastest at that speed, counted as at rest; `choices`, at how many instants contacts could as well
    have stayed as left, by friction, and left, `chosen_at`, when (s) the first of these was, None without one;
    phases of kind "steps"; impacts with a `restitution_share` below 1.
    `method` and `drift` say how it was integrated and how the loops were kept shut. `state` is where it has come
    to, whole: ``simulate(model, state=run.state, until=...)`` goes on from there; None where the run was cut back.
    `traced` is the core's record of :attr:`trace`.
    `left` is the core's record of it, and how the run was integrated. `changes` are joints that let go or took hold,
    `events` the instants that the scene's `[[event]]` tables ask for.
    """

    model: Model
    left: tuple[bytes, object] | None = field(default=None, repr=False)

    @property
    def penetration_max(self) -> float:
        """Audit: the largest depth (m) over all contacts that are on and all rows; 0 of a model without contacts.

        Stops of angles count with the mechanism's length as their lever."""
        return penetration_max(self)

    @property
    def state(self) -> HybridState | None:
        """Where the run has come to."""
        if self.left is None:
            return None
        memory, asked = self.left
        settings = {name: getattr(asked, name) for name in (*NUMBERS, *WORDS)}
        end = self.t[-1].item()
        return HybridState(self.model.name, end, self.q[-1], self.u[-1], dict(self.model.parameters), settings, memory)

    def model_at(self, t: float) -> Model:
        """The model as it is at t (s): with the parameters that events have set up to then, and without the effects
        that are off; at an event as after it. :attr:`model` is that of the beginning, with all effects.

        Raises ``ValueError`` for a time outside of the run.
        """
        return cast("Model", super().model_at(t))

    def point(self, name: str, t: ArrayLike | None = None) -> PointMotion:
        """Position, velocity and acceleration of a joint or a named point, as ``model.point`` knows them, at t (s), a
        number or a row of them, or at the rows of the run.

        Accelerations are with what contacts push then, as in ``reactions``: not numbers in phases of kind "steps", nor
        beside a line of links, nor, of the rows, at the last one of a run that stopped early. At an impact time all is
        as after it; of the two rows of an impact the first is as before it.
        """
        return point_motion(self, name, t)

    @property
    def trace(self) -> tuple[Traced, ...]:
        """The last 512 things that the run did beside steps that were accepted, each with its ``t`` (s) and ``what``:
        how its stages followed each other, which steps were refused and why, which kinks effects came past."""
        return () if self.traced is None else trace_of(self.model, *self.traced)

    @property
    def stretches(self) -> tuple[Run, ...]:
        return (self,)

    @property
    def outputs(self) -> dict[str, str]:
        """The unit of all that :meth:`values` knows by name: ``crank.angle``, ``coupler.tip.vy``, ``hinge.force``.

        Those of a link are of its frame against the ground, those of a joint of its second link against the first;
        a joint's force is that of :meth:`reactions`. What would be two things by one name begins with what it is of:
        ``link crank.angle``, ``joint crank.angle``.
        """
        return units_of(self.model)

    def values(self, *names: str, t: ArrayLike | None = None) -> dict[str, FloatArray]:
        """Outputs by name at t (s), a number () or a row of times (n,), or at the rows of the run (nt,).

        As exact as the run at any t. At an impact time they are those after it; of the two rows of an impact the first
        is as before it. All is of the mechanism as it is then, :meth:`model_at`. Forces and accelerations are not
        numbers where the run knows none, as :meth:`point` says, nor are gaps, lengths and depths of what events have
        switched off; its forces are zero.

        Raises ``ValueError`` for names that are none, with those that are near, and for times outside of the run.
        """
        return values_of(self, names, t)

    def __getitem__(self, name: str) -> FloatArray:
        """One output at the rows of the run, (nt,)."""
        if not isinstance(name, str):
            raise TypeError(f"output: found {name!r}, expected a name such as {next(iter(self.outputs))!r}")
        return values_of(self, [name])[name]

    def jacobian(
        self,
        wrt: Wrt,
        outputs: Sequence[Output] | Output = ("q", "u"),
        at: ArrayLike | None = None,
    ) -> FloatArray:
        """What the ``outputs`` move by, one below the other, (numbers, columns), at the times ``at`` (s), the end of
        the run unless given: the ``jacobian`` of :func:`~.sensitivities.sensitivities`, which has them by name, and
        says what ``wrt`` and ``outputs`` may be and what is refused.

        Where the run's first row is the scene's start it moves with the parameters as that does; else it is the start
        that was given, put onto the closure.
        """
        given = None if starts_as_scene(self) else (self.q[0], self.u[0])
        return run_sensitivities(self, wrt, outputs, at, given).jacobian

    def vjp(
        self,
        covector: ArrayLike,
        wrt: Wrt,
        outputs: Sequence[Output] | Output = ("q", "u"),
        at: ArrayLike | None = None,
    ) -> FloatArray:
        """A ``covector`` (numbers,) times :meth:`jacobian`, (columns,), in adjoint mode: the gradient of the number
        that it makes of the ``outputs``; rows of covectors (k, numbers) give (k, columns).

        Numbers are those of the outputs one below the other, in the order of the rows of :meth:`jacobian`, whose
        arguments and refusals the others are. Raises ``ValueError`` for a covector of another shape.
        """
        given = None if starts_as_scene(self) else (self.q[0], self.u[0])
        return run_vjp(self, covector, wrt, outputs, at, given)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write everything recorded to an .npz file, whole or not at all.

        `numpy.load` reads its arrays, :func:`ccgen.runtime.load_run` makes the run of it again.
        """
        target = read_path(path, "an .npz file")
        if target.suffix != ".npz":
            raise ValueError(f"path: a run is saved as .npz, found {target.name!r}, expected a name that ends so")
        write_whole(target, lambda part: np.savez_compressed(part, **saved(self)))
        return target

    def _arrays(self) -> dict[str, Any]:
        return arrays(self)

    def to_xarray(self, names: Sequence[str] | None = None, t: ArrayLike | None = None) -> Any:
        """The run as an xarray.Dataset: rows over `t`, impacts over `impact`, their contacts over `contact`.

        What a run has none of, as impacts, is left out with its dimension. With ``names``, or at a row of times t:
        outputs over `t` alone, with their units, as :meth:`to_dataframe` has them.
        """
        return dataset(self, names, t)

    def to_dataframe(self, names: Sequence[str] | None = None, t: ArrayLike | None = None) -> Any:
        """A pandas.DataFrame over `t` (s) of outputs by name, or of coordinates, velocities and energies.

        At the rows of the run, an impact being two of the same t, before and after; or at a row of times t.

        `attrs["units"]` has the unit of every column.
        """
        return dataframe(self, names, t)

    def plot(self, path: str | os.PathLike[str] | None = None, *, forces: bool = False) -> Figure:
        """A figure of poses, energy, heights and closure over time; with a path it is also saved there, as a PNG,
        in place of what is there. With `forces` poses have arrows of what grounds push: forces (N), at impacts
        impulses (N s), in each pose as long as the view is best filled."""
        figure: Figure = draw(self, path, forces=forces)
        return figure

    def animate(self, path: str | os.PathLike[str]) -> Path:
        """Write the motion as a page that plays in a browser (.html) or as a moving picture (.gif)."""
        target = read_path(path, "an .html or .gif file")
        if target.suffix == ".html":
            return write_player(self, target)
        if target.suffix == ".gif":
            return write_gif(self, target)
        raise ValueError(
            f"path: found {target.name!r}, expected a name that ends in .html or .gif, a page or a picture; use one of "
            "the two, or save_video"
        )

    def save_player(self, path: str | os.PathLike[str], outputs: Sequence[str] | None = None) -> Path:
        """Write the motion as one page (.html) that plays in a browser, of at most 10 MB.

        ``outputs`` are names of :attr:`outputs` that are plotted below the motion at first; energies unless given. They
        are in the page beside some forty others that it offers. Raises ``ValueError`` for names that are none.
        """
        target = read_path(path, "an .html file")
        if target.suffix != ".html":
            raise ValueError(f"path: a player is saved as .html, found {target.name!r}, expected a name that ends so")
        return write_player(self, target, outputs)

    def save_video(self, path: str | os.PathLike[str]) -> Path:
        """Write the motion as a video (.mp4), in real time, by the program ffmpeg.

        Raises ``OSError`` where that is not on PATH.
        """
        target = read_path(path, "an .mp4 file")
        if target.suffix != ".mp4":
            raise ValueError(f"path: a video is saved as .mp4, found {target.name!r}, expected a name that ends so")
        return write_video(self, target)

    def _repr_html_(self) -> str:
        """The player, as notebooks show it: at most 2 MB."""
        return frame_of(self)

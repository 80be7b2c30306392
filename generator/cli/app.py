"""Options and commands of ``ccgen``; each command is in the file of its name."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .refusal import Commands, Faults

app = typer.Typer(cls=Commands, add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="a scene file (TOML)")]
Fold = Annotated[bool, typer.Option("--fold", help="put the values of the parameters into the code as numbers")]

Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="PATH=VALUE",
        help='another value of a parameter, as crank.mass=2 or crank.mass="2 kg", or of the start, as '
        'start.angles.crank="30 deg"; may be repeated',
    ),
]

Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="say more: the branch of every loop")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="say nothing but errors and warnings beside the result")]


@app.callback(invoke_without_command=True)
def root(
    context: typer.Context,
    links: Annotated[str | None, typer.Option(metavar="N", help="a floating loop of N unit rods")] = None,
    pinned: Annotated[bool, typer.Option("--pinned", help="with --links: both ends on the ground")] = False,
    open_: Annotated[bool, typer.Option("--open", help="with --links: an open chain, free in the plane")] = False,
    hinged: Annotated[bool, typer.Option("--hinged", help="with --open: the first end on the ground")] = False,
    gravity: Annotated[bool, typer.Option("--gravity", help="with --links: add gravity, 9.81 m/s²")] = False,
    scene: Annotated[Path | None, typer.Option(metavar="FILE", help="a scene file (TOML)")] = None,
    out: Annotated[Path, typer.Option(metavar="DIR", help="folder for generated models")] = Path("build"),
    fold: Fold = False,
    precision: Annotated[
        str | None, typer.Option(metavar="NAME", help="numbers of the model: float, double or wide [double]")
    ] = None,
    derivatives: Annotated[
        bool, typer.Option("--derivatives", help="add the derivatives of its functions, for Python's model.derivatives")
    ] = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
    version: Annotated[bool, typer.Option("--version", help="print the version and stop")] = False,
) -> None:
    """Planar mechanisms with closed chains as compiled equations of motion.

    With --links or --scene: generate a model. Otherwise: one of the commands.
    """
    from .build import Standard, build, print_version
    from .detail import detail

    standard, faults = Standard(links, pinned, open_, hinged, gravity), Faults()
    if context.invoked_subcommand is not None:
        faults.of(standard.refuse, f"the command {context.invoked_subcommand}", scene)
        given = (("--fold", fold), ("--derivatives", derivatives), ("--verbose", verbose), ("--quiet", quiet))
        for option, found in given:
            if found:
                faults.add(
                    f"{option}: found before the command {context.invoked_subcommand}, expected behind it; move it"
                )
        if precision is not None:
            faults.add(
                f"--precision: found before the command {context.invoked_subcommand}, expected without it; leave it out"
            )
        faults.stop_if_any()
    elif version:
        print_version()
    elif links is None and scene is None and standard == Standard(None):
        asked = (("--fold", fold), ("--derivatives", derivatives), ("--precision", precision))
        for option, there in asked:
            if there:
                faults.add(f"{option}: found without --links or --scene, expected one of them; say what is to be built")
        faults.stop_if_any()
        typer.echo(context.get_help(), err=True)
        raise typer.Exit(2)
    else:
        said = detail(faults, verbose, quiet)
        build(standard, scene, out, fold, precision or "double", derivatives, said, faults)


@app.command()
def run(
    scene: SceneFile,
    until: Annotated[str | None, typer.Option(metavar="T", help="end of the run in s")] = None,
    rtol: Annotated[str | None, typer.Option(metavar="TOL", help="relative tolerance")] = None,
    method: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="integration method: gauss, dop853, dopri5, radau or moreau [gauss]"),
    ] = None,
    step: Annotated[
        str | None, typer.Option(metavar="H", help="length of all steps in s, instead of one that rtol chooses")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="folder of results [results/<name>]")] = None,
    gif: Annotated[bool, typer.Option("--gif", help="write an animation as GIF too")] = False,
    video: Annotated[bool, typer.Option("--video", help="write an animation as MP4 too, by ffmpeg")] = False,
    plot: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES",
            help="draw outputs over time, in the player too, as crank.angle,coupler.tip.vy; of a point its path",
        ),
    ] = None,
    csv: Annotated[
        bool, typer.Option("--csv", help="write forces, impacts, phases, and what is plotted, as CSV too")
    ] = False,
    times: Annotated[
        str | None, typer.Option(metavar="N", help="with --csv: at N even times, not at the rows of the run")
    ] = None,
    trace: Annotated[
        bool, typer.Option("--trace", help="print what the run did last beside steps: events, refused steps, kinks")
    ] = False,
    settings: Set = None,
    fold: Fold = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> None:
    """Simulate a scene; print impacts, largest forces and audit; write result, plot, forces and player.

    With --quiet the results are written only.
    Exit code 0: the end was reached, 2: wrong input, 3: stopped early, by itself or by Ctrl-C, with results written,
    or some of the pictures and tables cannot be made of the run.
    """
    from .detail import detail
    from .outputs import Wanted, read_wanted
    from .run import GIF, VIDEO, Asked
    from .run import run as work
    from .settings import read_settings

    faults = Faults()
    values = read_settings(settings or [], faults)
    wanted = faults.of(read_wanted, None if plot is None else [plot], csv, times) or Wanted()
    said = detail(faults, verbose, quiet)
    moving = [name for name, given in ((GIF, gif), (VIDEO, video)) if given]
    work(scene, Asked(until, rtol, method, step, trace), out, moving, fold, said, wanted, csv, values, faults)


@app.command()
def plot(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="a folder of results, or its result.npz")],
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="NAMES", help="outputs, as crank.angle pin.force; without any: all names are printed"),
    ] = None,
    csv: Annotated[bool, typer.Option("--csv", help="write them as CSV too")] = False,
    times: Annotated[
        str | None, typer.Option(metavar="N", help="with --csv: at N even times, not at the rows of the run")
    ] = None,
    models: Annotated[Path, typer.Option(metavar="DIR", help="folder of generated models")] = Path("build"),
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="folder of the files [that of the run]")] = None,
) -> None:
    """Draw outputs of a run that is done, over time; nothing is simulated again.

    Exit code 0: drawn, 2: wrong input.
    """
    from .outputs import Wanted, read_wanted
    from .plot import plot as work

    faults = Faults()
    wanted = faults.of(read_wanted, names, csv, times, "NAMES") or Wanted()
    work(run, wanted, models, out, faults)


@app.command()
def show(
    scene: SceneFile,
    equations: Annotated[bool, typer.Option("--equations", help="the equations below it")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="with the equations, as LaTeX")] = False,
    expand: Annotated[bool, typer.Option("--expand", help="with the classical closed form, for few links")] = False,
    fold: Fold = False,
    plan: Annotated[
        str | None, typer.Option(metavar="NAME", help="another order of elimination: tip to root, dyads or segments")
    ] = None,
    tolerances: Annotated[
        bool, typer.Option("--tolerances", help="the thresholds of a run instead: how large here, what for, and why")
    ] = False,
    outputs: Annotated[
        bool, typer.Option("--outputs", help="names and units of what runs say instead, as for run --plot")
    ] = False,
    settings: Set = None,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> None:
    """Print a scene's degrees of freedom, loops, operation counts, what each effect adds to them, and its equations."""
    from .detail import detail
    from .settings import read_settings
    from .show import show as work

    faults = Faults()
    values = read_settings(settings or [], faults)
    instead = [name for name, given in (("--tolerances", tolerances), ("--outputs", outputs)) if given]
    work(scene, equations, latex, expand, fold, plan, detail(faults, verbose, quiet), instead, values, faults)


@app.command()
def cost(
    scene: SceneFile,
    until: Annotated[str | None, typer.Option(metavar="T", help="end of the motion in s")] = None,
    error: Annotated[str | None, typer.Option(metavar="ERR", help="wanted error in m, rad and s [1e-8]")] = None,
    drift: Annotated[bool, typer.Option("--drift", help="compare ways to keep the loops shut too")] = False,
    precision: Annotated[
        str | None, typer.Option(metavar="NAMES", help="measure in these numbers: float,double,wide [double]")
    ] = None,
    effects: Annotated[bool, typer.Option("--effects", help="measure what each effect costs instead")] = False,
    fold: Annotated[bool, typer.Option("--fold", help="with --effects: numbers for parameters too")] = False,
    gradient: Annotated[bool, typer.Option("--gradient", help="measure derivatives of the end instead")] = False,
    by: Annotated[
        str | None, typer.Option(metavar="NAMES", help="with --gradient: parameters, q0, u0 [all that can be]")
    ] = None,
    settings: Set = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="folder of the figures")] = None,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> None:
    """Measure error against wall time for all methods and tolerances, and say which to choose.

    With --effects measure the price of each effect instead, in operations and in time; with --gradient error against
    wall time of derivatives, by differences over their steps and along the run.
    """
    from .cost import cost as work
    from .detail import detail
    from .settings import read_settings

    faults = Faults()
    values = read_settings(settings or [], faults)
    told = detail(faults, verbose, quiet)
    work(scene, until, error, drift, precision, effects, fold, gradient, by, out, told, values, faults)


@app.command()
def torque(
    scene: SceneFile,
    joint: Annotated[
        str | None,
        typer.Argument(
            metavar="JOINT",
            help="the joint that drives, or a link pinned to the ground; the scene's driven joint unless given",
        ),
    ] = None,
    rate: Annotated[
        str | None,
        typer.Option(
            metavar="W", help="its constant rate in rad/s, 0 for statics [the speed of its [[drive]] at t = 0, or 1]"
        ),
    ] = None,
    plot: Annotated[Path | None, typer.Option(metavar="FILE", help="write the curve as PNG")] = None,
    settings: Set = None,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> None:
    """Print the torque that a driven crank needs over one turn at a constant rate; contacts bar the way."""
    from .detail import detail
    from .settings import read_settings
    from .statics import torque as work

    faults = Faults()
    values = read_settings(settings or [], faults)
    work(scene, joint, rate, plot, detail(faults, verbose, quiet), values, faults)


@app.command()
def equilibrium(
    scene: SceneFile,
    nearest: Annotated[bool, typer.Option("--nearest", help="the nearest one, stable or not")] = False,
    settings: Set = None,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> None:
    """Print a static equilibrium, on closed contacts too: whether it is stable, forces at joints and contacts."""
    from .detail import detail
    from .settings import read_settings
    from .statics import equilibrium as work

    faults = Faults()
    values = read_settings(settings or [], faults)
    work(scene, nearest, detail(faults, verbose, quiet), values, faults)


@app.command()
def orbit(
    scene: SceneFile,
    section: Annotated[
        str,
        typer.Option(
            metavar="WHERE",
            help="the period of what drives it, as 0.2 or 2*pi/3, a contact behind whose impact it is compared, as "
            "ball.C,ground_0, or a coordinate that passes a value, as rod.angle=0.3",
        ),
    ],
    guess: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE", help="a coordinate or rate near the motion [the scene's start]; may be repeated"
        ),
    ] = None,
    relabel: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=NAME",
            help="what a coordinate becomes before it is compared: another, with a minus or not, or a number; may be "
            "repeated",
        ),
    ] = None,
    advances: Annotated[
        str | None, typer.Option(metavar="NAMES", help="coordinates that need not come back, as hip.x")
    ] = None,
    crossings: Annotated[str | None, typer.Option(metavar="N", help="crossings of the section [1]")] = None,
    until: Annotated[
        str | None, typer.Option(metavar="T", help="how long a run may take to get to a contact in s")
    ] = None,
    rtol: Annotated[str | None, typer.Option(metavar="TOL", help="relative tolerance")] = None,
    method: Annotated[str | None, typer.Option(metavar="NAME", help="integration method [gauss]")] = None,
    segments: Annotated[
        str | None,
        typer.Option(
            metavar="N",
            help="segments that begin anew, of a motion whose neighbours leave it fast [1]; N has to divide "
            "--crossings where the model depends on time, and where that is more than 1",
        ),
    ] = None,
    most: Annotated[str | None, typer.Option(metavar="N", help="steps that Newton's method may take [30]")] = None,
    along: Annotated[
        str | None,
        typer.Option(metavar="PARAM=LOW:HIGH", help="follow it along a parameter; write branch.csv and branch.png"),
    ] = None,
    double: Annotated[
        bool, typer.Option("--double", help="with --along: follow motions of twice the period from its flips too")
    ] = False,
    settled: Annotated[
        str | None, typer.Option(metavar="N", help="with --along: draw where runs settle at N values too")
    ] = None,
    show: Annotated[
        str | None, typer.Option(metavar="NAME", help="with --along: which coordinate or rate is drawn")
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="folder of results [results/<name>-orbit]")] = None,
    settings: Set = None,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> None:
    """Find a periodic motion, stable or not; print its period, multipliers and state, and follow it along a parameter.

    Exit code 0: found, 2: wrong input, or none was found.
    """
    from .detail import detail
    from .orbit import Wanted
    from .orbit import orbit as work
    from .settings import read_settings

    faults = Faults()
    values = read_settings(settings or [], faults)
    wanted = Wanted(
        section,
        guess or [],
        relabel or [],
        advances,
        crossings,
        until,
        rtol,
        method,
        segments,
        most,
        along,
        double,
        settled,
        show,
        out,
    )
    work(scene, wanted, detail(faults, verbose, quiet), values, faults)


@app.command()
def sweep(
    scene: SceneFile,
    plan: Annotated[Path, typer.Argument(metavar="PLAN", help="a plan of what varies and what is observed (TOML)")],
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="folder of the table [results/<plan>-sweep]")] = None,
    threads: Annotated[str | None, typer.Option(metavar="N", help="threads [as many as there are processors]")] = None,
    chunk: Annotated[
        str | None, typer.Option(metavar="N", help="runs that are made at a time [by what they take]")
    ] = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="by the workers of a Dask scheduler, as tcp://host:8786")
    ] = None,
    plot: Annotated[bool, typer.Option("--plot", help="draw a map or histograms of what is observed")] = False,
    netcdf: Annotated[Path | None, typer.Option(metavar="FILE", help="write the table as NetCDF too")] = None,
    zarr: Annotated[Path | None, typer.Option(metavar="DIR", help="write the table as Zarr too")] = None,
    settings: Set = None,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> None:
    """Make many runs of a scene, whose numbers a plan varies, into a table of Parquet files; or go on with it.

    Exit code 0: all runs are made, those that stopped being rows that say so, 2: wrong input, 3: stopped early, by
    Ctrl-C or a full disk, with what is done kept: start it again to go on.
    """
    from .detail import detail
    from .settings import read_settings
    from .sweep import sweep as work

    faults = Faults()
    values = read_settings(settings or [], faults)
    said = detail(faults, verbose, quiet)
    work(scene, plan, out, threads, chunk, dask, plot, netcdf, zarr, said, values, faults)


@app.command()
def replay(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="the folder of a sweep")],
    scene: SceneFile,
    plan: Annotated[Path, typer.Argument(metavar="PLAN", help="its plan")],
    run: Annotated[int, typer.Argument(metavar="RUN", help="the number of the run, as in its column")],
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="folder of the files [FOLDER/run-RUN]")] = None,
    settings: Set = None,
) -> None:
    """Make one run of a sweep again and write its result, plot and player. Exit code 0: written, 2: wrong input."""
    from .detail import detail
    from .settings import read_settings
    from .sweep import replay as work

    faults = Faults()
    values = read_settings(settings or [], faults)
    work(folder, scene, plan, run, out, detail(faults, False, False), values, faults)


@app.command()
def check() -> None:
    """Say whether this installation works: which compiler is found, and a falling hexagon against the closed form.

    Exit code 0: it does, 1: numbers are wrong, 2: there is no compiler, or it fails.
    """
    from .check import check as work

    work()


@app.command()
def diff(
    old: Annotated[str, typer.Argument(metavar="OLD", help="a generated folder, an equations.txt or a scene")],
    new: Annotated[str, typer.Argument(metavar="NEW", help="what to compare it with")],
) -> None:
    """Compare equations: as text, and by numbers at random states. Exit code 0: same, 1: different, 2: trouble."""
    from .diff import diff as work

    work(old, new)

"""The command line: `vsb run`, `vsb check`, `vsb shell`, and one command per workflow rule."""

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vsb import __version__
from vsb.errors import ConfigError, VsbError
from vsb.stages.run import ERROR, cores, run
from vsb.study.plan import StudyPlan
from vsb.study.study import load

if TYPE_CHECKING:
    from vsb.hydro.database import Check

Handler = Callable[[argparse.Namespace], int]


def _spec() -> dict[str, Any]:
    """The specification of a rule, as JSON on standard input: of any length, unlike an argument."""
    if sys.stdin.isatty():
        raise ConfigError("standard input: received a terminal, needs the specification of the rule as JSON")
    text = sys.stdin.read()
    try:
        spec = json.loads(text)
    except ValueError as error:
        raise ConfigError(f"standard input: not valid JSON ({error}); needs the specification of the rule") from None
    if not isinstance(spec, dict):
        raise ConfigError(f"standard input: received {text[:40]}, needs a mapping")
    return spec


def _rule(name: str) -> Handler:
    """Handler of a rule's command: imports the science only when it is needed."""

    def handle(args: argparse.Namespace) -> int:
        from vsb.stages import coefficients, compare, database, meshes, modes, radiation, response, simulate
        from vsb.stages import report as publish

        calls: dict[str, Callable[[], None]] = {
            "modes": lambda: modes.shell_modes(_spec(), args.out),
            "mesh": lambda: meshes.mesh(_spec(), args.out),
            "display-meshes": lambda: meshes.display_meshes(_spec(), args.out),
            "green": lambda: coefficients.green(args.folder, args.out),
            "bem": lambda: coefficients.bem_block(_spec(), args.mesh, args.green, args.out),
            "spectral": lambda: coefficients.spectral_block(_spec(), args.out),
            "database": lambda: database.build_database(_spec(), args.blocks, args.out),
            "radiation": lambda: radiation.fit_radiation(_spec(), args.database, args.out),
            "response": lambda: response.frequency_response(_spec(), args.database, args.out),
            "simulate": lambda: simulate.simulate(_spec(), vars(args), args.out),
            "compare": lambda: compare.compare_designs(_spec(), vars(args)),
            "figures": lambda: publish.figures(_spec(), vars(args)),
            "report": lambda: publish.report(_spec(), vars(args)),
        }
        calls[name]()
        return 0

    return handle


def check(args: argparse.Namespace) -> int:
    """Validate a study, print what it would cost and what to doubt; solve nothing."""
    from vsb.stages import preview

    study = load(args.config)
    for line in preview.summary(study, StudyPlan(study)):
        print(line)
    return 0


def shell(args: argparse.Namespace) -> int:
    """Print dry natural frequencies of both branches, the paper's Ritz column, and the buckling pressure."""
    from vsb.stages import preview

    table = preview.shell_table(load(args.config))
    print(json.dumps(table, indent=1) if args.json else preview.shell_text(table))
    return 0


def export(args: argparse.Namespace) -> int:
    """Write the hydro database of a study, or a database file, for other codes: WAMIT's files and WEC-Sim's .h5."""
    from vsb.hydro.formats import exchange as interchange

    if (path := Path(args.config)).suffix == ".nc":
        files = interchange.export(path, args.folder, path.stem)
    else:
        study = load(args.config)
        stored = Path(StudyPlan(study).database_path)
        files = interchange.export(stored, args.folder, study.study, expected_id=stored.stem)
    print(*files, sep="\n")
    return 0


def import_wamit(args: argparse.Namespace) -> int:
    """Read WAMIT's output, generalized modes included, into a hydro database with the verdict of its identities."""
    from vsb.stages import exchange

    names = ("density", "gravity", "length", "depth", "axisymmetric")
    found = exchange.import_wamit(args.folder, args.name, args.out, **{name: getattr(args, name) for name in names})
    causes = "--length ULEN, --density and --gravity those of the run, and PER a column of periods (IPEROUT = 1)"
    return _imported(*found, args.out, causes)


def import_bemio(args: argparse.Namespace) -> int:
    """Read a BEMIO .h5 file of one body into a hydro database with the verdict of its identities."""
    from vsb.stages import exchange

    found = exchange.import_bemio(args.file, args.out, axisymmetric=args.axisymmetric)
    return _imported(*found, args.out, "scaled and rho in the file those its numbers were divided by")


def _imported(checks: "list[Check]", notes: list[str], out: str, causes: str) -> int:
    """Print the verdict on numbers of others, and where it fails what to look at."""
    if code := print_verdict(checks, "\n".join([*notes, out])):
        print(f"a check fails: are {causes}?")
    return code


def body(args: argparse.Namespace) -> int:
    """Solve any mesh with any displacements into a hydro database and print its verdict; 1 if a check fails."""
    from vsb.hydro.bodies import study as bodystudy

    return print_verdict(bodystudy.run(args.config, args.out), f"{args.out}: blocks and database")


def print_verdict(checks: "list[Check]", files: str) -> int:
    """Print a verdict and what was written; 1 if a check fails."""
    for check in checks:
        print(f"{check.verdict:12} {check.name} = {check.value:.3g} (limit {check.limit:g}): {check.explanation}")
    print(files)
    return int(any(check.verdict == "fail" for check in checks))


def shape_dependence(args: argparse.Namespace) -> int:
    """Shape database of a deep-water study, a figure, and one line: whether its power depends on the shape."""
    from vsb.stages import shape_dependence as stage

    answer = stage.shape_dependence(load(args.config), f"{args.out}.nc", f"{args.out}.svg")
    print(f"{args.out}.nc {args.out}.svg\n{answer}")
    return 0


AXISYMMETRIC = "the body and its generalized modes are: more can be checked"
BEM_FILES = ("database", "radiation", "response")
"""Options a model without BEM does not have."""


def _add_rule(commands: Any, name: str, text: str, *options: str) -> None:
    """Declare the command of one rule with its options."""
    parser = commands.add_parser(name, help=text, description=text)
    for option in options:
        needed = option not in BEM_FILES or name in ("radiation", "response")
        parser.add_argument(f"--{option}", required=needed, metavar="PATH")
    parser.set_defaults(handler=_rule(name))


def parser() -> argparse.ArgumentParser:
    """Return the argument parser of the command line."""
    top = argparse.ArgumentParser(prog="vsb", description=__doc__)
    top.set_defaults(writes=())
    top.add_argument("--version", action="version", version=f"vsb {__version__}")
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")
    more = "Further options, such as -n, go to snakemake."
    one = commands.add_parser("run", help="run a whole study through Snakemake", description=run.__doc__, epilog=more)
    one.add_argument("config", metavar="CONFIG")
    one.add_argument("--profile", default="default", help="folder under profiles/ (default: default)")
    one.add_argument("--cores", "-c", type=cores, metavar="N", help="processor cores to use, or all")
    one.set_defaults(handler=run)  # what it does not know goes to snakemake, see main
    one = commands.add_parser("check", help="validate a study, solve nothing", description=check.__doc__)
    one.add_argument("config", metavar="CONFIG")
    one.set_defaults(handler=check)
    one = commands.add_parser("shell", help="natural frequencies of the dry shell", description=shell.__doc__)
    one.add_argument("config", metavar="CONFIG")
    one.add_argument("--json", action="store_true", help="print JSON")
    one.set_defaults(handler=shell)
    one = commands.add_parser("export", help="database as WAMIT files and WEC-Sim .h5", description=export.__doc__)
    one.add_argument("config", metavar="CONFIG|DATABASE.nc", help="a study, or a database of body, barge or import")
    one.add_argument("folder", metavar="FOLDER")
    one.set_defaults(handler=export, writes=("{folder}/",))
    one = commands.add_parser(
        "import-wamit", help="hydro database from WAMIT's output", description=import_wamit.__doc__
    )
    one.add_argument("folder", metavar="FOLDER")
    one.add_argument("name", metavar="NAME", help="of NAME.1, NAME.3, NAME.hst")
    one.add_argument("out", metavar="DATABASE.nc")
    one.add_argument("--density", type=float, default=1025.0, help="of the water [kg/m^3] (default: 1025)")
    one.add_argument("--gravity", type=float, default=9.81, help="GRAV [m/s^2] (default: 9.81)")
    one.add_argument("--length", type=float, default=1.0, help="ULEN [m] (default: 1)")
    one.add_argument("--depth", type=float, default=float("inf"), help="HBOT [m] (default: deep water)")
    one.set_defaults(handler=import_wamit, writes=("{out}",))
    one.add_argument("--axisymmetric", action="store_true", help=AXISYMMETRIC)
    one = commands.add_parser("import-bemio", help="hydro database from BEMIO's .h5", description=import_bemio.__doc__)
    one.add_argument("file", metavar="FILE.h5")
    one.add_argument("out", metavar="DATABASE.nc")
    one.add_argument("--axisymmetric", action="store_true", help=AXISYMMETRIC)
    one.set_defaults(handler=import_bemio, writes=("{out}",))
    words = "hydro database of any mesh with any displacements"
    one = commands.add_parser("body", help=words, description=body.__doc__)
    one.add_argument("config", metavar="CONFIG")
    one.add_argument("out", metavar="FOLDER")
    one.set_defaults(handler=body, writes=("{out}/",))
    words = "how much the coefficients depend on the shape"
    one = commands.add_parser("shape-dependence", help=words, description=shape_dependence.__doc__)
    one.add_argument("config", metavar="CONFIG")
    one.add_argument("out", metavar="OUT", help="of OUT.nc and OUT.svg")
    one.set_defaults(handler=shape_dependence, writes=("{out}.nc", "{out}.svg"))
    _add_rule(commands, "modes", "rule: shell modes", "out")
    _add_rule(commands, "mesh", "rule: mean wetted mesh", "out")
    _add_rule(commands, "display-meshes", "rule: viewable deformed meshes", "out")
    _add_rule(commands, "green", "rule: Green-function table", "folder", "out")
    _add_rule(commands, "bem", "rule: one block of frequencies", "mesh", "green", "out")
    _add_rule(commands, "spectral", "rule: one block of frequencies without panels", "out")
    _add_rule(commands, "database", "rule: hydro database from blocks", "blocks", "out")
    _add_rule(commands, "radiation", "rule: radiation model", "database", "out")
    _add_rule(commands, "response", "rule: frequency response", "database", "out")
    _add_rule(commands, "simulate", "rule: one design in one sea", "database", "radiation", "out")
    runs = (*BEM_FILES, "trajectories", "out")
    _add_rule(commands, "compare", "rule: comparison and validity", *runs, "statistics", "validity", "study")
    _add_rule(commands, "figures", "rule: all figures", *runs, "modes")
    _add_rule(commands, "report", "rule: HTML report", *runs, "table", "statistics", "validity", "figures")
    return top


def _check_writable(names: Sequence[str]) -> None:
    """Check that files, and folders, whose names end in /, can be written: minutes of work must not end in an error."""
    for name in names:
        from vsb.tools.files import check_file, check_folder

        (check_folder if name.endswith("/") else check_file)(name.removesuffix("/"))


def _mistake(text: str, config: str | None = None) -> int:
    """Say in one line what is the user's to mend, in which study file if `config` is not named yet; return 2."""
    named = text if config is None or text.startswith(f"{config}:") else f"{config}: {text}"
    print(f"{ERROR} {' '.join(named.split())}", file=sys.stderr)
    return 2


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; a user's mistake is one line on stderr and exit code 2."""
    return answer(parser(), argv)


def answer(line: argparse.ArgumentParser, argv: Sequence[str] | None) -> int:
    """Run the command of a parser, whose `handler` gets the arguments; a user's mistake is one line and exit code 2.

    `writes` of a command names the files, and the folders, whose names end in /, that it must be able to write.
    """
    args, rest = line.parse_known_args(argv)
    handler: Handler = args.handler
    if rest and handler is not run:
        line.error(f"unrecognized arguments: {' '.join(rest)}")
    args.snakemake = rest
    try:
        _check_writable([name.format(**vars(args)) for name in args.writes])
        return handler(args)
    except VsbError as error:
        return _mistake(str(error), vars(args).get("config") if isinstance(error, ConfigError) else None)
    except OSError as error:
        if error.filename is None:  # of no file: not the user's
            raise
        reason = f"{error.filename2 or error.filename}: cannot be read or written ({error.strerror})"
        return _mistake(f"{reason}; needs a path you may use")
    except KeyboardInterrupt:
        print("vsb: interrupted; run the same command again to go on from here", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())

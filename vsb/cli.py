"""The command line: commands for people, and one per rule of the workflow."""

import argparse
import json
import os
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import vsb.tools.garbage
import vsb.tools.threads  # noqa: F401  before NumPy is loaded
from vsb import __version__
from vsb.errors import INTERRUPTED, ConfigError, VsbError
from vsb.keys.quantities import Section
from vsb.keys.reading import nearest
from vsb.pipeline.graph import StudyPlan
from vsb.pipeline.jobs import RULES
from vsb.pipeline.plans import CampaignPlan, DesignPlan, plan_of
from vsb.stages.check import summary
from vsb.stages.init import init, init_body, init_campaign, init_design
from vsb.stages.run import ERROR, check_name, cores, run
from vsb.stages.stage import run_job
from vsb.study.study import BuoyStudy, load
from vsb.tools.commands import long_options

if TYPE_CHECKING:
    from vsb.engine.hydro.database import Check

Handler = Callable[[argparse.Namespace], int]
FIRST = """a study of your own:
  vsb init my.yaml      write a commented file
  vsb check my.yaml     show its CPU time and warnings
  vsb run my.yaml       compute it: results/my/report.html"""
EXAMPLES = {
    "init": "my.yaml --radius 3", "run": "my.yaml", "design": "my_design.yaml", "check": "my.yaml",
    "schema": "campaign > campaign.json", "verify": "results/my", "shell": "my.yaml --json",
    "shape-dependence": "my.yaml shape", "body": "float.yaml results/float", "export": "my.yaml wec-sim",
    "series": "results/my/trajectories/free-regular_A0.2_T2.9.nc free.csv",
    "import-wamit": "wamit/ float float.nc --length 1", "import-bemio": "rm3.h5 rm3.nc",
    "import-nemoh": "nemoh/ float.nc",
    "matrix": "results/my --out matrix.csv",
    "compare": "soft.yaml stiff.yaml --out both.html", "figures": "my.yaml --pdf --out paper",
    "stage": "database < tasks.json",
}  # fmt: skip
"""Arguments of an example of each command."""
ARGUMENTS = {
    "STUDY.yaml": "file to write, which must not exist", "CONFIG": "file of a study, campaign or design problem",
    "DESIGN": "file of a design problem", "CONFIG|FOLDER": "file of a study, or a folder of results",
    "CONFIG|DATABASE.nc": "file of a study, or a hydro database", "OUT": "name of the files to write, without ending",
    "TRAJECTORY.nc": "run in time, a file in results/STUDY/trajectories", "OUT.csv|OUT.nc": "file to write",
    "body CONFIG": "body file: its mesh, motions and frequencies", "shell CONFIG": "file of a study of a buoy",
    "shape-dependence CONFIG": "file of a study of a buoy in deep water",
    "import-wamit FOLDER": "folder of WAMIT's output", "import-nemoh FOLDER": "folder of NEMOH's results",
    "FOLDER": "folder to write the files into", "NAME": "name of the files without ending",
    "DATABASE.nc": "hydro database to write",
    "FILE.h5": "file written by BEMIO", "RESULTS": "folder of finished results of a study",
}  # fmt: skip
"""What positional arguments are, by their names."""
AXISYMMETRIC = "the body and its generalized modes are axisymmetric, which allows more checks"


def begin(args: argparse.Namespace) -> int:
    """Write a commented study or design, named after its file, to change and run; nothing is overwritten."""
    if sum(map(bool, (args.radius is not None, args.body, args.campaign, args.design))) > 1:
        args.command.error("--radius, --body, --campaign and --design: received several, needs at most one of them")
    if args.campaign:
        print(f"{init_campaign(args.config, args.campaign)}: a site's seas, to be replaced by yours")
    elif args.body:
        init_body(args.config)
    elif args.design:
        print(f"{init_design(args.config)}: the study it varies, to be changed too")
    else:
        init(args.config, args.radius)
    print(f"{args.config}: change it, then vsb check {args.config} and vsb run {args.config}")
    return 0


def check(args: argparse.Namespace) -> int:
    """Validate a study, campaign or design problem without running it; print its CPU time, checks and warnings.

    The exit code is 1 if a check fails.
    """
    plan = plan_of(args.config, args.results)
    check_name(plan)
    lines = summary(plan)
    print(*lines, sep="\n")
    return int(any(line.startswith("fail ") for line in lines))


def schema(args: argparse.Namespace) -> int:
    """Print the JSON schema of study, body, campaign or design files, for editors to complete and check them."""
    from vsb.engine.hydro.bodies.body_file import BodyFile
    from vsb.keys.schema import schema_of
    from vsb.study.body import BodyStudy
    from vsb.study.campaign import Campaign
    from vsb.study.design import Optimisation

    models: dict[str, type[Section]] = {"study": BuoyStudy, "campaign": Campaign, "design": Optimisation}
    models |= {"body-study": BodyStudy, "body": BodyFile}
    print(json.dumps(schema_of(models[args.kind]), indent=1, allow_nan=False))
    return 0


def verify(args: argparse.Namespace) -> int:
    """Check that the result files of a study, or of a folder, are undamaged and belong to their study file."""
    from vsb.stages import verify as stamps

    print(*stamps.verify(args.config), sep="\n")
    return 0


def shell(args: argparse.Namespace) -> int:
    """Print natural frequencies of the shell in vacuum and its buckling pressure.

    Modes are those of membrane theory (both branches) and with bending, beside the values of the paper's Ritz method.
    """
    from vsb.stages import preview

    table = preview.shell_table(StudyPlan(load(args.config)).with_degree().study)
    print(json.dumps(table, indent=1) if args.json else preview.shell_text(table))
    return 0


def export(args: argparse.Namespace) -> int:
    """Write the hydro database of a study, or a database file, for other codes: WAMIT's files and WEC-Sim's .h5."""
    from vsb.engine.hydro.formats.exchange import exported

    if (path := Path(args.config)).suffix == ".nc":
        print(*exported(path, args.folder, path.stem, inputs=[path]), sep="\n")
        return 0
    plan = plan_of(args.config, args.results)
    if isinstance(plan, CampaignPlan | DesignPlan):
        raise ConfigError(f"{args.config}: received a {plan.KIND}, needs a study, or one database file")
    stored = Path(plan.database.out)
    inputs = [*_inputs(args), stored]
    print(*exported(stored, args.folder, plan.name, stored.stem, inputs), sep="\n")
    return 0


def series(args: argparse.Namespace) -> int:
    """Write the time series of a run, motion, forces and power, as CSV or netCDF, with WEC-Sim's variable names."""
    from vsb.api.results import Results
    from vsb.api.results import open as opened
    from vsb.results.comparison import series_csv
    from vsb.tools.files import atomic_write, attributes, write_text

    path, out = Path(args.config), Path(args.out)
    if out.suffix not in (".csv", ".nc"):
        raise ConfigError(f"{out}: received a name without .csv or .nc, needs one of them")
    run, results = attributes(path), opened(path.absolute().parent.parent)
    if not isinstance(results, Results) or not {"design", "wave"} <= set(run):
        raise ConfigError(f"{path}: is no run of a study, needs a file of results/STUDY/trajectories")
    found = results.series(str(run["design"]), str(run["wave"]))
    if out.suffix == ".csv":
        write_text(out, series_csv(found))
    else:
        with atomic_write(out) as temporary:
            found.to_netcdf(temporary, engine="netcdf4")
    left_out = f"; left out, without a name of WEC-Sim's: {found.left_out}" if found.left_out else ""
    print(f"{out}: {found.sizes['time']} instants of {len(found.data_vars)} variables{left_out}")
    return 0


def import_wamit(args: argparse.Namespace) -> int:
    """Read WAMIT's output, including generalized modes, into a hydro database and print its checks."""
    from vsb.stages import coefficients

    names = (*coefficients.FACTS, "axisymmetric", "bodies", "modes")
    found = coefficients.import_wamit(args.folder, args.name, args.out, **{name: getattr(args, name) for name in names})
    return _imported(*found, args.out)


def import_bemio(args: argparse.Namespace) -> int:
    """Read a BEMIO .h5 file into a hydro database and print its checks."""
    from vsb.stages import coefficients

    return _imported(*coefficients.import_bemio(args.file, args.out, axisymmetric=args.axisymmetric), args.out)


def import_nemoh(args: argparse.Namespace) -> int:
    """Read a folder of NEMOH's results into a hydro database and print its checks."""
    from vsb.stages import coefficients

    return _imported(*coefficients.import_nemoh(args.folder, args.out, axisymmetric=args.axisymmetric), args.out)


def _imported(checks: "list[Check]", notes: list[str], causes: list[str], out: str) -> int:
    """Print the verdict on numbers of others, and what to look at where a check does not hold."""
    code = print_verdict(checks, "\n".join([*notes, out]))
    for line in causes:
        print(f"look at {line}")
    return code


def body(args: argparse.Namespace) -> int:
    """Compute the hydrodynamic coefficients of any mesh and mode shapes and print their checks.

    The exit code is 1 if a check fails.
    """
    from vsb.engine.hydro.bodies.solution import read_study
    from vsb.stages.coefficients import solve_body

    study, read = read_study(args.config, args.out)
    notes = [f"note: {note}" for note in read.history.split("; ") if note]
    return print_verdict(
        solve_body(study, read, args.config, args.out), "\n".join([*notes, f"{args.out}: blocks and database"])
    )


def print_verdict(checks: "list[Check]", files: str) -> int:
    """Print a verdict and what was written; 1 if a check fails."""
    print(*(check.line for check in checks), files, sep="\n")
    return int(any(check.verdict == "fail" for check in checks))


def matrix(args: argparse.Namespace) -> int:
    """Print the power matrix of a finished study: mean power of each design in JONSWAP seas over Hs and Te.

    Powers are those of linear theory. With --out capture widths and dampers are written to a file, too.
    """
    from vsb.api.results import Results
    from vsb.api.results import open as opened
    from vsb.report.answer import limits_aside
    from vsb.tools.files import write_text
    from vsb.tools.stamps import check_table
    from vsb.tools.words import csv_text

    results, head = opened(args.folder), ("design", "hs", "te", "power", "capture_width", "damping")
    if not isinstance(results, Results):
        raise ConfigError(f"{args.folder}: needs the results of a study; a campaign has its own matrices")
    if args.out:
        check_table(args.out, head)
    found = results.power_matrix(tunings=[args.tuning], gamma=args.gamma).sel(tuning=args.tuning)
    for design in map(str, found.design.values):
        table = (found.power_matrix.sel(design=design) / 1e3).to_pandas().map("{:.3g}".format)
        print(f"{design}: mean power [kW] over Hs [m], down, and Te [s], across", table.to_string(), sep="\n")
    aside = limits_aside(results.study.pto.model_dump())
    print(f"by linear theory{aside}: not valid of steep seas, Hs above 0.05 wavelengths, and of heave above 0.3 radii")
    if args.out:
        rows = found.drop_vars("tuning").to_dataframe().reset_index()
        write_text(args.out, csv_text(head, rows[["design", "hs", "te", *found.data_vars]].to_numpy().tolist(), 9))
    return 0


def figures(args: argparse.Namespace) -> int:
    """Draw the figures of finished results for print, as PDF or PNG, beside those of the page or into a folder."""
    from vsb.stages.printing import print_figures

    plan = plan_of(args.config, args.results)
    folder = args.out or f"{plan.folder}/figures"
    print(*print_figures(plan, folder, args.kinds or ["pdf"]), sep="\n")
    return 0


def shape_dependence(args: argparse.Namespace) -> int:
    """Compute how hydrodynamic coefficients change as the shell deforms, and by how much that changes power.

    Writes a netCDF file and a figure.
    """
    from vsb.stages import shape_dependence as stage

    answer = stage.shape_dependence(
        StudyPlan(load(args.config)).with_degree().study, f"{args.out}.nc", f"{args.out}.svg"
    )
    print(f"{args.out}.nc {args.out}.svg\n{answer}")
    return 0


def compare(args: argparse.Namespace) -> int:
    """Compare finished studies and campaigns: power, gain at equal tuning, dampers, capture width, energy."""
    from vsb.stages import side_by_side

    kind = "page" if args.out and Path(args.out).suffix == ".html" else "table of studies"
    _check_outputs(args, {args.out: kind} if args.out else {})
    print(side_by_side.compare(args.studies, args.out, args.results))
    return 0


def rule(args: argparse.Namespace) -> int:
    """Run one job of the workflow; its tasks are read as JSON from standard input."""
    if sys.stdin.isatty():
        raise ConfigError("standard input: received a terminal, needs the tasks of the rule as JSON")
    run_job(args.rule, sys.stdin.read())
    return 0


def count(text: str) -> int:
    """Return a whole number from 1 in an argument; argparse's error if it is none."""
    if not (text.isdecimal() and 1 <= int(text) <= 1000):
        raise argparse.ArgumentTypeError(f"received {text!r}, needs a whole number from 1")
    return int(text)


def counts(text: str) -> list[int]:
    """Return whole numbers with commas between them."""
    return [count(word) for word in text.split(",")]


class Parser(argparse.ArgumentParser):
    """A parser that reports an error in one line."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong with the arguments, and what was probably meant; exit with 2."""
        text = " ".join(message.split())
        choice = re.search(r"^argument (\S+): invalid choice: '(.*)' \(choose from (.*)\)$", text)
        if choice and (near := nearest(choice[2], re.findall("'(.*?)'", choice[3]))):
            text = f"{choice[1]}: received {choice[2]}, did you mean {near}?"
        self.exit(2, f"{ERROR} {text}; see {self.prog} --help\n")


def parser() -> argparse.ArgumentParser:
    """Return the argument parser of the command line."""
    top = Parser(prog="vsb", description="Does a flexible wave-energy buoy absorb more than a rigid one?", epilog=FIRST)
    top.formatter_class = argparse.RawDescriptionHelpFormatter
    top.set_defaults(writes={})
    top.add_argument("--version", action="version", version=f"vsb {__version__}")
    commands = top.add_subparsers(title="commands", required=True, metavar="COMMAND")
    _add_commands(commands)
    _add_imports(commands)
    _add_compared(commands)
    text = "run one job of the workflow, for Snakemake"
    one = _command(commands, "stage", text, rule)
    one.formatter_class = argparse.RawDescriptionHelpFormatter
    one.epilog = "rules:\n" + "\n".join(f"  {name:20} {words}" for name, words in RULES.items())
    one.add_argument("rule", metavar="RULE", choices=list(RULES), help="rule of the job, see below")
    return top


def _command(commands: Any, name: str, text: str, handler: Handler, /, **places: str) -> argparse.ArgumentParser:
    """Declare a command with its positional arguments and how these are called in its help, which has an example."""
    one: argparse.ArgumentParser = commands.add_parser(name, help=text, description=handler.__doc__)
    if example := EXAMPLES.get(name):
        one.epilog = f"example: vsb {name} {example}"
    for place, metavar in places.items():
        one.add_argument(place, metavar=metavar, help=ARGUMENTS.get(f"{name} {metavar}", ARGUMENTS[metavar]))
    one.set_defaults(handler=handler, command=one)
    return one


def _in_results(one: argparse.ArgumentParser) -> None:
    """Let the folder of all results be named."""
    one.add_argument("--results", metavar="FOLDER", default="results", help="folder of all results (default: results)")


def _running(one: argparse.ArgumentParser) -> None:
    """Declare the options of a run."""
    _in_results(one)
    one.add_argument("--profile", help="Snakemake profile: default, slurm, or the path of a folder")
    one.add_argument("--cores", "-c", type=cores, metavar="N", help="number of processor cores, or all")
    one.add_argument("--quiet", "-q", action="store_true", help="print only the answer")
    one.add_argument("--verbose", action="store_true", help="show Snakemake's output")


def _add_commands(commands: Any) -> None:
    """Declare what is done with a study or a body."""
    one = _command(commands, "init", "write a study to begin with", begin, config="STUDY.yaml")
    words = "radius of the buoy [m]; all other values are scaled with it by Froude's law"
    one.add_argument("--radius", type=float, metavar="R", help=words)
    one.add_argument("--body", action="store_true", help="write a study of a body, with a simple hull to be replaced")
    one.add_argument("--campaign", metavar="STUDY.yaml", help="write a campaign: that study over a site's year")
    one.add_argument("--design", action="store_true", help="write a design problem, and the study it varies")
    one = _command(commands, "run", "run a whole study, campaign or design", run, config="CONFIG")
    one.epilog = (
        f"{one.epilog}. Runs of up to ten CPU-minutes do without Snakemake, unless --profile, --cores, --verbose or "
        "one of Snakemake's own options, such as -n, is given."
    )
    _running(one)
    words = "find the best buoy within limits; the same as run, for design files"
    _running(_command(commands, "design", words, run, config="DESIGN"))
    words = "validate a study, campaign or design without running it"
    _in_results(_command(commands, "check", words, check, config="CONFIG"))
    one = _command(commands, "schema", "JSON schema of study files, for editors", schema)
    kinds = ("study", "body-study", "body", "campaign", "design")
    one.add_argument("kind", nargs="?", choices=kinds, default="study", help="kind of file")
    one = _command(commands, "matrix", "power matrix of a study over Hs and Te", matrix, folder="RESULTS")
    words = "damper: optimal in each sea (each, the default), one for all seas, or as given (fixed)"
    one.add_argument("--tuning", choices=("each", "one", "fixed"), default="each", help=words)
    one.add_argument("--gamma", type=float, default=3.3, help="peakedness of the spectra (default: 3.3)")
    one.add_argument("--out", metavar="FILE.csv", help="write power, capture width and damping of every sea")
    _command(commands, "verify", "check that result files are undamaged and up to date", verify, config="CONFIG|FOLDER")
    one = _command(commands, "shell", "natural frequencies and buckling pressure of a shell", shell, config="CONFIG")
    one.add_argument("--json", action="store_true", help="print JSON")
    words = "change of the coefficients as the shell deforms"
    one = _command(commands, "shape-dependence", words, shape_dependence, config="CONFIG", out="OUT")
    one.set_defaults(writes={"{out}.nc": "shape dependence", "{out}.svg": "figure"})
    words = "hydrodynamic coefficients of any mesh and mode shapes"
    one = _command(commands, "body", words, body, config="CONFIG", out="FOLDER")
    one.set_defaults(writes={"{out}/": ""})


def _add_compared(commands: Any) -> None:
    """Declare what is made of finished results."""
    one = _command(commands, "compare", "compare finished studies and campaigns", compare)
    one.add_argument("studies", nargs="+", metavar="CONFIG", help="files of studies or campaigns")
    _in_results(one)
    one.add_argument("--out", metavar="FILE", help="write the whole table to FILE.csv, or a page to FILE.html")
    words = "draw figures of finished results as PDF or PNG"
    one = _command(commands, "figures", words, figures, config="CONFIG")
    _in_results(one)
    for kind in ("pdf", "png"):
        words = f"write {kind.upper()}{' (default)' if kind == 'pdf' else ''}"
        one.add_argument(f"--{kind}", action="append_const", dest="kinds", const=kind, help=words)
    one.add_argument("--out", metavar="FOLDER", help="folder of the files (default: figures/ of the results)")


def _add_imports(commands: Any) -> None:
    """Declare what exchanges databases with other codes."""
    words = "write a hydro database as WAMIT files and WEC-Sim .h5"
    one = _command(commands, "export", words, export, config="CONFIG|DATABASE.nc", folder="FOLDER")
    _in_results(one)
    one.set_defaults(writes={"{folder}/": ""})
    words = "write the time series of a run with WEC-Sim's names"
    one = _command(commands, "series", words, series, config="TRAJECTORY.nc", out="OUT.csv|OUT.nc")
    one.set_defaults(writes={"{out}": "time series"})
    words, into = "read WAMIT's output into a hydro database", {"out": "DATABASE.nc"}
    places = {"folder": "FOLDER", "name": "NAME", **into}
    one = _command(commands, "import-wamit", words, import_wamit, **places)
    one.add_argument("--density", type=float, default=1025.0, help="density of the water [kg/m^3] (default: 1025)")
    one.add_argument("--gravity", type=float, default=9.81, help="gravity, GRAV of WAMIT [m/s^2] (default: 9.81)")
    one.add_argument("--length", type=float, default=1.0, help="length scale, ULEN of WAMIT [m] (default: 1)")
    one.add_argument("--depth", type=float, default=float("inf"), help="depth, HBOT of WAMIT [m] (default: deep water)")
    one.add_argument("--bodies", type=count, metavar="N", help="number of bodies, if no .mmx file states it")
    text = "number of modes of each body, six and its generalized ones, such as 7,6"
    one.add_argument("--modes", type=counts, metavar="N,N", help=text)
    one.set_defaults(writes={"{out}": "hydro database"})
    one.add_argument("--axisymmetric", action="store_true", help=AXISYMMETRIC)
    words = "read BEMIO's .h5 into a hydro database"
    one = _command(commands, "import-bemio", words, import_bemio, file="FILE.h5", **into)
    one.add_argument("--axisymmetric", action="store_true", help=AXISYMMETRIC)
    one.set_defaults(writes={"{out}": "hydro database"})
    words = "read NEMOH's results into a hydro database"
    one = _command(commands, "import-nemoh", words, import_nemoh, folder="FOLDER", **into)
    one.add_argument("--axisymmetric", action="store_true", help=AXISYMMETRIC)
    one.set_defaults(writes={"{out}": "hydro database"})


def _check_outputs(args: argparse.Namespace, kinds: Mapping[str, str]) -> None:
    """Check that files, by name and kind, and folders, whose names end in /, can be written and nothing is lost."""
    for name, kind in kinds.items():
        from vsb.tools.files import check_folder
        from vsb.tools.stamps import check_output

        if name.endswith("/"):
            check_folder(name.removesuffix("/"))
        else:
            check_output(name, _inputs(args), kind)


def _inputs(args: argparse.Namespace) -> set[Path]:
    """Files a command reads: those on the command line, and those they name."""
    given = {"config": "", "file": "", **vars(args)}
    found: set[Path] = set()
    waiting = [Path(name) for name in (given["config"], given["file"], *given.get("studies", ())) if name]
    if "name" in given and "folder" in given:  # of WAMIT
        waiting += Path(given["folder"]).glob(f"{given['name']}.*")
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _named_in(path)
    return found


def _named_in(path: Path) -> list[Path]:
    """Files that exist and are named in a study, body or campaign file."""
    if path.suffix not in (".yaml", ".yml"):
        return []
    from vsb.engine.hydro.bodies.body_file import WAMIT
    from vsb.keys.quantities import leaves
    from vsb.keys.reading import read_yaml

    try:
        values = leaves(read_yaml(path, "a study file")).items()
    except ConfigError:  # which the command itself reports
        return []
    texts = [(key, value) for key, value in values if isinstance(value, str)]
    names = [value + ending for key, value in texts for ending in ("", *(WAMIT if key.endswith("wamit") else ()))]
    return [path.parent / name for name in names if os.path.isfile(path.parent / name)]


def _mistake(text: str, config: str | None = None) -> int:
    """Say in one line what is the user's to mend, in which study file if `config` is not named yet; return 2."""
    named = text if config is None or text.startswith(f"{config}:") else f"{config}: {text}"
    print(f"{ERROR} {' '.join(named.split())}", file=sys.stderr)
    return 2


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; a user's mistake is one line on stderr and exit code 2."""
    line = parser()
    if "_ARGCOMPLETE" in os.environ:  # a shell asks what may follow, and it ends here
        import argcomplete

        argcomplete.autocomplete(line)
    return answer(line, argv)


def answer(line: argparse.ArgumentParser, argv: Sequence[str] | None) -> int:
    """Run the command of a parser, whose `handler` gets the arguments; a user's mistake is one line and exit code 2.

    `writes` of a command names the files and their kinds, and the folders, whose names end in /, that it must be able
    to write.
    """
    args, rest = line.parse_known_args(argv)
    handler: Handler = args.handler
    if rest and handler is not run:
        near = nearest(rest[0], long_options(vars(args).get("command", line)))
        line.error(f"unrecognized arguments: {' '.join(rest)}" + (f"; did you mean {near}?" if near else ""))
    args.snakemake = rest
    try:
        _check_outputs(args, {name.format(**vars(args)): kind for name, kind in args.writes.items()})
        code = handler(args)
        sys.stdout.flush()
        return code
    except BrokenPipeError:  # of `| head`: nobody reads on
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except ConfigError as error:
        return max(_mistake(text, vars(args).get("config")) for text in error.mistakes)
    except VsbError as error:
        return _mistake(str(error))
    except OSError as error:
        if error.filename is None:  # of no file: not the user's
            raise
        reason = f"{error.filename2 or error.filename}: cannot be read or written ({error.strerror})"
        return _mistake(f"{reason}; needs a path you may use")
    except KeyboardInterrupt:
        print(INTERRUPTED, file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())

"""documentation/index.html: purpose, variables and use of the FMU."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from fmu_packaging.description import Identity
from fmu_packaging.variables import Variable

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
       color: #1c2733; background: #fff; }
h1 { margin-bottom: 0; } h2 { margin-top: 2.2rem; border-bottom: 1px solid #d5dde5; }
.lead { color: #4a5b6c; margin-top: .2rem; }
table { border-collapse: collapse; width: 100%; font-size: .9rem; }
th, td { text-align: left; vertical-align: top; padding: .3rem .6rem;
         border-bottom: 1px solid #e4e9ee; }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
code, pre { background: #f3f6f9; border-radius: 3px; } pre { padding: .8rem; overflow-x: auto; }
"""

STEPS = """
<p>Co-simulation, FMI {fmi}, any communication step above zero. Outputs change only in a step: with
inputs <i>u</i> held from <i>t</i> to <i>t + h</i>, the outputs read afterwards are those at
<i>t + h</i>. State can be saved, restored and serialised, and a restored FMU continues bit for bit.
An error inside a step is logged with its cause and the step is discarded.</p>
"""

PYTHON_HOST = """
<p>The FMU runs in Python 3.11 or newer, which the host provides{needs}. Binaries: linux64 and
win64. A host that is not a Python program must have the Python library loaded first (on Linux:
<code>LD_PRELOAD=libpython3.11.so</code>). Switch logging on in the host to see the FMU's messages;
errors also go to standard error. The binary is pythonfmu's and hard on its host: a wrong reference
is fatal, and a null pointer, or an extraction path with characters that a URI writes as a percent
code (ü, #, +; spaces are fine), ends it. For any host that is not a Python program take the form in
C99, which refuses these: <code>python build_fmu.py --native</code>.</p>
"""

PYTHON_LICENCE = (
    "The binaries and the base class come from pythonfmu, <a href='licenses/pythonfmu.txt'>MIT</a>."
)


@dataclass(frozen=True)
class Page:
    """The parts of the page specific to one FMU, as HTML: a line, and sections with titles."""

    lead: str
    body: str


@dataclass(frozen=True)
class Running:
    """Requirements of a host and licences of the contents, as HTML; the FMI version."""

    host: str
    licence: str
    fmi: str = "2.0"


def in_python(needs: Sequence[str]) -> Running:
    """Return this for a Python FMU; *needs* are packages that the host's Python must have."""
    needed = f", with {' and '.join(needs)} installed" if needs else " (standard library only)"
    return Running(PYTHON_HOST.format(needs=escape(needed)), PYTHON_LICENCE)


def index_page(
    page: Page, identity: Identity, variables: Sequence[Variable], running: Running
) -> str:
    """Return the whole page.

    Parameters
    ----------
    page : Page
    identity : Identity
    variables : sequence of Variable
    running : Running
    """
    parts = [page.body]
    for causality, title in (
        ("input", "Inputs"),
        ("output", "Outputs"),
        ("parameter", "Parameters"),
    ):
        chosen = [variable for variable in variables if variable.causality == causality]
        if chosen:
            parts.append(f"<h2>{title}</h2>\n{_table(chosen)}")
    steps = STEPS.format(fmi=running.fmi)
    parts.append(f"<h2>Running it</h2>\n{steps}{running.host}")
    parts.append(
        "<h2>Licence</h2>\n<p>MIT; see <a href='licenses/license.txt'>licence</a>. "
        f"{running.licence}</p>"
    )
    return (
        "<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>\n"
        f"<title>{escape(identity.title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f"<h1>{escape(identity.title)}</h1>\n<p class='lead'>{page.lead}</p>\n"
        + "\n".join(parts)
        + f"\n<p class='lead'>spindle-drift {escape(identity.version)}</p>\n</body>\n</html>\n"
    )


def _table(variables: Sequence[Variable]) -> str:
    rows = "".join(
        f"<tr><td><code>{escape(variable.name)}</code></td><td>{variable.kind}</td>"
        f"<td>{escape(variable.unit) if variable.kind == 'real' else ''}</td>"
        f"<td class='n'>{_range(variable)}</td><td class='n'>{_start(variable)}</td>"
        f"<td>{escape(variable.description)}</td></tr>\n"
        for variable in variables
    )
    head = "".join(f"<th>{cell}</th>" for cell in ("Name", "Type", "Unit", "Range", "Start", ""))
    return f"<table>\n<tr>{head}</tr>\n{rows}</table>"


def _range(variable: Variable) -> str:
    if variable.low is None and variable.high is None:
        return ""
    low = "-∞" if variable.low is None else f"{variable.low:g}"
    high = "∞" if variable.high is None else f"{variable.high:g}"
    return f"{low} … {high}"


def _start(variable: Variable) -> str:
    if variable.is_output or variable.start is None:
        return ""
    return escape(
        f"{variable.start:g}" if isinstance(variable.start, float) else str(variable.start)
    )

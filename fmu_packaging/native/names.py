"""Prefixed and hidden names, so that sources of several FMUs can be linked into one program.

The standard's macro ``FMI2_FUNCTION_PREFIX`` (``FMI3_FUNCTION_PREFIX``) gives the FMI functions of
an FMU unique names; here it applies to everything that the sources define. A shared library exports
only the FMI functions, whatever its compiler's flags: FMI's header exports them, the rest is
declared hidden. System headers come before that, because their functions are defined elsewhere.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

HEADER = "names.h"
SYSTEM = re.compile(r"^#include <[\w./]+>$", re.M)
HIDDEN = """\
#if defined(__GNUC__) && !defined(_WIN32)
#pragma GCC visibility push(hidden)
#endif
"""
DEFINED = (
    # A function: its head begins a line, followed by its parameters.
    re.compile(r"^(?!static|typedef|extern|#|return|else)[a-zA-Z_][\w \*]*?[ \*](\w+)\(", re.M),
    # A constant with a value.
    re.compile(r"^const [\w \*]*?[ \*](\w+)(?:\[[^\]]*\])? =", re.M),
)


def with_prefix(sources: Mapping[str, str], fmi: int) -> dict[str, str]:
    """Return C sources, by path, with the prefix and the header that applies it."""
    code = {path: text for path, text in sources.items() if path.endswith(".c")}
    defined = {name for text in code.values() for rule in DEFINED for name in rule.findall(text)}
    # FMI's own header applies it to FMI's functions.
    names = sorted(name for name in defined if not name.startswith("fmi"))
    system = sorted({line for text in sources.values() for line in SYSTEM.findall(text)})
    prefix = f"FMI{fmi}_FUNCTION_PREFIX"
    header = [
        f"/* With {prefix}, all that these sources define has that prefix:",
        "   several FMUs can then be linked into one program. */",
        "#ifndef NAMES_H",
        "#define NAMES_H",
        "",
        f"#ifdef {prefix}",
        "#define NAMES_JOINED(a, b) a##b",
        "#define NAMES_JOIN(a, b) NAMES_JOINED(a, b)",
        *(f"#define {name} NAMES_JOIN({prefix}, {name})" for name in names),
        "#endif",
        "",
        *system,
        "",
        HIDDEN,
        "#endif",
        "",
    ]
    changed = {
        path: f'#include "{"../" * path.count("/")}{HEADER}"\n{text}' for path, text in code.items()
    }
    return {**sources, **changed, HEADER: "\n".join(header)}

"""Names that let several FMUs' sources be linked into one program, and that stay inside a library.

The standard's macro ``FMI2_FUNCTION_PREFIX`` (``FMI3_FUNCTION_PREFIX``) gives the FMI functions of
an FMU names of their own; here it gives them to all that the sources define. A shared library
shows the FMI functions only, whatever its compiler's flags: FMI's header shows them, the rest is
declared hidden. System headers come before that, for what they declare is elsewhere.
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
    # A function: its head begins a line, and its body or its next line's parameters follow.
    re.compile(r"^(?!static|typedef|extern|#|return|else)[a-zA-Z_][\w \*]*?[ \*](\w+)\(", re.M),
    # A constant with a value.
    re.compile(r"^const [\w \*]*?[ \*](\w+)(?:\[[^\]]*\])? =", re.M),
)


def with_prefix(sources: Mapping[str, str], fmi: int) -> dict[str, str]:
    """Return C sources, by path, that take the prefix, the header that does it included."""
    code = {path: text for path, text in sources.items() if path.endswith(".c")}
    found = {name for text in code.values() for rule in DEFINED for name in rule.findall(text)}
    # FMI's own header does it for FMI's functions.
    names = sorted(name for name in found if not name.startswith("fmi"))
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

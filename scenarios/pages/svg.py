"""Builds the parts of an SVG picture; all texts are escaped."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

INK = "#222830"


def mixed(share: float, none: str, full: str) -> str:
    """Return a mix of two colours as ``#rrggbb``; *share* is that of the second."""
    pairs = zip(bytes.fromhex(none[1:]), bytes.fromhex(full[1:]), strict=True)
    return f"#{bytes(round(a + share * (b - a)) for a, b in pairs).hex()}"


def part(kind: str, text: str = "", title: str = "", /, **looks: object) -> str:
    """Return an element.

    Parameters
    ----------
    kind, text : str
        Its name and its text.
    title : str
        Tooltip.
    **looks
        Its attributes, ``stroke_width`` for ``stroke-width``; floats are rounded to a tenth, and
        empty attributes are left out.
    """
    given = {name.replace("_", "-"): look for name, look in looks.items() if look != ""}
    words = "".join(
        f' {name}="{f"{look:.1f}" if isinstance(look, float) else escape(str(look))}"'
        for name, look in given.items()
    )
    named = f"<title>{escape(title)}</title>" if title else ""
    return f"<{kind}{words}>{named}{escape(text)}</{kind}>"


def label(x: float, y: float, text: str, /, **looks: object) -> str:
    """Return text centred on a point [px] that stands out from its background."""
    usual: dict[str, object] = {"fill": INK, "font_size": 11, "text_anchor": "middle"}
    usual |= {"stroke": "#ffffff", "stroke_width": 3, "paint_order": "stroke"}
    return part("text", text, x=x, y=y, **usual | looks)


def picture(
    width: float, height: float, name: str, parts: Iterable[str], /, **looks: object
) -> str:
    """Return the picture of some parts; *name* is its accessible label."""
    usual: dict[str, object] = {"font_family": "system-ui, sans-serif"}
    box = part(
        "svg", viewBox=f"0 0 {width:.0f} {height:.0f}", role="img", aria_label=name, **usual | looks
    )
    return box.replace("></svg>", f">{''.join(parts)}</svg>")

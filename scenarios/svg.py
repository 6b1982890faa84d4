"""Parts of a picture in SVG; all texts are escaped."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

INK = "#222830"


def mixed(share: float, none: str, full: str) -> str:
    """Return a colour between two, as ``#rrggbb``; *share* of it is the second."""
    pairs = zip(bytes.fromhex(none[1:]), bytes.fromhex(full[1:]), strict=True)
    return f"#{bytes(round(a + share * (b - a)) for a, b in pairs).hex()}"


def part(kind: str, text: str = "", title: str = "", /, **looks: object) -> str:
    """Return an element.

    Parameters
    ----------
    kind, text : str
        Its name, and what stands in it.
    title : str
        Shown under the pointer.
    **looks
        Its attributes, ``stroke_width`` for ``stroke-width``; floats are given to a tenth, and
        those that are empty are left out.
    """
    given = {name.replace("_", "-"): look for name, look in looks.items() if look != ""}
    words = "".join(
        f' {name}="{f"{look:.1f}" if isinstance(look, float) else escape(str(look))}"'
        for name, look in given.items()
    )
    named = f"<title>{escape(title)}</title>" if title else ""
    return f"<{kind}{words}>{named}{escape(text)}</{kind}>"


def label(x: float, y: float, text: str, /, **looks: object) -> str:
    """Return words in the middle of a place [px] that stand out from what is behind them."""
    usual: dict[str, object] = {"fill": INK, "font_size": 11, "text_anchor": "middle"}
    usual |= {"stroke": "#ffffff", "stroke_width": 3, "paint_order": "stroke"}
    return part("text", text, x=x, y=y, **usual | looks)


def picture(
    width: float, height: float, name: str, parts: Iterable[str], /, **looks: object
) -> str:
    """Return the picture of some parts; *name* is what it is called where it cannot be seen."""
    usual: dict[str, object] = {"font_family": "system-ui, sans-serif"}
    box = part(
        "svg", viewBox=f"0 0 {width:.0f} {height:.0f}", role="img", aria_label=name, **usual | looks
    )
    return box.replace("></svg>", f">{''.join(parts)}</svg>")

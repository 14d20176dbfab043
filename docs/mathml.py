"""Equations as MathML, made with the pages: browsers show them by themselves, without script or network."""

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

_STYLE = "margin: 1em 0; overflow-x: auto; overflow-y: hidden"
"""A formula that is wider than the page is scrolled by itself."""


def _inline(writer, node: nodes.math) -> None:
    writer.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _block(writer, node: nodes.math_block) -> None:
    writer.body.append(writer.starttag(node, "div", CLASS="formula", STYLE=_STYLE))
    if node.get("number"):
        writer.body.append(f'<span class="eqno">({node["number"]})</span>')
    writer.body.append(convert(node.astext(), display="block"))
    writer.body.append("</div>")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.config.html_math_renderer = "mathml"
    return {"parallel_read_safe": True, "parallel_write_safe": True}

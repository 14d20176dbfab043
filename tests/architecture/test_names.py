"""Public classes have names of their own in a subpackage; the field's terms stand where they are looked for."""

import ast
from collections import defaultdict

import pytest
from source_files import FILES, SOURCE, tree

TERMS = {
    "contact history": "mechanics/friction.py",
    "return mapping": "mechanics/friction.py",
    "contact stabilisation": "fea/monitor.py",
    "predictor": "mechanics/continuation.py",
    "limit point": "mechanics/continuation.py",
    "snap-through": "mechanics/continuation.py",
    "domain randomisation": "datasets/randomise.py",
    "conformal": "learn/interval.py",
    "assignment": "vision/assign_markers.py",
    "out of distribution": "learn/interval.py",
    "reprojection residual": "vision/register.py",
}


def test_names_are_unique_in_a_subpackage() -> None:
    homes = defaultdict(list)
    for path in (path for path in FILES if path.is_relative_to(SOURCE)):
        for node in tree(path).body:
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                place = path.relative_to(SOURCE)
                homes[f"{place.parts[0]}.{node.name}"].append(str(place))
    assert {name: places for name, places in homes.items() if len(places) > 1} == {}


@pytest.mark.parametrize(("term", "place"), TERMS.items())
def test_the_fields_term_stands_in_the_head_of_what_does_it(term: str, place: str) -> None:
    head = ast.get_docstring(tree(SOURCE / place)) or ""
    assert term in " ".join(head.lower().split())

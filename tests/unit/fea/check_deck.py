"""Read a deck as its program would: are all keywords known, and is everything that is used defined?"""

from collections.abc import Iterator
from dataclasses import dataclass, field

COMMON = {
    "HEADING",
    "NODE",
    "ELEMENT",
    "NSET",
    "ELSET",
    "SURFACE",
    "MATERIAL",
    "HYPERELASTIC",
    "SOLID SECTION",
    "SURFACE INTERACTION",
    "SURFACE BEHAVIOR",
    "FRICTION",
    "CONTACT PAIR",
    "BOUNDARY",
    "TIME POINTS",
    "STEP",
    "STATIC",
    "END STEP",
}
KEYWORDS = {
    "calculix": COMMON | {"ELASTIC", "NODE PRINT", "EL PRINT", "NODE FILE", "EL FILE"},
    "abaqus": COMMON
    | {
        "SHELL SECTION",
        "RIGID BODY",
        "OUTPUT",
        "NODE OUTPUT",
        "ELEMENT OUTPUT",
        "CONTACT OUTPUT",
        "ENERGY OUTPUT",
    },
}
NODES_OF = {"C3D20R": 20, "C3D20RH": 20, "S4R": 4, "C3D8": 8, "R3D4": 4}
FACES = {"S1", "S2", "S3", "S4", "S5", "S6", "SPOS", "SNEG"}


@dataclass
class Card:
    """A keyword, its parameters and its data lines."""

    keyword: str
    parameters: dict[str, str]
    data: list[list[str]]


@dataclass
class Deck:
    """Names and numbers that a deck defines."""

    nodes: dict[int, tuple[float, float, float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)
    names: dict[str, set[str]] = field(default_factory=dict)
    sets: dict[str, list[int]] = field(default_factory=dict)


def cards(text: str) -> Iterator[Card]:
    card: Card | None = None
    pending: list[str] = []
    for line in text.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            if card is not None:
                yield card
            keyword, *parameters = [word.strip() for word in line[1:].split(",")]
            pairs = (word.partition("=") for word in parameters)
            card = Card(keyword, {key.strip(): value.strip() for key, _, value in pairs}, [])
        elif card is not None:
            pending += [word.strip() for word in line.split(",") if word.strip()]
            if not line.rstrip().endswith(","):
                card.data.append(pending)
                pending = []
    if card is not None:
        yield card


def read(text: str) -> Deck:
    deck = Deck(names={kind: set() for kind in ("set", "surface", "material", "interaction", "times")})
    for card in cards(text):
        given = card.parameters
        match card.keyword:
            case "NODE":
                new = {int(row[0]): (float(row[1]), float(row[2]), float(row[3])) for row in card.data}
                assert not deck.nodes.keys() & new.keys(), "a node is defined twice"
                deck.nodes |= new
                deck.sets[given["NSET"]] = [*new]
            case "ELEMENT":
                rows = {int(row[0]): (given["TYPE"], [int(word) for word in row[1:]]) for row in card.data}
                assert not deck.elements.keys() & rows.keys(), "an element is defined twice"
                deck.elements |= rows
                deck.sets[given["ELSET"]] = [*rows]
            case "NSET" | "ELSET":
                deck.sets[given[card.keyword]] = [int(word) for row in card.data for word in row]
            case "SURFACE":
                deck.names["surface"].add(given["NAME"])
            case "MATERIAL":
                deck.names["material"].add(given["NAME"])
            case "SURFACE INTERACTION":
                deck.names["interaction"].add(given["NAME"])
            case "TIME POINTS":
                deck.names["times"].add(given["NAME"])
    deck.names["set"] = {*deck.sets}
    return deck


def faults(text: str, dialect: str) -> list[str]:
    """Everything a program would refuse: unknown keywords, names that are not defined, wrong numbers of nodes."""
    deck = read(text)
    found = [f"line of {len(line)} characters" for line in text.splitlines() if len(line) > 256]
    for card in cards(text):
        if card.keyword not in KEYWORDS[dialect]:
            found.append(f"unknown keyword {card.keyword}")
        found += [f"{card.keyword} uses {kind} {name}" for kind, name in used(card) if name not in deck.names[kind]]
    for number, (kind, nodes) in deck.elements.items():
        if len(nodes) != NODES_OF[kind] or not set(nodes) <= deck.nodes.keys():
            found.append(f"element {number} of {kind} has nodes {nodes}")
    names = [card.keyword for card in cards(text)]
    if names.count("STEP") != names.count("END STEP") or names[-1] != "END STEP":
        found.append("a step is not ended")
    sectioned = [card.parameters["ELSET"] for card in cards(text) if card.keyword in SECTIONS]
    without = deck.elements.keys() - {number for name in sectioned for number in deck.sets.get(name, [])}
    return [*found, *(f"element {number} has no section" for number in sorted(without))]


SECTIONS = {"SOLID SECTION", "SHELL SECTION", "RIGID BODY"}
REFERENCES = {"MATERIAL": "material", "INTERACTION": "interaction", "TIME POINTS": "times", "REF NODE": "set"}


def used(card: Card) -> Iterator[tuple[str, str]]:
    """Kind and name of everything a card refers to."""
    for parameter, kind in REFERENCES.items():
        if parameter in card.parameters and card.keyword != parameter:
            yield kind, card.parameters[parameter]
    for parameter in ("NSET", "ELSET"):
        if parameter in card.parameters:
            yield "set", card.parameters[parameter]
    if card.keyword == "SURFACE":
        for row in card.data:
            yield "set", row[0]
            assert row[1] in FACES
    if card.keyword == "BOUNDARY":
        yield from (("set", row[0]) for row in card.data)
    if card.keyword == "CONTACT PAIR":
        yield from (("surface", name) for row in card.data for name in row)

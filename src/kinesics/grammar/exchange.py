"""The motion graph in other forms: networkx, JSON, GraphML, Mermaid."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar
from xml.sax.saxutils import escape, quoteattr

from kinesics.errors import InputError
from kinesics.grammar import notation
from kinesics.grammar.graph import MotionGraph, Occurrence, Path, Source, State, Stay

if TYPE_CHECKING:
    import networkx as nx

    from kinesics.grammar.information import Information

T = TypeVar("T")

_EMPTY: Final = "no states"
_GRAPHML_TYPES: Final = {bool: "boolean", int: "long", float: "double", str: "string"}


def to_networkx(graph: MotionGraph) -> nx.MultiDiGraph[str]:
    """A directed multigraph: a node a state, by label; an edge a path, with its label as key.

    A reversible path has a second edge the other way, with key ``<label`` and ``backwards`` true. What is not known
    (``mirror_of`` of a state whose image the graph does not have) is left out. ``seconds`` is the time spent.
    """
    import networkx as nx

    out: nx.MultiDiGraph[str] = nx.MultiDiGraph()
    for name, facts in _nodes(graph):
        out.add_node(name, **facts)
    for edge in _edges(graph):
        out.add_edge(edge.from_, edge.to, key=edge.key, **edge.facts)
    return out


class _Edge(NamedTuple):
    from_: str
    to: str
    key: str
    facts: dict[str, Any]


def _nodes(graph: MotionGraph) -> Iterator[tuple[str, dict[str, Any]]]:
    """Each state: its label and what is known of it."""
    names = {s.id: s.label for s in graph.states}
    for state in graph.states:
        facts: dict[str, Any] = {
            "id": state.id,
            "symmetric": state.symmetric,
            "stays": len(state.stays),
            "seconds": _seconds(graph, state.stays),
        }
        if (image := graph.mirror_state(state.id)) is not None:
            facts["mirror_of"] = names[image]
        yield state.label, facts


def _edges(graph: MotionGraph) -> Iterator[_Edge]:
    """Each path, a reversible one in both directions."""
    names = {s.id: s.label for s in graph.states}
    paths = {p.id: p.label for p in graph.paths}
    for path in graph.paths:
        for backwards in (False, True)[: 1 + path.reversible]:
            taken = [o for o in path.occurrences if o.reversed == backwards]
            facts: dict[str, Any] = {
                "id": path.id,
                "label": path.label,
                "index": path.index,
                "symmetric": path.symmetric,
                "reversible": path.reversible,
                "inferred": path.inferred,
                "backwards": backwards,
                "occurrences": len(taken),
                "seconds": _seconds(graph, taken),
            }
            if path.symmetric or path.mirror_of is not None:
                facts["mirror_of"] = paths[path.id if path.mirror_of is None else path.mirror_of]
            ends = (path.to, path.from_) if backwards else (path.from_, path.to)
            yield _Edge(names[ends[0]], names[ends[1]], notation.BACKWARDS * backwards + path.label, facts)


def _seconds(graph: MotionGraph, stretches: tuple[Stay, ...] | list[Occurrence]) -> float:
    return float(sum((s.end - s.start) / graph.sources[s.source].fps for s in stretches))


def to_graphml(graph: MotionGraph) -> str:
    """GraphML of `to_networkx`: one edge a path and direction, all facts as attributes."""
    # networkx writes the same, but takes longer to import than all else here
    nodes, edges = list(_nodes(graph)), list(_edges(graph))
    keys: dict[tuple[str, str], str] = {}
    declared: list[str] = []

    def data(kind: str, facts: Mapping[str, Any]) -> Iterator[str]:
        for fact, value in facts.items():
            if (kind, fact) not in keys:
                keys[kind, fact] = f"d{len(keys)}"
                declared.append(
                    f'  <key id="{keys[kind, fact]}" for="{kind}" attr.name="{fact}" attr.type="{_GRAPHML_TYPES[type(value)]}"/>'
                )
            said = str(value).lower() if isinstance(value, bool) else escape(str(value))
            yield f'      <data key="{keys[kind, fact]}">{said}</data>'

    body: list[str] = []
    for name, facts in nodes:
        body += [f"    <node id={quoteattr(name)}>", *data("node", facts), "    </node>"]
    for edge in edges:
        ends = f"source={quoteattr(edge.from_)} target={quoteattr(edge.to)} id={quoteattr(edge.key)}"
        body += [f"    <edge {ends}>", *data("edge", edge.facts), "    </edge>"]
    lines = [
        '<?xml version="1.0" encoding="utf-8"?>',
        '<graphml xmlns="http://graphml.graphdrawing.org/xmlns" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
        'xsi:schemaLocation="http://graphml.graphdrawing.org/xmlns '
        'http://graphml.graphdrawing.org/xmlns/1.0/graphml.xsd">',
        *declared,
        '  <graph edgedefault="directed">',
        *body,
        "  </graph>",
        "</graphml>",
    ]
    return "\n".join(lines) + "\n"


def to_mermaid(graph: MotionGraph) -> str:
    """A Mermaid flowchart; reversible paths have two heads, inferred ones are dotted.

    States are drawn round, symmetric ones as a stadium; labels are those of people (`notation.pretty_label`).
    """
    lines = ["flowchart LR"]
    for state in graph.states:
        left, right = ("([", "])") if state.symmetric else ("((", "))")
        lines.append(f'  s{state.id}{left}"{_escaped(notation.pretty_label(state.label))}"{right}')
    for path in graph.paths:
        arrow = {
            (False, False): "-->",
            (True, False): "<-->",
            (False, True): "-.->",
            (True, True): "<-.->",
        }[path.reversible, path.inferred]
        lines.append(f'  s{path.from_} {arrow}|"{_escaped(notation.pretty_label(path.label))}"| s{path.to}')
    if not graph.states:
        lines.append(f'  none["{_EMPTY}"]')
    return "\n".join(lines) + "\n"


def _escaped(label: str) -> str:
    # Mermaid reads Markdown in labels: a star would begin italics
    return label.replace("*", "#42;")


def to_dict(graph: MotionGraph, information: Information | None = None) -> dict[str, Any]:
    """Plain JSON values: ``graph`` of `analysis.json`, and the sources.

    Parameters
    ----------
    information : measured on the way where it is not given.
    """
    known = information if information is not None else graph.information()
    return {
        "sources": [dataclasses.asdict(s) for s in graph.sources],
        "states": [
            {
                "id": s.id,
                "label": s.label,
                "symmetric": s.symmetric,
                "mirror_of": s.mirror_of,
                "stays": [dataclasses.asdict(r) for r in s.stays],
            }
            for s in graph.states
        ],
        "paths": [
            {
                "id": p.id,
                "label": p.label,
                "from": p.from_,
                "to": p.to,
                "index": p.index,
                "symmetric": p.symmetric,
                "reversible": p.reversible,
                "mirror_of": p.mirror_of,
                "inferred": p.inferred,
                "occurrences": [dataclasses.asdict(o) for o in p.occurrences],
            }
            for p in graph.paths
        ],
        "notation": graph.notation(),
        "information": known.to_dict(),
    }


def to_json(graph: MotionGraph) -> str:
    """The text of `to_dict`."""
    return json.dumps(to_dict(graph), ensure_ascii=False, indent=1, allow_nan=False) + "\n"


def from_json(text: str) -> MotionGraph:
    """The graph that `to_json` wrote.

    Raises
    ------
    InputError
        If the text is not JSON, or not of a graph.
    """
    try:
        values = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"The graph is not JSON: line {error.lineno}: {error.msg}.") from None
    return from_dict(values)


def from_dict(values: Mapping[str, Any]) -> MotionGraph:
    """The graph that `to_dict` wrote; keys that it does not know are passed over.

    Raises
    ------
    InputError
        If a key is missing, a value has the wrong type, or the graph is none; the message says where.
    """
    graph = MotionGraph(
        tuple(
            State(
                _get(v, "id", int, at),
                _get(v, "label", str, at),
                _get(v, "symmetric", bool, at),
                _optional(v, "mirror_of", at),
                tuple(Stay(*_stretch(r, place)) for r, place in _list(v, "stays", at)),
            )
            for v, at in _list(values, "states", "graph")
        ),
        tuple(
            Path(
                _get(v, "id", int, at),
                _get(v, "label", str, at),
                _get(v, "from", int, at),
                _get(v, "to", int, at),
                _get(v, "index", int, at),
                _get(v, "reversible", bool, at),
                _optional(v, "mirror_of", at),
                _get(v, "inferred", bool, at),
                tuple(
                    Occurrence(*_stretch(o, place), _get(o, "reversed", bool, place), _get(o, "complete", bool, place))
                    for o, place in _list(v, "occurrences", at)
                ),
                _get(v, "symmetric", bool, at),
            )
            for v, at in _list(values, "paths", "graph")
        ),
        tuple(
            Source(_get(v, "name", str, at), _get(v, "frames", int, at), _get(v, "fps", float, at))
            for v, at in _list(values, "sources", "graph")
        ),
    )
    if _get(values, "notation", str, "graph") != graph.notation():
        raise InputError("The notation of the graph does not agree with its states and paths.")
    return graph


def _list(values: object, key: str, at: str) -> list[tuple[Mapping[str, Any], str]]:
    found: list[Any] = _get(values, key, list, at)
    return [(v, f"{at}.{key}[{i}]") for i, v in enumerate(found)]


def _stretch(values: object, at: str) -> tuple[int, int, int]:
    return _get(values, "source", int, at), _get(values, "start", int, at), _get(values, "end", int, at)


def _optional(values: Mapping[str, Any], key: str, at: str) -> int | None:
    return None if values.get(key, ...) is None else _get(values, key, int, at)


def _get(values: object, key: str, kind: type[T], at: str) -> T:
    if not isinstance(values, Mapping):
        raise InputError(f"Expected an object at {at}, got {type(values).__name__}.")
    if key not in values:
        raise InputError(f"Expected the key '{key}' in {at}, found {', '.join(map(str, values)) or 'none'}.")
    value: Any = values[key]
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    # bool is an int to Python, not to JSON
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise InputError(f"Expected {kind.__name__} at {at}.{key}, got {type(value).__name__}.")
    return value

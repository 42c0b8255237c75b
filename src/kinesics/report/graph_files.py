"""The motion graph as GraphML, for networkx, Gephi, yEd and others."""

from __future__ import annotations

import io

from kinesics.analysis.facts import Graph


def graphml(graph: Graph) -> str:
    """A directed multigraph: a node a state, an edge a path, their facts as attributes; a valid file where there are none."""
    import networkx as nx  # type: ignore[import-untyped]

    out: nx.MultiDiGraph[int] = nx.MultiDiGraph()
    for state in graph.states:
        facts = {"label": state.label, "symmetric": state.symmetric, "stays": len(state.stays)}
        out.add_node(state.id, **facts, **_known(mirror_of=state.mirror_of))
    for path in graph.paths:
        facts = {
            "label": path.label,
            "index": path.index,
            "reversible": path.reversible,
            "inferred": path.inferred,
            "occurrences": len(path.occurrences),
        }
        out.add_edge(path.from_, path.to, key=path.id, **facts, **_known(mirror_of=path.mirror_of))
    stream = io.BytesIO()
    nx.write_graphml_xml(out, stream, encoding="utf-8", prettyprint=True)
    return stream.getvalue().decode()


def _known(**facts: int | None) -> dict[str, int]:
    """GraphML has no null: what is not known is left out."""
    return {k: v for k, v in facts.items() if v is not None}

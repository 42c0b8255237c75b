"""The motion graph as a file for other programs: GraphML, for networkx, Gephi, yEd and others."""

from __future__ import annotations

from kinesics.grammar.graph import MotionGraph


def graphml(graph: MotionGraph) -> str:
    """A directed multigraph: a node a state, an edge a path and direction; a valid file where there are none."""
    return graph.to_graphml()

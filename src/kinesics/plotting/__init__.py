"""Results in, matplotlib Axes out ([Schultz2012] §3.2-3.4, Figures 1-63 and 107).

- the plots of all pairs of moments: `similarity_plot` (square), `similarity_triangle` (time running right)
- long recordings without N×N: `pooled_similarity`, and `pool_maximum` for matrices that are there already
- bodies: `stick_figure`, `stick_figure_row`
- curves over time: `speed_plot`, `symmetry_plot`
- the motion path in the symmetry basis: `subspace_plot` (Figure 9), `composite_plot` (Figure 10)
- the motion graph: `graph_plot`, `state_moments`, `path_strips`, `state_margin` (Figures 64-71)
- what recurs: `motif_plot`
- what was performed: `trail_plot` (Figure 82), `contact_sheet`
- colours: `PALETTES`; files: `new_figure`, `save_figure`

Every function takes ``ax``; without it a new figure is made that pyplot never hears of, so nothing is left open.
matplotlib is imported on first use.
"""

from __future__ import annotations

from kinesics.plotting.canvas import new_figure, save_figure
from kinesics.plotting.composite import composite_plot, subspace_plot, symmetry_coordinates
from kinesics.plotting.contact_sheet import contact_sheet
from kinesics.plotting.curves import speed_plot, symmetry_plot
from kinesics.plotting.graph_drawing import graph_plot
from kinesics.plotting.graph_margin import state_margin
from kinesics.plotting.graph_moments import path_strips, state_moments
from kinesics.plotting.motif_rows import motif_plot
from kinesics.plotting.palettes import PALETTES, Palette, blend
from kinesics.plotting.pooling import PooledSimilarity, pool_maximum, pooled_similarity
from kinesics.plotting.scene import trail_plot
from kinesics.plotting.similarity_plots import figures_beneath, similarity_plot, similarity_triangle
from kinesics.plotting.stick_figures import stick_figure, stick_figure_row

__all__ = [
    "PALETTES",
    "Palette",
    "PooledSimilarity",
    "blend",
    "composite_plot",
    "contact_sheet",
    "figures_beneath",
    "graph_plot",
    "motif_plot",
    "new_figure",
    "path_strips",
    "pool_maximum",
    "pooled_similarity",
    "save_figure",
    "similarity_plot",
    "similarity_triangle",
    "speed_plot",
    "state_margin",
    "state_moments",
    "stick_figure",
    "stick_figure_row",
    "subspace_plot",
    "symmetry_coordinates",
    "symmetry_plot",
    "trail_plot",
]

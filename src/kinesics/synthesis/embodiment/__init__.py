"""How the chosen paths become one body on its feet: blended, planted, within its ranges, and checked.

- what is measured once: `stage`; the recordings with planted feet: `steady_feet`, `rehearsal`, and where those lead: `afoot`
- the performance: `rendering`, of `blending`, `planting`, `footing`, `inverse_kinematics`, `pelvis`, `ranges`, `arms`, `toes`
- what came of it: `checking`; beside the recordings: `quality`
"""

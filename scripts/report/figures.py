"""The figures of a result: what is drawn follows the name of a record, whatever the case.

One function per kind of plot, in the file of its subject; each returns a Figure that holds inline SVG.
"""

from report import bond, coupling, filament, fluid, peer, scene, solid, stability, studies
from report.drawing import Figure, inline_svg, quantity, stacked

MANY_ROWS, MANY_PANELS = 20000, 4  # beyond these a record without a plot of its own is not drawn


def against_first_column(result, record):
    """A record without a plot of its own: all columns against the first, one panel per dimension."""
    columns = [column for column in record.columns.values() if column.values.dtype.kind in "iuf"]
    if len(columns) < 2 or not 2 <= len(record) <= MANY_ROWS:
        return None
    first, rest = columns[0], columns[1:]
    groups = {}
    for column in rest:
        groups.setdefault(column.dimension, []).append(column)
    if len(groups) > MANY_PANELS:
        return None
    labelled = [
        (quantity("value", "", dimension), [(quantity(column.name.replace("_", " "), column.symbol, ""), column) for column in group])
        for dimension, group in groups.items()
    ]
    caption = record.title or record.name
    return Figure(caption, inline_svg(stacked(first, labelled), caption))


# Kinds of plot by the name of the record, in the order of the page. Validity is a table, and the bands of the others;
# `stroke_compared` is in the figure of `stroke`.
KINDS = {
    "potential": (bond.potential_energy, bond.tension),
    "stress_strain": (bond.stress_strain, bond.curve_error, bond.moduli, bond.moduli_near_rest),
    "moduli": (bond.moduli, bond.moduli_near_rest),
    "root_search": (bond.root_search,),
    "convergence": (fluid.convergence,),
    "delta_sums": (coupling.delta_scan,),
    "delta_imbalances": (coupling.delta_scan,),
    "delta_first_moments": (coupling.delta_scan,),
    "elastica": (solid.elastica,),
    "elastica_exact": (),
    "profile": (fluid.profile,),
    "section": (fluid.section,),
    "drift": (fluid.drift,),
    "bond_table": (peer.bond_table,),
    "angle_table": (peer.angle_table,),
    "node_forces": (peer.node_forces,),
    "end_force": (peer.end_force,),
    "cantilever": (peer.cantilever,),
    "trajectory": (peer.trajectory,),
    "energy": (peer.energy,),
    "centre_lines": (filament.centre_lines,),
    "law_deviation": (filament.law_deviation,),
    "stroke": (filament.stroke,),
    "stroke_compared": (),
    "film": (filament.film,),
    "first_harmonic": (filament.first_harmonic,),
    "sensitivity": (filament.sensitivity,),
    "last_good_nodes": (coupling.last_good_nodes,),
    "spectrum": (coupling.spectrum,),
    "strain_histogram": (filament.strain_histogram,),
    "modulus_deviation": (filament.modulus_deviation,),
    "array": (coupling.array_drag,),
    "rod": (coupling.rod_force,),
    "deflection": (coupling.beam_line,),
    "buckling_mode": (coupling.buckling_mode,),
    "buckling_growth": (coupling.buckling_share,),
    "thrust_law": (coupling.thrust_law,),
    "thrust_stroke": (coupling.thrust_stroke,),
    "validity": (),
    "sweep": (solid.buckling, solid.standing_waves, coupling.buckling_growth, studies.sweep),
    "sweep_cost": (studies.sweep_cost,),
    "sweep_front": (studies.front,),
    "sweep_cost_front": (studies.front,),
    "outcome_boundary": (stability.stiffness_limit,),
    "outcome_boundary_rows": (),
    "outcome_boundary_cost": (),
    "ablate": (coupling.coupling_boundary,),
    "ablate_difference": (studies.ablate_difference,),
    "ablate_parts": (),
    "ablate_cost": (),
}


def is_table(name):
    """Whether a record is read as a table only."""
    return name.startswith("orders_along_") or name.endswith(("_settings", "_reached"))


def of_case(result):
    """All figures of a result."""
    figures = []
    order = {name: place for place, name in enumerate(KINDS)}
    for record in sorted(result.records.values(), key=lambda record: order.get(record.name, len(order))):
        kinds = KINDS.get(record.name, (against_first_column,))
        if "other_code" in result.provenance:  # its records are called as the case calls them
            kinds = (against_first_column,)
        elif is_table(record.name):
            kinds = ()
        elif studies.is_curve_of_numbers(record):
            kinds = (studies.curve_of_numbers,)
        elif result.driver == "scene" and record.name not in KINDS:
            kinds = scene.kinds(result, record)
        for draw in kinds:
            drawn = draw(result, record)
            if drawn is not None:
                figures.append(drawn)
    return figures

"""Figures of the fluid: convergence, error against run time, profiles, drag, conservation."""

import numpy as np
from matplotlib.lines import Line2D

from report.drawing import (
    Figure,
    MANY_CURVES,
    MARK,
    canvas,
    column_label,
    drawable,
    inline_svg,
    known,
    label_points,
    legend_above,
    markers,
    quantity,
)


def convergence(result, record, key):
    """Every column error_<name> against the first column, log-log, with the measured order (metric order_<name>)."""
    errors = [name for name in record.columns if name.startswith("error_")]
    # Many curves get a panel for each quantity, the first word of their names.
    quantities = {name.split("_")[1]: None for name in errors} if len(errors) > MANY_CURVES else {"": None}
    if not errors:
        return None
    legend_rows = len(errors) + len(quantities)  # names are long: one row each
    drawing, panels = canvas(len(quantities), height=2.0 * len(quantities) + 0.6 + 0.18 * legend_rows)
    first = next(iter(record.columns.values()))
    drawn = [
        converging(axes, result, record, first, [name for name in errors if name.startswith(f"error_{word}")])
        for axes, word in zip(panels, quantities)
    ]
    if not any(drawn):
        return None
    panels[-1].set_xlabel(column_label(first))
    caption = "Convergence; dotted: the slope of the nearest whole order, below its curve."
    return Figure(caption, inline_svg(drawing, key, caption))


def converging(axes, result, record, first, errors):
    """One panel of convergence(); whether there is anything to see."""
    handles = []
    for number, (name, marker) in enumerate(zip(errors, markers())):
        drawn = (record[name] > 0) & (first.values > 0) & np.isfinite(record[name])
        steps, values = first.values[drawn], record[name][drawn]
        if not len(steps):
            continue
        order = known(result, name.replace("error_", "order_", 1))
        label = name.removeprefix("error_").replace("_", " ")
        label += f": order {order:.3f}" if order is not None else ""
        colour = f"C{number}"
        handles += axes.plot(steps, values, marker + "-", color=colour, label=label)
        if order is not None and round(order) != 0:
            coarsest = steps.argmax()
            guide = 0.4 * values[coarsest] * (steps / steps[coarsest]) ** round(order)
            axes.plot(steps, guide, ":", color=colour, linewidth=1)
    if not handles:
        return False
    axes.set_xscale("log")
    axes.set_yscale("log")
    label_points(axes, np.unique(np.concatenate([line.get_xdata() for line in handles])))
    smallest = min(np.min(line.get_ydata()) for line in handles)
    largest = max(np.max(line.get_ydata()) for line in handles)
    axes.set_ylim(smallest / 5, largest * 5)  # guides go on below round-off
    axes.set_ylabel("relative error [1]")
    handles.append(Line2D([], [], linestyle=":", color="#555555", linewidth=1, label="nearest whole order"))
    legend_above(axes, handles)
    return True


def work_precision(result, record, key):
    """Error of each row against its run time, the timing phase `work_precision/<row>`, and against the first column.

    Both are log-log, with a curve for each value of the column `bits` where there is one.
    """
    if record.has("steps_per_period"):
        return None  # see period_precision
    resolution = next(iter(record.columns.values()))
    if not drawable(record, resolution.name, "error"):
        return None
    times = {row["phase"]: row["wall_seconds"] for row in result.timing}
    seconds = np.array([times.get(f"work_precision/{row}", np.nan) for row in range(len(record))])
    error, steps = record["error"], resolution.values
    bits = record["bits"] if record.has("bits") else np.zeros(len(record))
    drawn = (error > 0) & (seconds > 0)
    if record.has("plane"):
        drawn &= record["plane"] == record["plane"][0]
    if not drawn.any():
        return None
    drawing, axes = canvas(panels=2, height=5.2)
    handles = []
    for number, (kind, marker) in enumerate(zip(np.unique(bits)[::-1], markers())):
        rows = np.flatnonzero(drawn & (bits == kind))
        style = dict(color=f"C{number}", marker=marker, linestyle="-", label=f"{kind:.0f} bits")
        handles += axes[0].plot(1000 * seconds[rows], error[rows], **style)
        axes[1].plot(steps[rows], error[rows], **(style | dict(linestyle=("-", "--")[number % 2])))
        if number == 0:
            for x, y, label in zip(1000 * seconds[rows], error[rows], steps[rows]):
                axes[0].annotate(f"{label:.0f}", (x, y), xytext=(5, 4), textcoords="offset points", fontsize=7)
    rows = np.flatnonzero(drawn)
    fewest = rows[steps[rows].argmin()]
    guide = np.unique(steps[rows])
    axes[1].plot(guide, 0.4 * error[fewest] * (guide / steps[fewest]) ** -2, ":", color="#555555", linewidth=1)
    for panel in axes:
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_ylabel("relative error [1]")
        panel.margins(x=0.12, y=0.15)
    label_points(axes[1], guide)
    axes[0].set_xlabel(f"run time of the row [ms]; labels: {resolution.name.replace('_', ' ')}")
    axes[1].set_xlabel(column_label(resolution))
    if len(handles) > 1:
        legend_above(axes[0], handles)
    caption = "What accuracy a second of computing buys; dotted: second order. One run each: read the times to a factor of two."
    return Figure(caption, inline_svg(drawing, key, caption))


def dispersion(result, record, key):
    """Factor per step of waves over the continuum's, measured and by eigenvalue, for each relaxation time."""
    if not drawable(record, "relaxation_time", "wavenumber", "decay_rate", "decay_rate_exact", "decay_rate_continuum"):
        return None
    shown = [("decay_rate", "decay rate over νk²")]
    if record.has("frequency", "frequency_exact", "frequency_continuum"):
        shown.insert(0, ("frequency", "speed over 1/√3"))
    drawing, panels = canvas(len(shown), height=1.0 + 2.7 * len(shown), sharex=True)
    handles = []
    for axes, (name, label) in zip(panels, shown):
        for number, (tau, marker) in enumerate(zip(np.unique(record["relaxation_time"]), markers())):
            rows = record["relaxation_time"] == tau
            k, scale = record["wavenumber"][rows], record[f"{name}_continuum"][rows]
            style = dict(color=f"C{number}", label=f"τ = {tau:g}")
            axes.plot(k, record[f"{name}_exact"][rows] / scale, "-", **style)
            points = axes.plot(k, record[name][rows] / scale, marker, mfc="none", **style)
            handles += points if axes is panels[0] else []
        axes.axhline(1, **MARK)
        axes.set_ylabel(quantity(label, "", "1"))
    panels[-1].set_xlabel(column_label(record.columns["wavenumber"]))
    legend_above(panels[0], handles)
    caption = "Waves over what the continuum says: marks measured, lines the eigenvalues of the lattice's own step."
    return Figure(caption, inline_svg(drawing, key, caption))


def constants(result, record, key):
    """Leading errors against the relaxation time, with reference points; below, what Richardson's limit is off by."""
    quantities = [name.removeprefix("constant_") for name in record.columns if name.startswith("constant_")]
    if not quantities or not drawable(record, "relaxation_time"):
        return None
    drawing, panels = canvas(2, height=5.0, sharex=True)
    tau = record["relaxation_time"]
    handles, below = [], []
    for number, (name, marker) in enumerate(zip(quantities, markers())):
        style = dict(color=f"C{number}", linestyle="-")
        handles += panels[0].plot(tau, record[f"constant_{name}"], label=f"{name}, measured", **style)
        for reference in result.references:
            if drawable(reference.columns, "relaxation_time", f"constant_{name}"):
                points = reference.columns
                handles += panels[0].plot(
                    points["relaxation_time"], points[f"constant_{name}"], marker, mfc="none", color=f"C{number}",
                    label=f"{name}, {reference.kind}",
                )  # fmt: skip
        off = np.abs(record[f"extrapolated_{name}"] - 1)
        below += panels[1].semilogy(tau, off, marker=marker, label=f"{name}: limit off by", **style)
        below += panels[1].semilogy(
            tau, record[f"gci_{name}"], label=f"{name}: convergence index", **(style | dict(linestyle="--"))
        )
    panels[0].axhline(0, **MARK)
    panels[0].set_ylabel(quantity("leading error", "C", "L^2"))
    panels[1].set_ylabel("relative error [1]")
    panels[1].set_xlabel(column_label(record.columns["relaxation_time"]))
    legend_above(panels[0], handles)
    legend_above(panels[1], below)
    caption = "Leading error, value/continuum = 1 + C k²; below, extrapolated limit and grid convergence index of the finest grid."
    return Figure(caption, inline_svg(drawing, key, caption))


def storage(result, record, key):
    """Discretisation and storage error against the resolution, log-log."""
    if not drawable(record, "nodes", "discretisation_error", "storage_error"):
        return None
    drawing, (axes,) = canvas()
    labels = {"discretisation_error": "double against the exact solution", "storage_error": "float against double"}
    handles = []
    for (name, label), marker in zip(labels.items(), markers()):
        handles += axes.loglog(record["nodes"], record[name], marker=marker, linestyle="-", label=label)
    label_points(axes, np.unique(record["nodes"]))
    axes.set_xlabel(column_label(record.columns["nodes"]))
    axes.set_ylabel("relative error, L2 [1]")
    legend_above(axes, handles)
    caption = "What storing populations in float adds to the error, beside that of the grid."
    return Figure(caption, inline_svg(drawing, key, caption))


def galilean(result, record, key):
    """Loss of viscosity against the speed of the stream, log-log."""
    if not drawable(record, "speed", "error", "error_exact", "error_theory"):
        return None
    drawing, (axes,) = canvas()
    speed = record["speed"]
    handles = axes.loglog(speed, record["error"], "o", mfc="none", label="measured")
    handles += axes.loglog(speed, record["error_exact"], "-", label="eigenvalue around the stream")
    handles += axes.loglog(speed, record["error_theory"], "--", label="long waves, 3 (U·k)²/k²")
    label_points(axes, speed)
    axes.set_xlabel(column_label(record.columns["speed"]))
    axes.set_ylabel("relative loss of viscosity [1]")
    legend_above(axes, handles)
    caption = "Viscosity that a stream through the lattice takes away."
    return Figure(caption, inline_svg(drawing, key, caption))


def pairs(record):
    """Names of columns that have an exact counterpart `<name>_exact`."""
    return [name for name in record.columns if name + "_exact" in record.columns]


def profile(result, record, key):
    """Profiles (points) and exact ones (lines) against the first column; below, their difference."""
    names = pairs(record)
    if not names or len(record) < 2:
        return None
    drawing, (above, below) = canvas(2, height=4.6, sharex=True, gridspec_kw={"height_ratios": (3, 2)})
    place = next(iter(record.columns.values()))
    handles = []
    for number, (name, marker) in enumerate(zip(names, "osD^vx")):
        colour = f"C{number}"
        exact = record[name + "_exact"]
        above.plot(place.values, exact, color=colour, linestyle="-", linewidth=1)
        label = quantity(name.replace("_", " "), record.columns[name].symbol, "")
        style = dict(color=colour, marker=marker, markersize=3.5, markerfacecolor="none")
        handles += above.plot(place.values, record[name], linestyle="none", label=label, **style)
        below.plot(place.values, record[name] - exact, linestyle="-", linewidth=0.8, **style)
    handles.append(Line2D([], [], color="#555555", linestyle="-", linewidth=1, label="exact"))
    below.axhline(0, **MARK)
    below.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3), useMathText=True)
    above.set_ylabel("velocity over its scale [1]")
    below.set_ylabel("difference [1]")
    below.set_xlabel(column_label(place))
    legend_above(above, handles)
    caption = f"{record.title}; below, the difference to the exact one."
    return Figure(caption, inline_svg(drawing, key, caption))


def slip(result, record, key):
    """Slip at the wall against the relaxation time."""
    if not drawable(record, "relaxation_time", "slip_first_order", "slip_guo", "slip_exact", "slip_bare"):
        return None
    drawing, (axes,) = canvas()
    tau = record["relaxation_time"]
    handles = axes.plot(tau, record["slip_exact"], color="C0", linestyle="-", label="exact")
    open_style = dict(linestyle="none", markerfacecolor="none")
    label = "first order, Σ f c + g/2"
    handles += axes.plot(tau, record["slip_first_order"], "o", color="C0", label=label, **open_style)
    handles += axes.plot(tau, record["slip_guo"], "x", color="C1", label="Guo, Σ f c + g/2", **open_style)
    handles += axes.plot(tau, record["slip_bare"], "s", color="C2", label="bare Σ f c", **open_style)
    axes.axhline(0, **MARK)
    axes.set_xlabel(column_label(record.columns["relaxation_time"]))
    axes.set_ylabel("slip over force [T]")
    legend_above(axes, handles)
    caption = "Slip of half-way bounce-back over the force; where it is zero, the wall sits half-way."
    return Figure(caption, inline_svg(drawing, key, caption))


def section(result, record, key):
    """Velocity in a square section: measured as colours, exact as lines of the same levels."""
    side = round(len(record) ** 0.5)
    if not drawable(record, "y", "z", "velocity", "velocity_exact") or side * side != len(record):
        return None
    drawing, (axes,) = canvas(height=4.0)
    grid = [record[name].reshape(side, side) for name in ("y", "z", "velocity", "velocity_exact")]
    levels = np.linspace(0, 1, 11)
    drawn = axes.contourf(*grid[:3], levels=levels, cmap="Blues", extend="max")
    axes.contour(grid[0], grid[1], grid[3], levels=levels[1:-1], colors="#222222", linewidths=0.7)
    axes.set_aspect("equal")
    axes.set_xlabel(column_label(record.columns["y"]))
    axes.set_ylabel(column_label(record.columns["z"]))
    drawing.colorbar(drawn, ax=axes, label=column_label(record.columns["velocity"]))
    caption = f"{record.title}: measured (colours) and exact (lines, at the edges of the colours)."
    return Figure(caption, inline_svg(drawing, key, caption))


def drag(result, record, key):
    """Drag of an array against the resolution; below, what size of obstacle it is the drag of."""
    if not drawable(record, "nodes", "drag", "drag_exact", "drag_of_voxels", "voxels_larger", "drag_larger"):
        return None
    drawing, (above, below) = canvas(2, height=5.0, sharex=True)
    nodes = record["nodes"]
    handles = above.plot(nodes, record["drag"], "o-", color="C0", label="measured")
    handles += above.plot(nodes, record["drag_exact"], "-", color="#222222", linewidth=1, label="exact")
    of_voxels = dict(linestyle="--", marker="s", color="C1", markerfacecolor="none")
    handles += above.plot(nodes, record["drag_of_voxels"], label="exact, volume of the voxels", **of_voxels)
    above.set_ylabel(column_label(record.columns["drag"]))
    legend_above(above, handles)
    handles = below.plot(nodes, record["drag_larger"], "o-", color="C0", label="as the drag says")
    handles += below.plot(nodes, record["voxels_larger"], label="as the voxels' volume says", **of_voxels)
    below.axhline(0, **MARK)
    below.set_ylim(-0.5, 0.5)
    below.set_ylabel("radius beyond the true one [L]")
    below.set_xlabel("nodes across a cell [1]")
    legend_above(below, handles)
    caption = "Drag against resolution, and the radius that explains it: a staircase is off by a fraction of a spacing."
    return Figure(caption, inline_svg(drawing, key, caption))


def drift(result, record, key):
    """What should not change, against time: every column, logarithmic."""
    first, *runs = record.columns.values()
    drawing, (axes,) = canvas(height=3.5)
    handles = []
    for number, column in enumerate(runs):
        # A logarithm has no place for what did not change at all.
        values = np.where(column.values > 0, column.values, np.nan)
        style = dict(marker=".", color=f"C{number}", linestyle="-", linewidth=0.9)
        handles += axes.plot(first.values, values, label=column.name.replace("_", " "), **style)
    axes.set_yscale("log")
    axes.set_xlabel(column_label(first))
    axes.set_ylabel(quantity("departure per node", "", runs[0].dimension))
    legend_above(axes, handles)
    return Figure(record.title + ".", inline_svg(drawing, key, record.title))


def conservation(result, record, key):
    """What leap-frog keeps, against the time step, log-log: energy to second order, the rest to round-off."""
    if not drawable(record, "dt_over_limit", "energy", "momentum", "angular_momentum", "reversal"):
        return None
    drawing, (axes,) = canvas()
    step, handles = record["dt_over_limit"], []
    for name, marker in zip(("energy", "momentum", "angular_momentum", "reversal"), "os^D"):
        shown = np.maximum(record[name], 2.0**-54)  # a logarithm has no place for what is kept to the last bit
        handles += axes.plot(step, shown, marker + "-", label=name.replace("_", " "))
    axes.set_xscale("log")
    axes.set_yscale("log")
    label_points(axes, step)
    axes.set_xlabel("time step over the linear limit [1]")
    axes.set_ylabel("largest relative departure [1]")
    legend_above(axes, handles)
    caption = "What a free body keeps during a run, over the time step; no departure is drawn as 2⁻⁵⁴."
    return Figure(caption, inline_svg(drawing, key, caption))

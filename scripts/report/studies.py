"""Figures of studies over a case: sweeps, boundaries of outcomes, ablations."""

import re

import numpy as np
from matplotlib.lines import Line2D

from report.drawing import MARK, Figure, canvas, column_label, drawable, inline_svg, label_points, legend_above, markers

MANY_METRICS, MANY_LINES = 4, 8  # panels of a figure, curves of a panel
WORDS_OF_ERRORS = ("error", "departure", "deviation", "difference")
NORM = re.compile(r"_(l1|l2|linf)$")


def parts(record):
    """Columns of a study's table: its axes, what was measured, which rows are complete."""
    names = list(record.columns)
    outcome, work = names.index("outcome"), names.index("node_updates")
    return names[:outcome], names[outcome + 1 : work], record["outcome"] == "completed"


def is_number(record, name):
    return record[name].dtype.kind in "iuf"


def errors_of(metrics):
    """What is an error by its name, those called so first."""
    found = [m for m in metrics if any(word in m for word in WORDS_OF_ERRORS)]
    return sorted(found, key=lambda name: not name.startswith("error"))


def asked(result, metrics):
    """The metrics worth a panel: those that a check names, errors, else the first; exact ones go with their own."""
    metrics = [m for m in metrics if not (m.endswith("_exact") and m.removesuffix("_exact") in metrics)]
    named = [m for m in metrics if any(names(check.metric, m) for check in result.checks)]
    return list(dict.fromkeys(named + errors_of(metrics) or metrics))


def names(question, metric):
    """Whether `order(error_l2) at ...` asks for that metric."""
    return re.search(rf"(?<![\w.]){re.escape(metric)}(?![\w.])", question) is not None


def in_panels(metrics):
    """Metrics by panel: norms of one error share one."""
    panels = {}
    for metric in metrics:
        panels.setdefault(NORM.sub("", metric), []).append(metric)
    return list(panels.items())[:MANY_METRICS]


def order_guide(panel, x, values):
    """Dotted, the slope of the nearest whole order between the two last points, below its curve."""
    drawn = (x > 0) & (values > 0)
    x, values = x[drawn], values[drawn]
    if len(x) < 2 or panel.get_xscale() != "log" or panel.get_yscale() != "log":
        return
    slope = round(np.log(values[-1] / values[-2]) / np.log(x[-1] / x[-2])) if x[-1] != x[-2] else 0
    if slope != 0:
        panel.plot(x, 0.5 * values[-1] * (x / x[-1]) ** slope, ":", color="#555555", linewidth=1)


def lines(record, axes, x):
    """Rows that differ along one axis only, with a label that says where the others stand."""
    others = [name for name in axes if name != x]
    groups = {}
    for row in range(len(record)):
        where = tuple(record[name][row] for name in others)
        groups.setdefault(where, []).append(row)
    for where, rows in groups.items():
        values = (f"{v:.6g}" if isinstance(v, float) else str(v).strip('"') for v in where)
        label = ", ".join(f"{name.split('.')[-1].replace('_', ' ')} {value}" for name, value in zip(others, values))
        yield label, np.array(rows)


def scale(axes, x, y):
    """Logarithmic where all is positive and spans more than a factor of five."""
    for values, put in ((x, axes.set_xscale), (y, axes.set_yscale)):
        finite = values[np.isfinite(values)]
        if finite.size and finite.min() > 0 and finite.max() > 5 * finite.min():
            put("log")


def curves(record, chosen, x_name, x, caption):
    """A panel per metric: it against x, a curve for each value of the other axes."""
    axes, _, complete = parts(record)
    chosen = in_panels([m for m in chosen if np.isfinite(record[m]).sum() >= 2])
    if not chosen:
        return None
    drawing, panels = canvas(len(chosen), height=1.3 + 2.2 * len(chosen), sharex=True)
    handles = []
    for panel, (stem, metrics) in zip(panels, chosen):
        own = []
        for number, ((label, rows), marker) in enumerate(zip(list(lines(record, axes, x_name))[:MANY_LINES], markers())):
            order = rows[np.argsort(x[rows], kind="stable")]
            for metric, style in zip(metrics, ("-", "--", "-.")):
                (handle,) = panel.plot(x[order], record[metric][order], marker + style, color=f"C{number}", label=label)
                if len(metrics) > 1 and number == 0:
                    own.append(Line2D([], [], linestyle=style, color="#555555", label=metric.removeprefix(stem).strip("_")))
                if metric + "_exact" in record.columns:
                    panel.plot(x[order], record[metric + "_exact"][order], "-", color="#222222", linewidth=0.7, zorder=1)
                if panel is panels[0] and label and metric == metrics[0]:
                    handles.append(handle)
        scale(panel, x, np.concatenate([record[metric] for metric in metrics]))
        _, rows = next(lines(record, axes, x_name))
        if stem.startswith("error"):
            order_guide(panel, x[rows], record[metrics[0]][rows])
        title = column_label(record.columns[metrics[0]]) if len(metrics) == 1 else f"{stem.strip('_').replace('_', ' ')} [1]"
        exact = ", thin: exact" if any(metric + "_exact" in record.columns for metric in metrics) else ""
        panel.set_title(title + exact, loc="left", fontsize="small")
        panel.margins(x=0.06, y=0.12)
        if own:
            panel.add_artist(panel.legend(handles=own, loc="best"))
    for row in np.flatnonzero(~complete & np.isfinite(x)):
        panels[-1].annotate("×", (x[row], 0), xycoords=("data", "axes fraction"), ha="center", color="#B03030")
    if panels[-1].get_xscale() == "log":
        label_points(panels[-1], np.unique(x[np.isfinite(x)]))
    if handles:
        panels[0].legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1.12), ncol=1 if len(handles) > 4 else 2)
    lost = int((~complete).sum())
    if lost:
        caption += f" × marks {lost} of {len(record)} runs that did not complete; see the table."
    return panels, drawing, caption


def sweep(result, record, key):
    """Metrics along the last axis of numbers."""
    axes, metrics, _ = parts(record)
    along = [name for name in axes if is_number(record, name) and len(set(record[name])) > 1]
    if not along:
        return None
    x = record.columns[along[-1]]
    drawn = curves(record, asked(result, metrics), x.name, x.values, f"{record.title}.")
    if drawn is None:
        return None
    panels, drawing, caption = drawn
    panels[-1].set_xlabel(x.name.replace("_", " "))
    return Figure(caption, inline_svg(drawing, key, caption))


def sweep_cost(result, record, key):
    """Errors against run time; of rows that ran side by side the first error only."""
    table = result.records.get("sweep")
    if table is None:
        return None
    axes, metrics, _ = parts(table)
    along = [name for name in axes if is_number(table, name) and len(set(table[name])) > 1]
    in_turn = "one after another" in record.title
    how = "One run each" if in_turn else "Runs side by side, with one thread each"
    caption = f"What accuracy a second of computing buys. {how}: read the times to a factor of two."
    x_name = along[-1] if along else axes[-1]
    drawn = curves(table, errors_of(metrics)[: MANY_METRICS if in_turn else 1], x_name, record["wall_seconds"], caption)
    if drawn is None:
        return None
    panels, drawing, caption = drawn
    panels[-1].set_xlabel("run time of the row [s]")
    return Figure(caption, inline_svg(drawing, key, caption))


def is_curve_of_numbers(record):
    """Whether it is what a check of a study asks for, such as `richardson(viscosity)`."""
    return "(" in record.name


def curve_of_numbers(result, record, key):
    """One number of a study for each value of an axis, beside its reference."""
    x, y = record.columns.values()
    drawing, (axes,) = canvas()
    handles = axes.plot(x.values, y.values, "o", mfc="none", label=record.name)
    for reference in result.references:
        if drawable(reference.columns, x.name, y.name):
            points = reference.columns
            handles += axes.plot(points[x.name], points[y.name], "-", color="#222222", linewidth=0.8, label=reference.kind)
    axes.axhline(0, **MARK)
    axes.set_xlabel(x.name.replace("_", " "))
    axes.set_ylabel(column_label(y))
    legend_above(axes, handles)
    caption = f"{record.title}."
    return Figure(caption, inline_svg(drawing, key, caption))


def outcome_boundary(result, record, key):
    """Where the outcome changes, along the last axis of numbers."""
    names = list(record.columns)
    axes = names[: names.index("boundary")]
    along = [name for name in axes if is_number(record, name) and len(set(record[name])) > 1]
    if not along or np.isfinite(record["boundary"]).sum() < 2:
        return None
    x = record.columns[along[-1]]
    drawing, (panel,) = canvas()
    handles = []
    for number, ((label, rows), marker) in enumerate(zip(list(lines(record, axes, x.name))[:MANY_LINES], markers())):
        middle, before, behind = (record[name][rows] for name in ("boundary", "before", "behind"))
        handles.append(
            panel.errorbar(
                x.values[rows], middle, yerr=np.abs(behind - before) / 2, fmt=marker + "-", color=f"C{number}", label=label
            )
        )
    scale(panel, x.values, record["boundary"])
    panel.set_xlabel(x.name.replace("_", " "))
    panel.set_ylabel("boundary")
    panel.margins(x=0.06, y=0.12)
    if len(handles) > 1:
        legend_above(panel, handles)
    caption = f"{record.title}; bars: between the two runs that bracket it."
    return Figure(caption, inline_svg(drawing, key, caption))


def ablate_difference(result, record, key):
    """How far each variant moves each metric, the most moved first."""
    size = np.abs(record["relative_difference"])
    # What is rounding beside other metrics of the case moves by any factor.
    largest = np.nanmax(np.abs(record["of_case"]), initial=0.0)
    moved = {}
    for metric, value, of_case in zip(record["metric"], size, np.abs(record["of_case"])):
        if np.isfinite(value) and of_case > 1e-9 * largest:
            moved[metric] = max(moved.get(metric, 0.0), value)
    metrics = sorted((m for m in moved if moved[m] > 0), key=moved.get)[-12:]
    if not metrics:
        return None
    variants = list(dict.fromkeys(record["variant"]))
    drawing, (panel,) = canvas(height=1.0 + 0.26 * len(metrics) + 0.16 * len(variants))
    handles = []
    for number, (variant, marker) in enumerate(zip(variants, markers())):
        at = {m: v for m, v, whose in zip(record["metric"], size, record["variant"]) if whose == variant}
        places = [(at[m], i) for i, m in enumerate(metrics) if at.get(m, 0) > 0]
        xs, ys = ([p[k] for p in places] for k in (0, 1))
        handles += panel.plot(xs, ys, marker, color=f"C{number}", label=str(variant))
    panel.set_xscale("log")
    panel.set_yticks(range(len(metrics)), [m.replace("_", " ") for m in metrics])
    panel.set_xlabel("relative difference [1]")
    panel.grid(axis="y", linewidth=0.4)
    legend_above(panel, handles, ordinate=130)
    caption = "How far each variant moves the metrics of the case; what it does not move is not shown."
    return Figure(caption, inline_svg(drawing, key, caption))

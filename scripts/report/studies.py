"""Figures of studies over a case: sweeps, boundaries of outcomes, ablations."""

import numpy as np

from report.drawing import Figure, canvas, column_label, inline_svg, label_points, legend_above, markers

MANY_METRICS, MANY_LINES = 4, 8  # panels of a figure, curves of a panel
WORDS_OF_ERRORS = ("error", "departure", "deviation", "difference")


def parts(record):
    """Columns of a study's table: its axes, what was measured, which rows are complete."""
    names = list(record.columns)
    outcome, work = names.index("outcome"), names.index("node_updates")
    return names[:outcome], names[outcome + 1 : work], record["outcome"] == "completed"


def is_number(record, name):
    return record[name].dtype.kind in "iuf"


def errors_of(metrics):
    return [m for m in metrics if any(word in m for word in WORDS_OF_ERRORS)]


def asked(result, metrics):
    """The metrics worth a panel: errors, those that a check names, else the first."""
    named = [m for m in metrics if any(m in check.metric for check in result.checks)]
    return list(dict.fromkeys(named + errors_of(metrics) or metrics))[:MANY_METRICS]


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
    chosen = [m for m in chosen if np.isfinite(record[m]).sum() >= 2]
    if not chosen:
        return None
    drawing, panels = canvas(len(chosen), height=1.3 + 2.2 * len(chosen), sharex=True)
    handles = []
    for panel, metric in zip(panels, chosen):
        for number, ((label, rows), marker) in enumerate(zip(list(lines(record, axes, x_name))[:MANY_LINES], markers())):
            order = rows[np.argsort(x[rows], kind="stable")]
            (handle,) = panel.plot(x[order], record[metric][order], marker + "-", color=f"C{number}", label=label)
            if panel is panels[0] and label:
                handles.append(handle)
        scale(panel, x, record[metric])
        panel.set_title(column_label(record.columns[metric]), loc="left", fontsize="small")
        panel.margins(x=0.06, y=0.12)
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
    """Errors against run time, where rows ran one after another."""
    table = result.records.get("sweep")
    if table is None or "one after another" not in record.title:
        return None
    axes, metrics, _ = parts(table)
    along = [name for name in axes if is_number(table, name) and len(set(table[name])) > 1]
    caption = "What accuracy a second of computing buys. One run each: read the times to a factor of two."
    x_name = along[-1] if along else axes[-1]
    drawn = curves(table, errors_of(metrics)[:MANY_METRICS], x_name, record["wall_seconds"], caption)
    if drawn is None:
        return None
    panels, drawing, caption = drawn
    panels[-1].set_xlabel("run time of the row [s]")
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
